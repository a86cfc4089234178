#include "render/frame_scene_builder.h"

#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "grids/dense_bricks.h"
#include "grids/grid_sequence.h"
#include "grids/vdb_file.h"
#include "input/closed_mesh.h"
#include "input/mesh_file.h"
#include "ocean/lamp_mesh.h"
#include "ocean/water_surface.h"
#include "scene/area_light.h"

namespace dapple::render {
namespace {

/// A file and the grid of it.
using GridPlace = std::pair<std::string, std::string>;

std::optional<GridPlace> grid_place(const scene::FrameState& state, const scene::Medium& medium) {
    if (medium.type != scene::MediumType::grid) return std::nullopt;
    const std::optional<std::string> file = grids::shown_file(medium, state.frame - state.clip.first_frame);
    return file ? std::optional(GridPlace{*file, medium.grid}) : std::nullopt;
}

std::uint64_t sum_that_fits(std::uint64_t a, std::uint64_t b) {
    constexpr std::uint64_t most = std::numeric_limits<std::uint64_t>::max() / 2;
    return a < most && b < most ? a + b : most;
}

/// Memory for a grid, from what its file says.
struct GridBytes {
    std::uint64_t loading = 0;
    std::uint64_t bricks = 0;  ///< for each medium that shows it, of adaptive_beams
};

}  // namespace

struct FrameSceneBuilder::State {
    std::uint64_t most_grid_bytes = std::uint64_t{4} << 30;
    std::map<GridPlace, std::shared_ptr<const grids::DensityGrid>> grids;
    std::map<GridPlace, GridBytes> known_bytes;
    std::string water_key;
    std::unique_ptr<ocean::WaterSurface> surface;
    std::map<std::string, std::shared_ptr<const scene::TriangleMesh>> meshes;
    TextureFiles textures;
    std::set<std::string> closed_meshes;  ///< files of which that is known

    const ocean::WaterSurface& surface_of(const scene::Water& water) {
        const std::string key = ocean::WaterSurface::key(water);
        if (!surface || key != water_key) {
            surface = std::make_unique<ocean::WaterSurface>(water);
            water_key = key;
        }
        return *surface;
    }

    std::shared_ptr<const scene::TriangleMesh> mesh(const std::string& file) {
        std::shared_ptr<const scene::TriangleMesh>& known = meshes[file];
        if (!known) known = std::make_shared<const scene::TriangleMesh>(input::read_mesh(file));
        return known;
    }

    std::shared_ptr<const scene::TriangleMesh> mesh_of(const scene::Object& object) {
        if (object.shape != scene::Shape::mesh) return nullptr;
        auto read = mesh(object.file);
        if (object.material.glass && closed_meshes.count(object.file) == 0) {
            input::require_closed(*read, object.file);
            closed_meshes.insert(object.file);
        }
        return read;
    }

    std::vector<std::shared_ptr<const grids::DensityGrid>> medium_grids(const scene::FrameState& state) {
        std::map<GridPlace, std::shared_ptr<const grids::DensityGrid>> kept;
        for (const scene::Medium& medium : state.media) {
            if (const auto place = grid_place(state, medium)) kept[*place] = grids[*place];
        }
        grids = std::move(kept);  // before more are loaded: what the frame does not show leaves memory
        std::uint64_t taken = 0;
        for (const auto& [place, grid] : grids) taken += grid ? grid->bytes() : 0;
        for (auto& [place, grid] : grids) {
            if (grid) continue;
            grid = grids::read_vdb(place.first, place.second,
                                   most_grid_bytes > taken ? most_grid_bytes - taken : 0);
            taken += grid->bytes();
        }
        std::vector<std::shared_ptr<const grids::DensityGrid>> shown;
        for (const scene::Medium& medium : state.media) {
            const auto place = grid_place(state, medium);
            shown.push_back(place && !grids[*place]->empty() ? grids[*place] : nullptr);
        }
        return shown;
    }

    const GridBytes& bytes_of(const GridPlace& place) {
        const auto known = known_bytes.find(place);
        if (known != known_bytes.end()) return known->second;
        GridBytes bytes;  // none also of a grid that is not there, which loading will say
        for (const grids::VdbGridInfo& info : grids::read_vdb_info(place.first)) {
            if (info.name == place.second) bytes = {info.loading_bytes, grids::brick_bytes(info)};
        }
        return known_bytes[place] = bytes;
    }
};

FrameSceneBuilder::FrameSceneBuilder() : state_(std::make_unique<State>()) {}
FrameSceneBuilder::~FrameSceneBuilder() = default;

scene::FrameScene FrameSceneBuilder::build(const scene::FrameState& state) {
    scene::FrameScene built;
    built.state = ocean::with_mesh_for_lamps(scene::with_emitter_parts(state));
    // The camera's place on the water: floats are finest where the picture is.
    built.origin = {std::round(state.camera.position.x), 0, std::round(state.camera.position.z)};
    if (const std::optional<scene::Water>& water = built.state.water) {
        const glm::dvec2 viewpoint(state.camera.position.x, state.camera.position.z);
        built.water =
            std::make_shared<const scene::WaterMesh>(state_->surface_of(*water).mesh(state.time, viewpoint));
    }
    for (const scene::Object& object : state.objects) built.object_meshes.push_back(state_->mesh_of(object));
    for (const scene::Light& light : built.state.lights)
        built.light_textures.push_back(state_->textures.of_light(light, state.output));
    built.medium_grids = state_->medium_grids(state);
    return built;
}

TextureFiles& FrameSceneBuilder::textures() {
    return state_->textures;
}

void FrameSceneBuilder::limit_grids(std::uint64_t most_bytes) {
    state_->most_grid_bytes = most_bytes;
}

std::uint64_t FrameSceneBuilder::grid_bytes(const scene::FrameState& state) {
    const bool bricks = state.caustics.method == "adaptive_beams";
    std::map<GridPlace, std::uint64_t> places;
    std::uint64_t sum = 0;
    for (const scene::Medium& medium : state.media) {
        const auto place = grid_place(state, medium);
        if (!place) continue;
        const GridBytes& bytes = state_->bytes_of(*place);
        places[*place] = bytes.loading;
        if (bricks) sum = sum_that_fits(sum, bytes.bricks);
    }
    for (const auto& [place, bytes] : places) sum = sum_that_fits(sum, bytes);
    return sum;
}

}  // namespace dapple::render
