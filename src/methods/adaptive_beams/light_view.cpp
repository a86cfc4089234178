#include "methods/adaptive_beams/light_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "light/beam_axes.h"
#include "light/map_plan.h"
#include "optics/optics.h"
#include "rays/shape_mesh.h"
#include "scene/area_light.h"
#include "scene/transform.h"

namespace dapple::methods::adaptive_beams {
namespace {

/// A pyramid of rays reaches at most this far from its axis: beyond, equal steps of (u, v) are angles that
/// differ by more than cos^2 = 1 : 15.
constexpr double kWidestView = 75 * scene::kDegree;
/// Share of its size by which a view is wider than its body: a little narrower, so that the outermost rays of
/// a pool meet it. 4e-6 of its light are left out.
constexpr double kRoom = -1e-6;

BodyHull hull_of_water(const scene::FrameScene& scene) {
    BodyHull body;
    if (!scene.water) return body;
    for (const glm::dvec3& point : scene.water->mesh.positions) {
        const glm::dvec3 relative = point - scene.origin;
        if (glm::dot(relative, relative) < std::numeric_limits<double>::infinity())
            body.points.push_back(relative);
    }
    return body;
}

BodyHull hull_of_object(const scene::FrameScene& scene, std::size_t i) {
    BodyHull body;
    const scene::Object& object = scene.state.objects[i];
    const glm::dmat4 matrix = scene::relative_from_object(object.transform, scene.origin);
    if (object.shape == scene::Shape::sphere) {
        body.round = true;
        body.center = glm::dvec3(matrix[3]);
        body.offset_from_unit = glm::dmat3(matrix) * object.radius;
        return body;
    }
    const auto place = [&](const scene::TriangleMesh& mesh) {
        for (const glm::dvec3& point : mesh.positions)
            body.points.emplace_back(matrix * glm::dvec4(point, 1));
    };
    if (object.shape == scene::Shape::mesh) {
        if (i < scene.object_meshes.size() && scene.object_meshes[i]) place(*scene.object_meshes[i]);
    } else {
        place(object.shape == scene::Shape::box ? rays::box_mesh(object.size)
                                                : rays::plane_mesh(object.size));
    }
    return body;
}

/// Least and greatest tangents of the body's directions from a lamp towards `across`, about `axis`. False
/// where some direction is farther from the axis than kWidestView.
bool tangents(const BodyHull& body, glm::dvec3 position, glm::dvec3 axis, glm::dvec3 across,
              glm::dvec2& range) {
    if (!body.round) {
        range = {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
        for (const glm::dvec3& point : body.points) {
            const glm::dvec3 way = point - position;
            const double ahead = glm::dot(way, axis);
            if (!(ahead > std::cos(kWidestView) * glm::length(way))) return false;
            const double tangent = glm::dot(way, across) / ahead;
            range = {std::min(range.x, tangent), std::max(range.y, tangent)};
        }
        return !body.points.empty();
    }
    // Planes through the lamp that touch the ellipsoid: those whose normal n = across - t axis has
    // (n . c)^2 = |M^T n|^2, c being the way to its centre: a quadratic equation of t.
    const glm::dvec3 way = body.center - position;
    const glm::dvec3 u = glm::transpose(body.offset_from_unit) * across;
    const glm::dvec3 w = glm::transpose(body.offset_from_unit) * axis;
    const double ahead = glm::dot(way, axis), aside = glm::dot(way, across);
    const double a = ahead * ahead - glm::dot(w, w);
    if (!(a > 0 && ahead > 0)) return false;
    const double b = ahead * aside - glm::dot(u, w), c = aside * aside - glm::dot(u, u);
    const double root = std::sqrt(std::max(0.0, b * b - a * c));
    range = {(b - root) / a, (b + root) / a};
    const double widest = std::tan(kWidestView);
    return range.x > -widest && range.y < widest;
}

glm::dvec2 widened(glm::dvec2 range) {
    const double room = kRoom * (range.y - range.x);
    return {range.x - room, range.y + room};
}

}  // namespace

glm::dvec2 BodyHull::range(const glm::dvec3& axis) const {
    if (round) {
        const double middle = glm::dot(center, axis);
        const double reach = glm::length(glm::transpose(offset_from_unit) * axis);
        return {middle - reach, middle + reach};
    }
    glm::dvec2 found(std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity());
    for (const glm::dvec3& point : points) {
        const double along = glm::dot(point, axis);
        found = {std::min(found.x, along), std::max(found.y, along)};
    }
    return found;
}

class LightViewMaker {
public:
    LightViewMaker(const scene::FrameScene& scene, const std::vector<BodyHull>& objects,
                   const BodyHull& water, int light, int index)
        : objects_(objects),
          all_water_(water),
          origin_(scene.origin),
          light_(scene.state.lights[static_cast<std::size_t>(light)]),
          picture_(std::make_shared<const light::SpotPicture>(scene, light)),
          water_(index == light::kWater),
          body_(water_ ? water : objects[static_cast<std::size_t>(index)]) {}

