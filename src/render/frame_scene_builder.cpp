#include "render/frame_scene_builder.h"

#include <cmath>

#include "input/mesh_file.h"
#include "ocean/water_surface.h"

namespace dapple::render {

struct FrameSceneBuilder::State {
    std::string water_key;
    std::unique_ptr<ocean::WaterSurface> surface;
    std::map<std::string, std::shared_ptr<const scene::TriangleMesh>> meshes;

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
};

FrameSceneBuilder::FrameSceneBuilder() : state_(std::make_unique<State>()) {}
FrameSceneBuilder::~FrameSceneBuilder() = default;

scene::FrameScene FrameSceneBuilder::build(const scene::FrameState& state) {
    scene::FrameScene built;
    built.state = state;
    // The camera's place on the water: floats are finest where the picture is.
    built.origin = {std::round(state.camera.position.x), 0, std::round(state.camera.position.z)};
    if (state.water) {
        built.water =
            std::make_shared<const scene::WaterMesh>(state_->surface_of(*state.water).mesh(state.time));
    }
    for (const scene::Object& object : state.objects) {
        built.object_meshes.push_back(object.shape == scene::Shape::mesh ? state_->mesh(object.file)
                                                                         : nullptr);
    }
    return built;
}

}  // namespace dapple::render
