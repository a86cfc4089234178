#include "render/plan.h"

#include <algorithm>
#include <cstdio>
#include <limits>

#include "media/media.h"
#include "render/buffer_scale.h"
#include "render/shading.h"
#include "scene/area_light.h"
#include "scene/transform.h"
#include "view/camera.h"
#include "view/camera_medium.h"

namespace dapple::render {
namespace {

/// Floats of a mesh further apart than this share of its cells tilt its facets by as much, rad: what they
/// send 4 m deep moves by a millimetre.
constexpr double kCoarseFloats = 1e-3;

/// Range of heights that an object takes up.
struct Heights {
    double lowest;
    double highest;
};

Heights object_heights(const scene::Object& object, const scene::TriangleMesh* mesh) {
    const glm::dmat4 world_from_object = scene::world_from_object(object.transform);
    if (mesh) {
        Heights heights{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
        for (const glm::dvec3& position : mesh->positions) {
            const double height = (world_from_object * glm::dvec4(position, 1)).y;
            heights = {std::min(heights.lowest, height), std::max(heights.highest, height)};
        }
        return heights;
    }
    glm::dvec3 half = 0.5 * object.size;
    if (object.shape == scene::Shape::plane) half.y = 0;
    if (object.shape == scene::Shape::sphere) half = glm::dvec3(object.radius);
    double reach = 0;
    for (int axis = 0; axis < 3; ++axis) reach += std::abs(world_from_object[axis].y) * half[axis];
    return {world_from_object[3].y - reach, world_from_object[3].y + reach};
}

/// How fine rings are, and which share of the waves' mean-square slope is left out from which distance on.
std::string ring_text(const std::vector<scene::WaterRing>& rings) {
    char text[160];
    std::snprintf(text, sizeof text, ", %d rings about the camera, cells of %.3g m to %.3g m",
                  static_cast<int>(rings.size()), rings.front().cell, rings.back().cell);
    std::string all = text;
    double before = 0;
    for (const scene::WaterRing& ring : rings) {
        if (!(ring.slope_left_out > before)) continue;
        std::snprintf(text, sizeof text, "%s %.3g %% from %.4g m on",
                      before > 0 ? "," : "; of the waves' mean-square slope it leaves out",
                      100 * ring.slope_left_out, 0.5 * ring.size);
        before = ring.slope_left_out;
        all += text;
    }
    return all;
}

bool inside(const scene::Extent& extent, glm::dvec3 position) {
    const glm::dvec2 offset = glm::abs(glm::dvec2(position.x, position.z) - extent.center);
    return extent.kind == scene::ExtentKind::open_water ||
           (offset.x <= 0.5 * extent.size.x && offset.y <= 0.5 * extent.size.y);
}

/// Whether a box of points has some over the water.
bool meets(const scene::Extent& extent, glm::dvec3 lowest, glm::dvec3 highest) {
    const glm::dvec2 low = extent.center - 0.5 * extent.size, high = extent.center + 0.5 * extent.size;
    return extent.kind == scene::ExtentKind::open_water ||
           (lowest.x <= high.x && highest.x >= low.x && lowest.z <= high.y && highest.z >= low.y);
}

class Planner {
public:
    Planner(const scene::FrameScene& scene, const methods::CausticMethod& method)
        : scene_(scene),
          state_(scene.state),
          support_(method.supports_surface(scene.state)),
          media_(scene),
          volume_support_(scatters() ? method.supports_volume(scene.state) : methods::Support{}),
          method_(method),
          serves_behind_specular_(method.serves_behind_specular()),
          follows_glass_(method.follows_glass()),
          any_area_(std::any_of(state_.lights.begin(), state_.lights.end(), scene::is_area)) {}

    Plan make() {
        plan_.water = state_.water.has_value();
        add("water surface", plan_.water, plan_.water ? water_mesh() : "the timeline has no water");
        find_reach();
        for (std::size_t i = 0; plan_.water && i < state_.lights.size(); ++i) {
            consider(static_cast<int>(i), light::Event::transmission);
            consider(static_cast<int>(i), light::Event::reflection);
        }
        plan_glass();
        plan_method();
        plan_stand_in();
        plan_.direct_light = !state_.lights.empty() && !state_.objects.empty();
        add("direct light", plan_.direct_light,
            plan_.direct_light ? "lights and receivers in one medium, shadowed by objects"
                               : "no lights or no objects");
        plan_.sky_light = state_.sky.radiance != glm::dvec3(0);
        add("sky term", plan_.sky_light,
            plan_.sky_light ? "constant sky; no occlusion by objects" : "the sky is black");
        plan_volume();
        not_modelled();
        return std::move(plan_);
    }

private:
    void add(const std::string& pass, bool runs, const std::string& reason) {
        const PlanLine line{pass, runs ? "yes" : "no", reason};
        // What all parts of an area light have in common is said once.
        if (std::find(plan_.lines.begin(), plan_.lines.end(), line) == plan_.lines.end())
            plan_.lines.push_back(line);
    }
    void add(const std::string& pass, const methods::Support& support) {
        using enum methods::Support::Degree;
        plan_.lines.push_back({pass,
                               support.degree == yes      ? "yes"
                               : support.degree == partly ? "partly"
                                                          : "no",
                               support.reason});
    }

    std::string water_mesh() const {
        const scene::WaterMesh& water = *scene_.water;
        std::string text = std::to_string(water.mesh.triangles.size()) + " triangles";
        if (water.cells_per_shortest_wave > 0) {
            char cells[32];
            std::snprintf(cells, sizeof cells, ", %.1f cells", water.cells_per_shortest_wave);
            text += std::string(cells) + " a shortest wave";
        }
        if (!water.rings.empty()) text += ring_text(water.rings);
        if (water.capped) text += ", capped: finer waves want mesh_cells";
        if (water.folded_vertices > 0) text += ", folded over itself in places";
        if (water.float_step > kCoarseFloats * water.mean_edge) {
            char step[160];
            std::snprintf(
                step, sizeof step,
                ", rounded: the file's floats are %.2g mm apart so far from its origin, beside cells of "
                "%.2g mm; write it near its origin and give `offset`",
                1e3 * water.float_step, 1e3 * water.mean_edge);
            text += step;
        }
        return text;
    }

    /// Without water all is above it.
    void find_reach() {
        const double bound = scene_.water ? scene_.water->largest_height : 0;
        for (std::size_t i = 0; i < state_.objects.size(); ++i) {
            const scene::Object& object = state_.objects[i];
            const Heights heights = object_heights(object, scene_.object_meshes[i].get());
            const bool below = state_.water && heights.lowest < bound;
            const bool above = !state_.water || heights.highest > -bound;
            (object.material.glass ? glass_below_ : receivers_below_) |= below;
            (object.material.glass ? glass_above_ : receivers_above_) |= above;
        }
        if (!state_.water) return;
        // Where paths start: in one point, or on a rectangle.
        const scene::Clip& clip = state_.clip;
        const view::Camera camera(state_.camera, clip.width, clip.height);
        glm::dvec3 lowest(std::numeric_limits<double>::infinity()), highest(-lowest);
        for (const double x : {0.0, 1.0}) {
            for (const double y : {0.0, 1.0}) {
                glm::dvec3 start, direction;
                camera.ray({x * clip.width, y * clip.height}, start, direction);
                lowest = glm::min(lowest, start);
                highest = glm::max(highest, start);
            }
        }
        const scene::Extent& extent = state_.water->extent;
        // A camera at the surface is under it.
        const double margin = view::surface_margin(
            glm::max(glm::abs(lowest - scene_.origin), glm::abs(highest - scene_.origin)));
        camera_may_be_below_ = meets(extent, lowest, highest) && lowest.y <= bound + margin;
        camera_may_be_above_ = !(inside(extent, lowest) && inside(extent, highest)) || highest.y > -bound;
    }

    /// Sides of the water, above and below.
    struct Sides {
        bool above = false;
        bool below = false;
        explicit operator bool() const { return above || below; }
    };

    void consider(int index, light::Event event) {
        const scene::Light& light = state_.lights[static_cast<std::size_t>(index)];
        if (faces_away(light)) {
            add(light::chain_name(state_, {index, event}), false, "all the water lies behind the emitter");
            return;
        }
        const bool above = light_above_water(light);
        const bool lands_above = (event == light::Event::reflection) == above;
        // Glass sends light on to where it likes.
        const bool on_by_glass = follows_glass_ && (lands_above ? glass_above_ : glass_below_);
        const Sides sides{lands_above || on_by_glass, !lands_above || on_by_glass};
        std::string note;
        if (among_waves(light)) {
            note = std::string("; the lamp is among the waves and counts as ") + (above ? "above" : "under") +
                   " water: what it sends onto their other side is lost";
        }
        if (light.part.count > 0) note += "; by " + parts_of(light);
        take({index, event}, sides, note);
    }

    /// Whether none of the water lies before the plane of an area light, of which all parts share one.
    bool faces_away(const scene::Light& light) const {
        const std::vector<glm::dvec3>& surface = scene_.water->mesh.positions;
        return scene::is_area(light) && !surface.empty() &&
               std::none_of(surface.begin(), surface.end(), [&](const glm::dvec3& point) {
                   return glm::dot(point - light.position, light.direction) > 0;
               });
    }

    static std::string parts_of(const scene::Light& light) {
        const std::string emitter = light.type == scene::LightType::quad ? "quad" : "disc";
        return light.part.count == 1 ? "the middle of the " + emitter
                                     : std::to_string(light.part.count) + " points of the " + emitter;
    }

    /// Chains that begin at glass, or why there are none.
    void plan_glass() {
        if (!scene::has_glass(state_) || state_.lights.empty()) return;
        if (!follows_glass_) {
            add("glass", false, "the method does not follow light through glass; it casts shadows");
            return;
        }
        for (std::size_t light = 0; light < state_.lights.size(); ++light) {
            for (std::size_t object = 0; object < state_.objects.size(); ++object) {
                if (!state_.objects[object].material.glass) continue;
                for (const light::Event event : {light::Event::transmission, light::Event::reflection})
                    take({static_cast<int>(light), event, static_cast<int>(object)},
                         {true, state_.water.has_value()}, "");
            }
        }
    }

    /// A chain whose light lands on those sides of the water, if anything there is lit by it.
    void take(light::Chain chain, Sides sides, const std::string& note) {
        const std::string pass = light::chain_name(state_, chain);
        const std::string no_receivers = why_no_receivers(sides);
        const bool serves_volume = volume_support_.degree != methods::Support::Degree::no;
        const Sides media{serves_volume && volume_support_.in_air && sides.above && media_.scatters(false),
                          serves_volume && volume_support_.in_water && sides.below && media_.scatters(true)};
        if (!no_receivers.empty() && !media) {
            add(pass, false, no_receivers);
            return;
        }
        plan_.chains.push_back(chain);
        plan_.caustics |= no_receivers.empty();
        plan_.volume_caustics |= bool(media);
        const Sides objects{sides.above && receivers_above_, sides.below && receivers_below_};
        const Sides lit{(no_receivers.empty() && objects.above) || media.above,
                        (no_receivers.empty() && objects.below) || media.below};
        std::string reason = no_receivers.empty() ? (media ? "objects and media" : "objects") : "media";
        if (state_.water) {
            reason += lit.above && lit.below ? " above and below the water"
                      : lit.above            ? " above the water"
                                             : " below the water";
        }
        add(pass, true, reason + note);
    }

    /// Why a chain that lands on those sides of the water needs no E; empty where it does.
    std::string why_no_receivers(Sides sides) const {
        if (support_.degree == methods::Support::Degree::no) return "the method does not serve this scene";
        const Sides lit{sides.above && receivers_above_, sides.below && receivers_below_};
        if (!lit) {
            if (!state_.water || (sides.above && sides.below)) return "there is nothing but glass";
            return sides.above ? "nothing stands above the water" : "nothing lies below the water";
        }
        const bool seen = (lit.above && camera_may_be_above_) || (lit.below && camera_may_be_below_);
        if (!serves_behind_specular_ && !seen)
            return "it lands across the water from the camera, and the method serves direct views only";
        return "";
    }

    bool scatters() const { return media_.scatters(false) || media_.scatters(true); }

    /// Whether some of the water's surface is higher than the lamp and some lower.
    bool among_waves(const scene::Light& light) const {
        return light.type != scene::LightType::sun &&
               std::abs(light.position.y) <= scene_.water->largest_height;
    }

    void plan_method() {
        if (!plan_.caustics && support_.degree != methods::Support::Degree::no) {
            add("caustics: " + state_.caustics.method, false, "no light path needs it");
            return;
        }
        add("caustics: " + state_.caustics.method, support_);
        if (!plan_.caustics) return;
        plan_buffer();
        plan_denoise();
    }

    void plan_buffer() {
        const scene::BufferScale scale = state_.caustics.buffer_scale;
        if (scale == scene::BufferScale::full) return;
        const bool half = scale == scene::BufferScale::half;
        const std::string pass = std::string("buffer scale: ") + (half ? "half" : "quarter");
        if (plan_.volume_caustics) {
            add(pass, false, "what media scatter is found for the picture's own pixels, and E with it");
            return;
        }
        plan_.buffer_scale = pixels_a_side(scale);
        add(pass, true,
            std::string("E is found for pixels ") + (half ? "twice" : "four times") +
                " as wide and high, and interpolated between receivers of one surface" +
                (method_.serves_any_layer() ? "; elsewhere it is found for each pixel" : ""));
    }

    void plan_denoise() {
        const scene::Denoise& denoise = state_.caustics.denoise;
        if (denoise.filter == scene::DenoiseFilter::none) return;
        const bool fixed = denoise.filter == scene::DenoiseFilter::fixed;
        std::string reason = std::to_string(denoise.passes) + (denoise.passes == 1 ? " pass" : " passes");
        reason += fixed ? ", radius " + std::to_string(denoise.radius) + " pixels"
                        : std::string(", radius 5 to 15 pixels, by luminance");
        reason += denoise.paper_faithful
                      ? "; as printed, which changes the power of the light: see the counts"
                      : "; within surfaces, the power of the light is kept";
        add(std::string("denoise: ") + (fixed ? "fixed" : "adaptive"), true, reason);
    }

    void plan_volume() {
        if (!scatters()) {
            add("volume", false, "no medium scatters");
            return;
        }
        const std::string pass = "volume caustics: " + state_.caustics.method;
        if (plan_.volume_caustics || volume_support_.degree == methods::Support::Degree::no) {
            add(pass, volume_support_);
        } else {
            add(pass, false, "no light path needs it");
        }
        const bool air = any_light(false), water = any_light(true);
        plan_.volume_direct = air || water;
        add("volumetric direct light", plan_.volume_direct,
            plan_.volume_direct
                ? std::string("lights and media in ") +
                      (air && water ? "air and water"
                       : air        ? "the air"
                                    : "the water") +
                      ", shadowed by objects" + (any_area_ ? "; an area light by its points" : "")
                : "no light is on a side of the water where something scatters");
        plan_.volume = plan_.volume_caustics || plan_.volume_direct;
        plan_.half_volume =
            plan_.volume && state_.caustics.volume_resolution == scene::VolumeResolution::half;
        if (plan_.half_volume) {
            add("half volume resolution", true,
                "what media scatter is found at every second pixel in x and y, and where segments do not lie "
                "between those of their neighbors; interpolated elsewhere");
        }
    }

    /// Whether a light shines, without a specular event, on the side of the water where something scatters.
    bool any_light(bool in_water) const {
        return media_.scatters(in_water) &&
               std::any_of(state_.lights.begin(), state_.lights.end(), [&](const scene::Light& light) {
                   return light_in_water(state_, light) == in_water;
               });
    }

    /// Also where no chain is traced: the camera may see the bed from above.
    void plan_stand_in() {
        if (!receivers_below_ || state_.lights.empty()) return;
        const bool open = state_.water->extent.kind == scene::ExtentKind::open_water;
        std::string reason;
        if (!serves_behind_specular_ || support_.degree != methods::Support::Degree::yes)
            reason = "at receivers in the water that the method does not cover (E and covered are 0 there)";
        if (open) {
            reason += std::string(reason.empty() ? "" : ", and ") +
                      "for light that enters open water beyond its extent (not in E)";
        }
        plan_.flat_water_stand_in = !reason.empty();
        if (plan_.flat_water_stand_in) add("flat-water stand-in", true, "beauty only, " + reason);
    }

    void not_modelled() {
        std::string what =
            "multiple scattering, light from floor to surface to floor, second crossings of the water by "
            "light, light sent on by mirrors";
        if (state_.caustics.map.second_bounce) what += " (but once, after the water)";
        what += ", the sun's disc ";
        if (any_area_) what += "and area lights ";
        what += "as seen by the camera, occlusion of the sky term";
        if (scatters()) {
            what += ", light of the sky that media scatter, light that they scatter onto receivers";
            if (state_.water && state_.water->extent.kind == scene::ExtentKind::open_water)
                what += ", light in media that entered open water beyond its extent";
        }
        add("not modelled", false, what);
    }

    const scene::FrameScene& scene_;
    const scene::FrameState& state_;
    const methods::Support support_;
    const media::Media media_;
    const methods::Support volume_support_;
    const methods::CausticMethod& method_;
    const bool serves_behind_specular_;
    const bool follows_glass_;
    const bool any_area_;
    Plan plan_;
    bool receivers_below_ = false;
    bool receivers_above_ = false;
    bool glass_below_ = false;
    bool glass_above_ = false;
    bool camera_may_be_below_ = false;
    bool camera_may_be_above_ = true;
};

}  // namespace

bool light_above_water(const scene::Light& light) {
    return light.type == scene::LightType::sun || light.position.y > 0;
}

Plan make_plan(const scene::FrameScene& scene, const methods::CausticMethod& method) {
    return Planner(scene, method).make();
}

}  // namespace dapple::render