    std::vector<LightView> make(glm::dvec3 direction, double share) const {
        if (body_.empty()) return {};
        if (light_.type == scene::LightType::sun) return sun(direction, share);
        if (light_.position.y == 0 && water_) return {};
        return lamp();
    }

private:
    std::vector<LightView> sun(glm::dvec3 direction, double share) const {
        if (!(direction.y < -light::kLowestSun)) return {};
        LightView view;
        view.direction_ = direction;
        view.color_ = light_.irradiance * share;
        // On the rest plane for the water, whose outline then is the view's; else across the rays.
        glm::dmat3 plane = light::mesh_frame(direction);
        if (water_) plane = glm::dmat3({1, 0, 0}, {0, 0, 1}, {0, -1, 0});
        // Lengths along the plane's axes of where the ray through a point meets the plane: by covectors that
        // the direction of the light does not move.
        const double fall = glm::dot(direction, plane[2]);
        const glm::dvec3 to_u = plane[0] - (glm::dot(direction, plane[0]) / fall) * plane[2];
        const glm::dvec3 to_v = plane[1] - (glm::dot(direction, plane[1]) / fall) * plane[2];
        const glm::dvec2 u = widened(body_.range(to_u)), v = widened(body_.range(to_v));
        // Before the body, and before all that may stand between it and the sky.
        double first = body_.range(direction).x;
        for (const BodyHull& object : objects_) first = std::min(first, object.range(direction).x);
        first = std::min(first, all_water_.range(direction).x);
        first -= 1e-3 * (1 + std::abs(first));
        const glm::dvec3 corner = u.x * plane[0] + v.x * plane[1];
        view.along_u_ = (u.y - u.x) * plane[0];
        view.along_v_ = (v.y - v.x) * plane[1];
        double ahead = std::numeric_limits<double>::infinity();
        for (const double s : {0.0, 1.0})
            for (const double t : {0.0, 1.0})
                ahead = std::min(ahead,
                                 first - glm::dot(corner + s * view.along_u_ + t * view.along_v_, direction));
        view.corner_ = corner + ahead * direction;
        return {view};
    }

    std::vector<LightView> lamp() const {
        LightView view;
        view.parallel_ = false;
        view.color_ = light_.intensity;
        view.position_ = light_.position - origin_;
        view.from_below_ = light_.position.y < 0;
        view.spot_ = light_.type == scene::LightType::spot;
        view.emitter_ = scene::is_area(light_);
        view.direction_ = light_.direction;
        if (picture_->exists()) {
            view.picture_ = picture_;
            view.brightest_ = picture_->brightest();
        }
        if (view.spot_) {
            view.cos_outer_ = std::cos(light_.cone_angle);
            view.cos_inner_ = std::cos(std::max(0.0, light_.cone_angle - light_.falloff_angle));
        }
        // A spot's cone is a square about its axis.
        if (view.spot_ && light_.cone_angle < kWidestView) {
            const glm::dmat3 frame = light::mesh_frame(light_.direction);
            const double widest = std::tan(light_.cone_angle);
            glm::dvec2 u{-widest, widest}, v{-widest, widest}, found;
            if (tangents(body_, view.position_, frame[2], frame[0], found))
                u = {std::max(u.x, found.x), std::min(u.y, found.y)};
            if (tangents(body_, view.position_, frame[2], frame[1], found))
                v = {std::max(v.x, found.x), std::min(v.y, found.y)};
            if (!(u.y > u.x && v.y > v.x)) return {};
            set(view, frame, widened(u), widened(v));
            return {view};
        }
        // The water is seen along y, so that the outline of a flat pool is the view's.
        glm::dvec3 axis(0, view.from_below_ ? 1 : -1, 0);
        if (!water_) {
            const glm::dvec3 middle = body_.round ? body_.center : middle_of_points();
            const glm::dvec3 way = middle - view.position_;
            if (glm::dot(way, way) > 0) axis = glm::normalize(way);
        }
        const glm::dmat3 frame = light::mesh_frame(axis);
        glm::dvec2 u, v;
        if (tangents(body_, view.position_, frame[2], frame[0], u) &&
            tangents(body_, view.position_, frame[2], frame[1], v)) {
            set(view, frame, widened(u), widened(v));
            return {view};
        }
        std::vector<LightView> faces;
        for (const glm::dvec3 face : {glm::dvec3(1, 0, 0), glm::dvec3(-1, 0, 0), glm::dvec3(0, 1, 0),
                                      glm::dvec3(0, -1, 0), glm::dvec3(0, 0, 1), glm::dvec3(0, 0, -1)}) {
            if (!(body_.range(face).y > glm::dot(view.position_, face))) continue;  // all behind
            set(view, light::mesh_frame(face), {-1, 1}, {-1, 1});
            faces.push_back(view);
        }
        return faces;
    }

