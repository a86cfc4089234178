#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/stats.h"
#include "gpu/device.h"
#include "light/beam_mesh.h"
#include "rays/ray_scene.h"
#include "scene/frame_scene.h"
#include "view/receiver_layer.h"
#include "view/segment_layer.h"

namespace dapple::methods {

/// What a method does for a scene, and why: a line of the plan.
struct Support {
    enum class Degree { yes, partly, no };
    Degree degree = Degree::yes;
    std::string reason;
    /// Of light that media scatter: on which sides of the water it knows media.
    bool in_air = true;
    bool in_water = true;
};

/// What a method can say of itself, a value a pixel: "paths.count", "E.variance.R".
struct DataLayer {
    std::string name;
    std::vector<float> values;
};

/// E for one receiver layer, width * height entries: the mean over the cell of the pixel that the sample
/// stands for (Camera::sample_cell); where supports_surface() says so the value at its point.
struct LayerResult {
    std::vector<glm::vec3> irradiance;  ///< W/m^2; 0 where not covered
    std::vector<std::uint8_t> covered;  ///< 1 where the method answers for this receiver
    /// At the receivers' points; asked for (and written to the picture) for sample 0, branch 0 only.
    std::vector<DataLayer> data = {};
};

/// Lets a method that takes long keep what it has, and stop.
struct Checkpoint {
    std::string file;  ///< the method's own, of this frame and job; empty: nothing is kept
    std::function<bool()> stop = [] {
        return false;
    };  ///< the user wants to end: save, throw Error(interrupted)
};

/// What a method may use of the frame. All references outlive the frame.
struct FrameContext {
    const scene::FrameScene& scene;
    const rays::RayScene& rays;
    gpu::Device& device;
    FrameStats& stats;
    /// The light paths that the plan asks for, visited in this order; what is not listed costs nothing.
    std::vector<light::Chain> chains;
    Checkpoint checkpoint = {};
};

/// A way to find the caustic irradiance E at receivers. A method never sees other methods, the film or the
/// timeline, and never fills silently what it does not support: there E and `covered` are 0.
class CausticMethod {
public:
    virtual ~CausticMethod() = default;
    /// What it does for the scene, from the state alone: nothing has been built when the plan is made.
    virtual Support supports_surface(const scene::FrameState& state) const = 0;
    /// What it does for light that media scatter towards the camera. Asked only where something scatters.
    virtual Support supports_volume(const scene::FrameState&) const {
        return {Support::Degree::no, "the method finds caustics on surfaces only"};
    }
    /// Whether it covers receivers that the camera sees through or by a specular surface; layers without any
    /// other receiver are not handed to a method that does not.
    virtual bool serves_behind_specular() const { return false; }
    /// Whether it follows light through objects of glass: chains that begin there are handed to it, and light
    /// that the water sends on goes through them. For other methods glass casts shadows as objects do.
    virtual bool follows_glass() const { return false; }
    /// Whether irradiance() answers for layers of any size and of part of the pixels, not only for pictures
    /// of the context's clip and camera.
    virtual bool serves_any_layer() const { return false; }
    /// Memory that it needs beside the scene, in bytes.
    virtual std::size_t bytes(const scene::FrameState& state, std::size_t pixels) const = 0;
    /// What comes on top on devices of a type.
    virtual std::size_t bytes_on(gpu::DeviceType, const scene::FrameState&) const { return 0; }
    /// Light side, once a frame.
    virtual void begin(FrameContext& context) = 0;
    /// E of each layer; any batching of layers gives the same bits. `results` has one entry a layer.
    virtual void irradiance(FrameContext& context, std::span<const view::ReceiverLayer> layers,
                            std::span<LayerResult> results) = 0;
    /// The receivers of the layer whose segments in_scatter() is asked for next: a method that finds E with S
    /// may do so then, and keep E for irradiance().
    virtual void expect(const view::ReceiverLayer&) {}
    /// Single-scattered caustic radiance S of each segment of a layer, W/m^2/sr, attenuated to the segment's
    /// near end: light that came through one of the context's chains and is then scattered once on the
    /// segment. `radiance` has an entry a segment and holds 0. Called only where supports_volume() is not no.
    virtual void in_scatter(FrameContext&, const view::SegmentLayer&, std::span<glm::vec3>) {}
    /// What it can say of the last layer of in_scatter(), a value a pixel ("S.variance.R"); asked for (and
    /// written to the picture) for sample 0, branch 0 only, and not at half resolution, where layers lack
    /// pixels.
    virtual std::vector<DataLayer> in_scatter_data() { return {}; }
};

}  // namespace dapple::methods
