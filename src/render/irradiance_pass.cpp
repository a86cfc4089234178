#include "render/irradiance_pass.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "denoise/adaptive_kernel.h"
#include "denoise/filter.h"
#include "denoise/upsample.h"
#include "render/buffer_scale.h"

namespace dapple::render {

float weakest_light(const scene::FrameState& state) {
    float weakest = std::numeric_limits<float>::infinity();
    for (const scene::Light& light : state.lights) {
        const bool sun = light.type == scene::LightType::sun;
        const glm::dvec3 strength = sun ? light.irradiance
                                        : light.intensity *
                                              static_cast<double>(std::max(1, light.part.count)) /
                                              (light.position.y * light.position.y);
        const float found = denoise::luminance(glm::vec3(strength));
        if (found > 0 && std::isfinite(found)) weakest = std::min(weakest, found);
    }
    return std::isfinite(weakest) ? weakest : 0;
}

IrradiancePass::IrradiancePass(methods::CausticMethod& method, methods::FrameContext& context,
                               const scene::FrameScene& scene, int scale)
    : method_(method), context_(context), scene_(scene), scale_(scale) {}

void IrradiancePass::run(std::span<const view::ReceiverLayer> layers,
                         std::span<const view::ReceiverLayer> coarse,
                         std::span<methods::LayerResult> results) {
    if (scale_ == 1) {
        find(layers, results);
        return;
    }
    std::vector<methods::LayerResult> found;
    for (const view::ReceiverLayer& layer : coarse) {
        found.push_back({std::vector<glm::vec3>(layer.pixels(), glm::vec3(0)),
                         std::vector<std::uint8_t>(layer.pixels(), 0)});
    }
    find(coarse, found);
    std::vector<denoise::Irradiance> from;
    from.reserve(found.size());
    for (methods::LayerResult& result : found)
        from.push_back({std::move(result.irradiance), std::move(result.covered)});
    std::vector<std::vector<std::size_t>> missing(layers.size());
    {
        const ScopedPass pass(context_.stats, "upsampling");
        for (std::size_t i = 0; i < layers.size(); ++i) {
            const denoise::CoarseGrid grid = coarse_grid(scene_, scale_, layers[i].sample);
            denoise::Irradiance to;
            missing[i] = denoise::upsample(layers[i], coarse[i], from[i], grid, to);
            context_.stats.count("receivers off the buffer", static_cast<double>(missing[i].size()));
            if (!method_.serves_any_layer()) take_nearest(layers[i], missing[i], coarse, from, i, to);
            results[i].irradiance = std::move(to.values);
            results[i].covered = std::move(to.covered);
        }
    }
    if (method_.serves_any_layer()) ask_for(layers, missing, results);
}

/// From the layer's own buffer, then from those of the pixel's other samples: what is narrower than a pixel
/// of the buffer may be in some of them only.
void IrradiancePass::take_nearest(const view::ReceiverLayer& layer, std::vector<std::size_t> pixels,
                                  std::span<const view::ReceiverLayer> coarse,
                                  std::span<const denoise::Irradiance> from, std::size_t own,
                                  denoise::Irradiance& to) {
    for (std::size_t i = 0; i < coarse.size() && !pixels.empty(); ++i) {
        const std::size_t other = (own + i) % coarse.size();
        const denoise::CoarseGrid grid = coarse_grid(scene_, scale_, coarse[other].sample);
        pixels = denoise::take_nearest(layer, coarse[other], from[other], grid, pixels, to);
    }
    context_.stats.count("receivers without E of the buffer", static_cast<double>(pixels.size()));
}

/// E where the method finds it, through the filter.
void IrradiancePass::find(std::span<const view::ReceiverLayer> layers,
                          std::span<methods::LayerResult> results) {
    method_.irradiance(context_, layers, results);
    const scene::Denoise& settings = scene_.state.caustics.denoise;
    if (settings.filter == scene::DenoiseFilter::none) return;
    const ScopedPass pass(context_.stats, "denoise");
    const float light = weakest_light(scene_.state);
    for (std::size_t i = 0; i < layers.size(); ++i) {
        const denoise::FilteredPower power =
            denoise::filter_irradiance(layers[i], results[i].covered, settings, light, results[i].irradiance);
        // Footprints are those of whole pixels.
        const double samples = scene_.state.clip.samples;
        context_.stats.count("power before denoising, W", power.before / samples);
        context_.stats.count("power after denoising, W", power.after / samples);
    }
}

void IrradiancePass::ask_for(std::span<const view::ReceiverLayer> layers,
                             std::span<const std::vector<std::size_t>> pixels,
                             std::span<methods::LayerResult> results) {
    for (std::size_t i = 0; i < layers.size(); ++i) {
        if (pixels[i].empty()) continue;
        view::ReceiverLayer part = layers[i];
        std::fill(part.flags.begin(), part.flags.end(), 0);
        for (const std::size_t pixel : pixels[i]) part.flags[pixel] = layers[i].flags[pixel];
        methods::LayerResult found{std::vector<glm::vec3>(part.pixels(), glm::vec3(0)),
                                   std::vector<std::uint8_t>(part.pixels(), 0)};
        method_.irradiance(context_, {&part, 1}, {&found, 1});
        for (const std::size_t pixel : pixels[i]) {
            results[i].irradiance[pixel] = found.irradiance[pixel];
            results[i].covered[pixel] = found.covered[pixel];
        }
    }
}

}  // namespace dapple::render