    glm::dvec3 middle_of_points() const {
        glm::dvec3 middle;
        for (int i = 0; i < 3; ++i) {
            const glm::dvec2 range = body_.range(glm::dvec3(i == 0, i == 1, i == 2));
            middle[i] = 0.5 * (range.x + range.y);
        }
        return middle;
    }

    static void set(LightView& view, const glm::dmat3& frame, glm::dvec2 u, glm::dvec2 v) {
        view.corner_ = frame[2] + u.x * frame[0] + v.x * frame[1];
        view.along_u_ = (u.y - u.x) * frame[0];
        view.along_v_ = (v.y - v.x) * frame[1];
    }

    const std::vector<BodyHull>& objects_;
    const BodyHull& all_water_;
    glm::dvec3 origin_;
    const scene::Light& light_;
    std::shared_ptr<const light::SpotPicture> picture_;
    bool water_;
    const BodyHull& body_;
};

LightRay LightView::ray(glm::dvec2 uv) const {
    const glm::dvec3 at = corner_ + uv.x * along_u_ + uv.y * along_v_;
    if (parallel_) return {at, direction_};
    return {position_, glm::normalize(at)};
}

double LightView::extent(glm::dvec2 a, glm::dvec2 b, glm::dvec2 c) const {
    const glm::dvec2 ab = b - a, ac = c - a;
    const double twice = std::abs(ab.x * ac.y - ab.y * ac.x);
    if (parallel_) return 0.5 * twice * std::abs(glm::dot(glm::cross(along_u_, along_v_), direction_));
    // Solid angle by van Oosterom and Strackee (1983); the triple product by the edges, which keeps its
    // digits for small triangles.
    const auto way = [&](glm::dvec2 uv) { return corner_ + uv.x * along_u_ + uv.y * along_v_; };
    const glm::dvec3 p = way(a), q = way(b), r = way(c);
    const double lp = glm::length(p), lq = glm::length(q), lr = glm::length(r);
    const double volume = twice * std::abs(glm::dot(corner_, glm::cross(along_u_, along_v_)));
    return 2 *
           std::atan2(volume, lp * lq * lr + glm::dot(p, q) * lr + glm::dot(q, r) * lp + glm::dot(r, p) * lq);
}

glm::dvec2 LightView::size() const {
    return {glm::length(along_u_), glm::length(along_v_)};
}

double LightView::falloff(glm::dvec2 uv) const {
    if (emitter_) return std::max(0.0, glm::dot(ray(uv).direction, direction_));
    if (!spot_) return 1;
    return optics::f64::spot_light_falloff(glm::dot(ray(uv).direction, direction_), cos_outer_, cos_inner_);
}

glm::dvec3 LightView::picture(glm::dvec2 a, glm::dvec2 b, glm::dvec2 c) const {
    if (!textured()) return glm::dvec3(1);
    const auto way = [&](glm::dvec2 uv) { return corner_ + uv.x * along_u_ + uv.y * along_v_; };
    return picture_->mean({way(a), way(b), way(c)});
}

double LightView::picture_brightness(glm::dvec2 uv, double width) const {
    if (!textured()) return 1;
    const glm::dvec3 way = corner_ + uv.x * along_u_ + uv.y * along_v_;
    const double across = std::sqrt(glm::length(glm::cross(along_u_, along_v_)) / glm::dot(way, way));
    const double found = light::SpotPicture::luminance(picture_->towards(way, width * across));
    return brightest_ > 0 ? found / brightest_ : 0;
}

LightView LightView::in_channels(const glm::dvec3& mask) const {
    LightView view = *this;
    view.color_ *= mask;
    return view;
}

LightViews::LightViews(const scene::FrameScene& scene) : scene_(scene), water_(hull_of_water(scene)) {
    for (std::size_t i = 0; i < scene.state.objects.size(); ++i) objects_.push_back(hull_of_object(scene, i));
}

std::vector<LightView> LightViews::of(int light, glm::dvec3 direction, double share, int body) const {
    return LightViewMaker(scene_, objects_, water_, light, body).make(direction, share);
}

}  // namespace dapple::methods::adaptive_beams
