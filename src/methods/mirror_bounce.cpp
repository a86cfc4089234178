#include "methods/mirror_bounce.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "base/parallel.h"
#include "light/way_transmittance.h"
#include "view/surface_point.h"

namespace dapple::methods {
namespace {

constexpr std::size_t kTile = 1 << 12;
/// Of light::BeamMesh::axis.
constexpr double kConeCosine = 0.1;
/// Rays leave a mirror this share of their distance from the origin off it, and at least so many m: a few
/// units in the last place of float positions.
constexpr double kLift = 1e-6;

/// A ray that has met a mirror.
struct Mirrored {
    std::size_t vertex;
    std::pair<std::uint32_t, std::uint32_t> surface;  // object, face of a box
    glm::dvec3 position, direction;
    double lift;  // m of way until it has left the mirror
};

class Bounce {
public:
    Bounce(const scene::FrameScene& scene, const media::Media& media, const rays::RayScene& rays,
           const light::BeamMesh& mesh, FrameStats& stats)
        : scene_(scene),
          rays_(rays),
          mesh_(mesh),
          stats_(stats),
          ways_(scene, media, mesh),
          geometry_(scene) {
        const scene::Light& light = scene.state.lights[static_cast<std::size_t>(mesh.light)];
        color_ = glm::vec3(light.type == scene::LightType::sun ? light.irradiance : light.intensity);
    }

    std::vector<MirroredMesh> make() {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<Mirrored>> surfaces;
        for (const Mirrored& ray : meet_mirrors()) surfaces[ray.surface].push_back(ray);
        std::vector<MirroredMesh> meshes;
        for (const auto& [surface, rays] : surfaces) send_on(rays, meshes);
        stats_.count("light sent on by mirrors, W", sent_);
        stats_.count("lost to second mirrors, W", lost_to_mirrors_);
        stats_.count("lost at the water behind mirrors, W", lost_to_water_);
        return meshes;
    }

private:
    /// In the order of the vertices.
    std::vector<Mirrored> meet_mirrors() const {
        std::vector<std::vector<Mirrored>> tiles(mesh_.vertices() / kTile + 1);
        parallel_for(mesh_.vertices(), kTile, [&](std::size_t begin, std::size_t end) {
            std::vector<rays::Ray> traced;
            std::vector<std::size_t> vertices;
            for (std::size_t i = begin; i < end; ++i) {
                if (!(mesh_.flux[i] > 0)) continue;
                traced.push_back({point_of(mesh_, i), 0, mesh_.slope[i]});
                vertices.push_back(i);
            }
            std::vector<rays::Hit> hits(traced.size());
            rays_.intersect_objects(traced, hits);
            for (std::size_t k = 0; k < hits.size(); ++k) {
                if (hits[k].primitive == rays::kNoHit || !material(hits[k]).mirror) continue;
                tiles[begin / kTile].push_back(reflect(vertices[k], traced[k], hits[k]));
            }
        });
        std::vector<Mirrored> all;
        for (const std::vector<Mirrored>& tile : tiles) all.insert(all.end(), tile.begin(), tile.end());
        return all;
    }

    Mirrored reflect(std::size_t vertex, const rays::Ray& ray, rays::Hit hit) const {
        const glm::dvec3 slope(ray.direction), incident = glm::normalize(slope);
        hit.distance *= static_cast<float>(glm::length(slope));
        const view::SurfacePoint point = geometry_.object_point(hit, glm::dvec3(ray.origin), incident);
        const double side = glm::dot(incident, point.geometric_normal) <= 0 ? 1 : -1;
        const glm::dvec3 geometric = side * point.geometric_normal;
        const auto mirrored = [&](const glm::dvec3& normal) {
            return glm::normalize(incident - 2 * glm::dot(incident, normal) * normal);
        };
        // An interpolated normal may send light into the mirror: then the triangle's counts.
        glm::dvec3 direction = mirrored(side * point.shading_normal);
        if (glm::dot(direction, geometric) <= 0) direction = mirrored(geometric);
        const bool box = scene_.state.objects[hit.object].shape == scene::Shape::box;
        const double off = kLift * std::max(1.0, glm::length(point.position));
        return {vertex,
                {hit.object, box ? hit.primitive / 2 : 0},
                point.position,
                direction,
                off / std::max(glm::dot(direction, geometric), 0.01)};
    }

