#include "render/plan.h"

#include <algorithm>
#include <cstdio>
#include <limits>

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
          serves_behind_specular_(method.serves_behind_specular()) {}

    Plan make() {
        plan_.water = state_.water.has_value();
        add("water surface", plan_.water, plan_.water ? water_mesh() : "the timeline has no water");
        find_reach();
        for (std::size_t i = 0; plan_.water && i < state_.lights.size(); ++i) {
            consider(static_cast<int>(i), light::Event::transmission);
            consider(static_cast<int>(i), light::Event::reflection);
        }
        plan_.caustics = !plan_.chains.empty();
        plan_method();
        plan_stand_in();
        plan_.direct_light = !state_.lights.empty() && !state_.objects.empty();
        add("direct light", plan_.direct_light,
            plan_.direct_light ? "lights and receivers in one medium, shadowed by objects"
                               : "no lights or no objects");
        plan_.sky_light = state_.sky.radiance != glm::dvec3(0);
        add("sky term", plan_.sky_light,
            plan_.sky_light ? "constant sky; no occlusion by objects" : "the sky is black");
        add("volume", false, "no medium scatters");
        not_modelled();
        return std::move(plan_);
    }

private:
    void add(const std::string& pass, bool runs, const std::string& reason) {
        plan_.lines.push_back({pass, runs ? "yes" : "no", reason});
    }

    std::string water_mesh() const {
        const scene::WaterMesh& water = *scene_.water;
        std::string text = std::to_string(water.mesh.triangles.size()) + " triangles";
        if (water.cells_per_shortest_wave > 0) {
            char cells[32];
            std::snprintf(cells, sizeof cells, ", %.1f cells", water.cells_per_shortest_wave);
            text += std::string(cells) + " a shortest wave";
        }
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

    void find_reach() {
        if (!state_.water) return;
        const double bound = scene_.water->largest_height;
        for (std::size_t i = 0; i < state_.objects.size(); ++i) {
            const Heights heights = object_heights(state_.objects[i], scene_.object_meshes[i].get());
            receivers_below_ |= heights.lowest < bound;
            receivers_above_ |= heights.highest > -bound;
        }
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

    void consider(int index, light::Event event) {
        const scene::Light& light = state_.lights[static_cast<std::size_t>(index)];
        const bool above = light_above_water(light);
        const bool lands_above = (event == light::Event::reflection) == above;
        const std::string pass = light::chain_name(state_, {index, event});
        if (support_.degree == methods::Support::Degree::no) {
            add(pass, false, "the method does not serve this scene");
            return;
        }
        if (!(lands_above ? receivers_above_ : receivers_below_)) {
            add(pass, false, lands_above ? "nothing stands above the water" : "nothing lies below the water");
            return;
        }
        if (!serves_behind_specular_ && !(lands_above ? camera_may_be_above_ : camera_may_be_below_)) {
            add(pass, false,
                "it lands across the water from the camera, and the method serves direct views only");
            return;
        }
        plan_.chains.push_back({index, event});
        std::string reason = lands_above ? "objects above the water" : "objects below the water";
        if (among_waves(light)) {
            reason += std::string("; the lamp is among the waves and counts as ") +
                      (above ? "above" : "under") + " water: what it sends onto their other side is lost";
        }
        add(pass, true, reason);
    }

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
        const char* decision = support_.degree == methods::Support::Degree::yes      ? "yes"
                               : support_.degree == methods::Support::Degree::partly ? "partly"
                                                                                     : "no";
        plan_.lines.push_back({"caustics: " + state_.caustics.method, decision, support_.reason});
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
        add("not modelled", false,
            "multiple scattering, light from floor to surface to floor, second crossings of the water by "
            "light, light sent on by mirrors, the sun's disc as seen by the camera, occlusion of the sky "
            "term");
    }

    const scene::FrameScene& scene_;
    const scene::FrameState& state_;
    const methods::Support support_;
    const bool serves_behind_specular_;
    Plan plan_;
    bool receivers_below_ = false;
    bool receivers_above_ = false;
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
