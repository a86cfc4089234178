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
};

/// Sums layers into the picture and its parts: per path T (albedo / pi (E + E_direct + E_sky)) + T_env L_env,
/// the mean over samples. The layers must come in a fixed order.
class Film {
public:
    /// Channels of the picture: its own, and those that a method may add.
    static constexpr std::size_t kOwnChannels = 30;
    static constexpr std::size_t kMostMethodChannels = 8;

    Film(int width, int height, int samples, const scene::Sky& sky);
    void add(const view::ReceiverLayer& layer, LayerShading shading, glm::dvec3 origin);
    /// The layers of CONVENTIONS.md. What is not finite becomes 0 and is counted.
    image::Image finish(NonFinite& non_finite) const;
    /// Bytes of the sums and of the image that they become, a pixel.
    static std::size_t bytes_per_pixel();

private:
    int width_;
    int height_;
    float weight_;
    glm::vec3 sky_radiance_;
    /// Sums, an entry a pixel.
    std::vector<glm::vec3> beauty_, direct_, caustics_, sky_, environment_, irradiance_;
    std::vector<float> alpha_, covered_;
    /// Data of sample 0, branch 0.
    std::vector<glm::vec3> albedo_, position_, normal_;
    std::vector<float> depth_;
    std::vector<methods::DataLayer> method_data_;
};

}  // namespace dapple::render
