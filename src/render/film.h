#pragma once
#include <glm/glm.hpp>
#include <vector>

#include "image/image.h"
#include "methods/caustic_method.h"
#include "render/frame_renderer.h"
#include "scene/frame_state.h"
#include "view/receiver_layer.h"

namespace dapple::render {

/// What the passes found for one receiver layer, an entry a pixel.
struct LayerShading {
    std::vector<glm::vec3> albedo;
    std::vector<glm::vec3> direct;      ///< E_direct, W/m^2
    std::vector<glm::vec3> sky;         ///< E_sky, W/m^2
    std::vector<glm::vec3> flat_water;  ///< stand-in for E where it is not covered, W/m^2
    methods::LayerResult caustics;      ///< E of the method
    /// What media scatter towards the pixel, W/m^2/sr, its throughput in it; empty where the plan has no
    /// volume pass.
    std::vector<glm::vec3> volume_direct;         ///< of light that met nothing before
    std::vector<glm::vec3> volume_caustics;       ///< S of the method
    std::vector<methods::DataLayer> volume_data;  ///< what the method says of it
};

/// Sums layers into the picture and its parts: per path T (albedo / pi (E + E_direct + E_sky)) + T_env L_env
/// + what media scatter on its segments, the mean over samples. The layers must come in a fixed order.
class Film {
public:
    /// Channels of the picture: its own, and those that a method may add.
    static constexpr std::size_t kOwnChannels = 30;
    static constexpr std::size_t kVolumeChannels = 9;
    static constexpr std::size_t kMostMethodChannels = 8;

    /// `volume`: whether layers bring what media scatter, and the picture gets its channels.
    Film(int width, int height, int samples, const scene::Sky& sky, bool volume = false);
    void add(const view::ReceiverLayer& layer, LayerShading shading, glm::dvec3 origin);
    /// The layers of CONVENTIONS.md. What is not finite becomes 0 and is counted.
    image::Image finish(NonFinite& non_finite) const;
    static std::size_t sum_bytes_per_pixel(bool volume);
    static std::size_t picture_bytes_per_pixel(bool volume);  ///< of what finish() makes of the sums

private:
    int width_;
    int height_;
    float weight_;
    bool volume_;
    glm::vec3 sky_radiance_;
    /// Sums, an entry a pixel.
    std::vector<glm::vec3> beauty_, direct_, caustics_, sky_, environment_, irradiance_, volume_direct_,
        volume_caustics_;
    std::vector<float> alpha_, covered_;
    /// Data of sample 0, branch 0.
    std::vector<glm::vec3> albedo_, position_, normal_;
    std::vector<float> depth_;
    std::vector<methods::DataLayer> method_data_;
};

}  // namespace dapple::render
