#include "timeline/checks.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "base/units.h"
#include "timeline/key_path.h"

namespace dapple::timeline {
namespace {

constexpr std::int64_t kMostSamples = 4096;
constexpr double kShortest = 1e-9;  // m; points nearer than that are one
constexpr double kParallel = 1e-6;  // sine of the angle below which directions are parallel
constexpr double kWidestPicture = 85 * scene::kDegree;  // at the edge of a wider cone it would be drawn out

class Checker {
public:
    Checker(const Program& program, const input::LocatedNode& root, FaultList& faults)
        : program_(program), root_(root), faults_(faults) {}

    void check(const scene::FrameState& state) {
        frame_ = state.frame;
        check_camera(state.camera);
        for (std::size_t i = 0; i < state.lights.size(); ++i) check_light(state.lights[i], join("lights", i));
        for (std::size_t i = 0; i < state.objects.size(); ++i)
            check_object(state.objects[i], join("objects", i));
        for (std::size_t i = 0; i < state.media.size(); ++i)
            check_medium(state.media[i], state.water.has_value(), join("media", i));
        if (state.water) {
            check_surface(state.water->surface);
            check_rings(*state.water);
            check_dispersion(*state.water);
            check_phase(state.water->phase, "water.phase");
        }
        check_caustics(state.caustics);
    }

private:
    void check_camera(const scene::Camera& camera) {
        const glm::dvec3 view = camera.target - camera.position;
        const double distance = glm::length(view);
        const double up = glm::length(camera.up);
        if (distance < kShortest)
            fault("camera.target", "the camera looks at the point where it stands; move position or target");
        else if (up == 0)
            fault("camera.up", "the vector has no length");
        else if (glm::length(glm::cross(view, camera.up)) < kParallel * distance * up)
            fault("camera.up", "is parallel to the line of sight; for a view straight down take [0, 0, -1]");
    }

    void check_light(const scene::Light& light, const std::string& path) {
        if (light.type == scene::LightType::point) return;
        const bool by_target = program_.given.count(join(path, "target")) > 0;
        if (glm::length(light.direction) == 0)
            fault(join(path, by_target ? "target" : "direction"),
                  by_target ? "the light points at the place where it stands" : "the vector has no length");
        else if (light.type == scene::LightType::sun && !(light.direction.y < 0))
            fault(join(path, "direction"), "a sun shines downwards: the second number, y, must be below 0");
        if (light.type != scene::LightType::spot) return;
        if (light.falloff_angle > light.cone_angle)
            fault(join(path, "falloff_angle"),
                  "the soft edge is wider than the cone; take at most cone_angle");
        check_picture(light, path);
    }

    void check_picture(const scene::Light& light, const std::string& path) {
        const std::string roll = join(path, "roll");
        if (light.texture.empty()) {
            if (program_.given.count(roll) > 0) fault(roll, "turns a texture, which the spot does not have");
        } else if (light.cone_angle > kWidestPicture) {
            fault(join(path, "cone_angle"), "a picture is thrown into cones of at most 85 deg");
        }
    }

    void check_object(const scene::Object& object, const std::string& path) {
        const glm::dvec3& scale = object.transform.scale;
        if (object.shape == scene::Shape::sphere && (scale.x != scale.y || scale.x != scale.z))
            fault(join(path, "scale"), "a sphere stays a sphere; give one number");
        check_material(object, join(path, "material"));
    }

    void check_material(const scene::Object& object, const std::string& path) {
        const scene::Material& material = object.material;
        const auto given = [&](const char* key) { return program_.given.count(join(path, key)) > 0; };
        if (!material.glass) {
            for (const char* key : {"refractive_index", "absorption"}) {
                if (given(key)) fault(join(path, key), "is of glass only; add glass: true");
            }
            return;
        }
        if (object.shape == scene::Shape::plane)
            fault(join(path, "glass"), "a plane has no inside for the glass to fill; take a flat box");
        if (material.mirror)
            fault(join(path, "mirror"), "glass is no mirror, it reflects by its refractive_index");
        for (const char* key : {"color", "texture", "texture_size"}) {
            if (given(key)) fault(join(path, key), "glass has none; absorption tints it");
        }
    }

    void check_medium(const scene::Medium& medium, bool water, const std::string& path) {
        check_phase(medium.phase, path + ".phase");
        if (medium.side == scene::MediumSide::water && !water)
            fault(path + ".side", "there is no water for the medium to be in");
        if (medium.type != scene::MediumType::grid) return;
        const bool pattern = scene::file_path(medium, 0) != scene::file_path(medium, 1);
        const bool numbered =
            program_.given.count(path + ".first_file") > 0 || program_.given.count(path + ".last_file") > 0;
        if (medium.last_file < medium.first_file)
            fault(path + ".last_file", "comes before first_file, " + std::to_string(medium.first_file));
        else if (medium.last_file > medium.first_file && !pattern)
            fault(path + ".file",
                  "a sequence needs one place for the number in the file's name, such as smoke.%04d.vdb or "
                  "smoke.####.vdb");
        else if (pattern && !numbered)
            fault(path + ".file", "has a place for a number; say which with first_file and last_file");
    }

    void check_phase(const scene::PhaseFunction& phase, const std::string& path) {
        if (phase.type != scene::PhaseType::table) return;
        const auto& samples = phase.samples;
        const std::string table = path + ".table";
        if (samples.size() < 2) {
            fault(table, "a table needs two samples or more");
            return;
        }
        bool light = false;
        for (std::size_t i = 0; i < samples.size(); ++i) {
            light |= samples[i].value > 0;
            if (i > 0 && samples[i].angle <= samples[i - 1].angle)
                fault(join(join(table, i), "angle"),
                      "must be larger than the one before, " +
                          format_quantity(samples[i - 1].angle, Dimension::angle));
        }
        if (!light) fault(table, "all values are 0; light must go somewhere");
    }

