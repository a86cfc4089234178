#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "base/stats.h"
#include "gpu/device.h"
#include "methods/caustic_method.h"
#include "rays/ray_scene.h"
#include "render/frame_scene_builder.h"
#include "render/plan.h"
#include "scene/frame_scene.h"
#include "view/receiver_layer.h"

namespace dapple::render {

/// E of a picture, an entry a pixel: W/m^2, the mean over the covered ones of its camera paths.
struct PixelIrradiance {
    std::vector<glm::vec3> values;      ///< 0 where not covered
    std::vector<std::uint8_t> covered;  ///< 1 where at least one path is
};

/// What all camera paths of a pixel end on.
struct PixelSurface {
    static constexpr std::uint32_t kMixed = UINT32_MAX;
    std::uint32_t object = kMixed;  ///< kMixed: on different objects or sides of one, or some on nothing
    glm::vec3 normal{0};
    /// Whether two pixels look at one face, or at parts of a round one that hardly turn.
    bool same_face(const PixelSurface& other) const;
};

/// One frame whose E is asked for under several settings of its method, and nothing else. What those leave
/// alone (water, objects, camera paths) is made once.
class PilotFrame {
public:
    /// Error(input_unreadable) for meshes and textures. The references outlive the pilot.
    PilotFrame(const scene::FrameState& state, FrameSceneBuilder& builder, methods::CausticMethod& method,
               gpu::Device& device, FrameStats& stats);

    /// Whether there is a light path that the method traces for receivers.
    bool lit() const { return plan_.caustics; }
    /// Of branch 0, as the picture's layer E. Bits repeat on any number of threads, and whatever was asked
    /// for before.
    PixelIrradiance irradiance(const scene::Caustics& settings);
    /// An entry a pixel.
    std::vector<PixelSurface> surfaces() const;

private:
    /// Pixels that E is found for: the picture's own, or those of a buffer.
    struct View {
        scene::FrameScene scene;
        std::vector<view::ReceiverLayer> layers;  ///< a sample each
    };
    View look(int scale);

    methods::CausticMethod& method_;
    gpu::Device& device_;
    FrameStats& stats_;
    scene::FrameScene scene_;
    Plan plan_;
    rays::RayScene rays_;
    View picture_;
    std::optional<View> buffer_;
};

}  // namespace dapple::render