    /// Rays of one mirror, in as few meshes as their directions allow.
    void send_on(const std::vector<Mirrored>& rays, std::vector<MirroredMesh>& meshes) {
        glm::dvec3 mean(0);
        for (const Mirrored& ray : rays) mean += ray.direction;
        std::vector<glm::dvec3> axes = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
        if (glm::length(mean) > kConeCosine * static_cast<double>(rays.size()))
            axes.insert(axes.begin(), glm::normalize(mean));
        const auto axis_of = [&](const Mirrored& ray) {
            return std::find_if(
                       axes.begin(), axes.end(),
                       [&](const glm::dvec3& axis) { return glm::dot(ray.direction, axis) > kConeCosine; }) -
                   axes.begin();
        };
        for (std::ptrdiff_t k = 0; k < std::ssize(axes); ++k) {
            if (std::none_of(rays.begin(), rays.end(), [&](const Mirrored& r) { return axis_of(r) == k; }))
                continue;
            MirroredMesh& made = meshes.emplace_back();
            made.mesh = empty_mesh(rays.front(), axes[static_cast<std::size_t>(k)]);
            for (const Mirrored& ray : rays) add(ray, axis_of(ray) == k, made.mesh);
            made.landings = light::land(made.mesh, rays_);
            drop(made);
        }
    }

    light::BeamMesh empty_mesh(const Mirrored& ray, const glm::dvec3& axis) const {
        light::BeamMesh mesh;
        const std::string& name = scene_.state.objects[ray.surface.first].name;
        mesh.name = mesh_.name + " > " +
                    (name.empty() ? "objects[" + std::to_string(ray.surface.first) + "]" : name) + ":R";
        mesh.light = mesh_.light;
        mesh.event = mesh_.event;
        mesh.cascade = mesh_.cascade;
        mesh.from_below = mesh_.from_below;
        mesh.axis = axis;
        mesh.rows = mesh_.rows;
        mesh.columns = mesh_.columns;
        mesh.texel = mesh_.texel;
        mesh.weight = mesh_.weight;
        const std::size_t vertices = mesh_.vertices();
        mesh.origin.assign(vertices, glm::vec3(0));
        mesh.slope.assign(vertices, glm::vec3(axis));
        mesh.start.assign(vertices, 0);
        mesh.flux.assign(vertices, 0);
        mesh.tint.assign(vertices, glm::vec3(0));
        mesh.valid.assign(vertices, 0);
        mesh.water_point.assign(vertices, glm::vec3(0));
        return mesh;
    }

    /// A ray that another axis serves stays as a neighbour, without flux.
    void add(const Mirrored& ray, bool carries, light::BeamMesh& mesh) {
        const double along = glm::dot(ray.direction, mesh.axis);
        if (!(along > kConeCosine)) return;
        const std::size_t i = ray.vertex;
        const glm::dvec3 slope = ray.direction / along;
        const double depth = glm::dot(ray.position, mesh.axis);
        mesh.slope[i] = glm::vec3(slope);
        mesh.origin[i] = glm::vec3(ray.position - depth * slope);
        mesh.start[i] = static_cast<float>(depth + along * ray.lift);
        mesh.valid[i] = 1;
        mesh.water_point[i] = point_of(mesh_, i);
        if (!carries) return;
        const glm::vec3 position(ray.position);
        mesh.flux[i] = mesh_.flux[i];
        mesh.tint[i] = ways_.of(mesh.water_point[i], position, glm::distance(mesh.water_point[i], position)) *
                       glm::vec3(scene_.state.objects[ray.surface.first].material.color);
        if (!mesh_.tint.empty()) mesh.tint[i] *= mesh_.tint[i];
        sent_ += power(mesh, i);
    }