    void check_surface(const scene::WaterSurface& surface) {
        const std::string path = "water.surface";
        const auto& waves = surface.waves.waves;
        for (std::size_t i = 0; i < waves.size(); ++i) {
            const std::string vector_path = join(join(path + ".waves", i), "wave_vector");
            if (program_.given.count(vector_path) > 0 && glm::length(waves[i].wave_vector) == 0)
                fault(vector_path, "the vector has no length");
        }
        const scene::MeshSequence& meshes = surface.mesh_sequence;
        if (surface.type == scene::WaterSurfaceType::mesh_sequence && meshes.last_file < meshes.first_file)
            fault(path + ".last_file", "comes before first_file, " + std::to_string(meshes.first_file));
        const scene::Spectrum& sea = surface.spectrum;
        if (sea.period > 0 && sea.period < sea.cutoff_length)
            fault(path + ".period", "is shorter than cutoff_length, so that no wave fits into it");
    }

    void check_rings(const scene::Water& water) {
        if (!(water.rings.inner_size > 0)) return;
        if (water.surface.type == scene::WaterSurfaceType::mesh_sequence)
            fault("water.rings", "a mesh_sequence brings its own mesh");
        if (program_.given.count("water.mesh_cells") > 0)
            fault("water.mesh_cells", "is of a regular grid; rings.cells says how fine rings are");
    }

    void check_dispersion(const scene::Water& water) {
        if (water.refractive_index - 0.5 * water.dispersion < 1)
            fault(
                "water.dispersion",
                "half of it brings the index of red light below 1; take at most twice refractive_index - 1");
    }

    void check_caustics(const scene::Caustics& caustics) {
        const char* footprint_scale = "caustics.footprint_scale";
        if (program_.given.count(footprint_scale) > 0 &&
            caustics.photon_splatting.footprint == scene::PhotonFootprint::point)
            fault(footprint_scale, "a point has no size; take footprint: fixed for splats of a given size");
        const char* low_pass = "caustics.paper_low_pass";
        if (program_.given.count(low_pass) > 0 && !caustics.adaptive_beams.paper_faithful)
            fault(low_pass, "blurs the light of the paper's beams only; add paper_faithful: true");
        if (caustics.map.second_bounce && caustics.map.paper_faithful)
            fault("caustics.second_bounce", "is of neither paper; leave out paper_faithful");
        check_cascades(caustics.map);
        if (caustics.target_error > 0) check_target_error(caustics);
    }

    void check_target_error(const scene::Caustics& caustics) {
        const std::string target = "caustics.target_error";
        for (const char* chosen :
             {"caustics.map_resolution", "caustics.map_precision", "caustics.cascade_maps"}) {
            if (program_.given.count(chosen) > 0)
                fault(chosen, "is what " + target + " chooses; give one of them");
        }
        if (caustics.map.paper_faithful)
            fault(target,
                  "cannot be reached by what the papers do, which comes to another light; leave out "
                  "paper_faithful");
        if (caustics.photon_splatting.footprint == scene::PhotonFootprint::point)
            fault(target,
                  "cannot be reached by points, whose noise more photons do not end; take another "
                  "footprint");
    }

    void check_cascades(const scene::CausticMapParameters& map) {
        const std::string maps = "caustics.cascade_maps", precision = "caustics.map_precision";
        const std::size_t given = map.cascade_maps.size(), cascades = static_cast<std::size_t>(map.cascades);
        const auto counted = [](std::size_t count, const char* name) {
            return std::to_string(count) + " " + name + (count == 1 ? "" : "s");
        };
        if (given > 0 && given != cascades)
            fault(maps, "lists " + counted(given, "map") + " for " + counted(cascades, "cascade") +
                            "; give one for each, the innermost first");
        for (const char* other : {"caustics.map_resolution", "caustics.cascade_maps"}) {
            if (map.map_precision > 0 && program_.given.count(other) > 0)
                fault(precision, "says what " + std::string(other) + " says too; give one of them");
        }
        const std::string resolution = "caustics.map_resolution";
        if (given > 0 && program_.given.count(resolution) > 0)
            fault(resolution, "says what " + maps + " says too; give one of them");
    }

    /// One fault a key: the first frame that shows it.
    void fault(const std::string& path, const std::string& message) {
        if (!reported_.insert(path).second) return;
        const std::string where = program_.tracks.empty() ? "" : " (frame " + std::to_string(frame_) + ")";
        faults_.add(nearest_node(root_, path).place, path, message + where);
    }

    const Program& program_;
    const input::LocatedNode& root_;
    FaultList& faults_;
    std::set<std::string> reported_;
    std::int64_t frame_ = 0;
};

}  // namespace

void check_program(const Program& program, const input::LocatedNode& root, FaultList& faults) {
    Checker checker(program, root, faults);
    const scene::Clip& clip = program.base.clip;
    const std::int64_t frames = program.tracks.empty() ? 1 : clip.last_frame - clip.first_frame + 1;
    const std::int64_t samples = std::min(frames, kMostSamples);
    for (std::int64_t i = 0; i < samples; ++i)
        checker.check(
            evaluate(program, clip.first_frame + (samples > 1 ? i * (frames - 1) / (samples - 1) : 0)));
}

}  // namespace dapple::timeline