    /// What meets another mirror, or the water, next is lost. It stays a ray with light: beside the edge of a
    /// hull it has its share of the light up to the edge. At the water it lands nowhere; a mirror it lands
    /// on, which no camera path ends on, so that it lights nothing that its neighbours landed on behind it.
    void drop(MirroredMesh& made) {
        light::BeamMesh& mesh = made.mesh;
        std::vector<rays::Ray> traced;
        std::vector<std::size_t> vertices;
        for (std::size_t i = 0; i < mesh.vertices(); ++i) {
            if (!(mesh.flux[i] > 0)) continue;
            traced.push_back({point_of(mesh, i), 0, mesh.slope[i], made.landings.depth[i] - mesh.start[i]});
            vertices.push_back(i);
        }
        std::vector<rays::Hit> water(traced.size()), objects(traced.size());
        constexpr std::size_t kAtOnce = 1 << 10;
        parallel_for(traced.size(), kAtOnce, [&](std::size_t begin, std::size_t end) {
            const std::span<const rays::Ray> some(traced.data() + begin, end - begin);
            rays_.intersect_water(some, std::span(water).subspan(begin, end - begin));
            std::vector<rays::Ray> all(some.begin(), some.end());
            for (rays::Ray& ray : all) ray.far = std::numeric_limits<float>::infinity();
            rays_.intersect_objects(all, std::span(objects).subspan(begin, end - begin));
        });
        for (std::size_t k = 0; k < vertices.size(); ++k) {
            const std::size_t i = vertices[k];
            const bool crosses = water[k].primitive != rays::kNoHit;
            const bool again = objects[k].primitive != rays::kNoHit && material(objects[k]).mirror;
            if (!crosses && !again) continue;
            (crosses ? lost_to_water_ : lost_to_mirrors_) += power(mesh, i);
            if (made.landings.depth[i] < std::numeric_limits<float>::infinity()) --made.landings.count;
            if (crosses) made.landings.depth[i] = std::numeric_limits<float>::infinity();
        }
    }

    const scene::Material& material(const rays::Hit& hit) const {
        return scene_.state.objects[hit.object].material;
    }
    static glm::vec3 point_of(const light::BeamMesh& mesh, std::size_t i) {
        return mesh.origin[i] + mesh.start[i] * mesh.slope[i];
    }
    /// W, mean of the channels, where the ray leaves the mirror.
    double power(const light::BeamMesh& mesh, std::size_t i) const {
        const glm::vec3 watts = mesh.flux[i] * mesh.tint[i] * color_;
        return static_cast<double>(watts.r + watts.g + watts.b) / 3;
    }

    const scene::FrameScene& scene_;
    const rays::RayScene& rays_;
    const light::BeamMesh& mesh_;
    FrameStats& stats_;
    light::WayTransmittance ways_;
    view::SurfaceGeometry geometry_;
    glm::vec3 color_;
    double sent_ = 0, lost_to_mirrors_ = 0, lost_to_water_ = 0;  // W
};

}  // namespace

std::vector<MirroredMesh> mirror_bounce(const scene::FrameScene& scene, const media::Media& media,
                                        const rays::RayScene& rays, const light::BeamMesh& mesh,
                                        FrameStats& stats) {
    const std::vector<scene::Object>& objects = scene.state.objects;
    if (mesh.vertices() == 0 || std::none_of(objects.begin(), objects.end(), [](const scene::Object& object) {
            return object.material.mirror;
        }))
        return {};
    const ScopedPass pass(stats, "second bounce");
    return Bounce(scene, media, rays, mesh, stats).make();
}

double mirrored_vertex_bytes(const scene::FrameState& state) {
    // Origin, slope, tint and place on the water, start, flux and weight, valid; depth and normal where it
    // lands.
    constexpr double kVertex = 4 * 12 + 3 * 4 + 1 + 4 + 12;
    constexpr double kLitFacesOfBox = 5;
    double meshes = 0;
    for (const scene::Object& object : state.objects)
        if (object.material.mirror) meshes += object.shape == scene::Shape::box ? kLitFacesOfBox : 1;
    // A ray is held as it is found, among all, and by its mirror.
    return meshes > 0 ? meshes * kVertex + 3 * sizeof(Mirrored) : 0;
}

}  // namespace dapple::methods
