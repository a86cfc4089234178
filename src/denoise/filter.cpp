#include "denoise/filter.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/parallel.h"
#include "denoise/line_filter.h"

namespace dapple::denoise {
namespace {

constexpr std::size_t kLines = 16;      ///< in a tile: neighbouring columns share cache lines
constexpr std::size_t kTile = 1 << 14;  ///< pixels

bool finite(const glm::vec3& v) {
    return std::isfinite(v.x + v.y + v.z);
}

class LayerFilter {
public:
    LayerFilter(const view::ReceiverLayer& layer, std::span<const std::uint8_t> covered,
                const scene::Denoise& settings, float weakest_light, std::span<glm::vec3> irradiance)
        : layer_(layer),
          covered_(covered),
          settings_(settings),
          scene_luminance_(static_cast<float>(settings.threshold) * weakest_light),
          irradiance_(irradiance) {
        if (settings.filter == scene::DenoiseFilter::fixed) {
            reaches_.emplace_back(Kernel{settings.radius, 1, kFixedDistanceScale});
        } else {
            for (const Kernel& kernel : kAdaptiveKernels) reaches_.emplace_back(kernel);
        }
        for (const Reach& reach : reaches_) largest_radius_ = std::max(largest_radius_, reach.weights.size());
    }

    void pass() {
        const auto width = static_cast<std::size_t>(layer_.width),
                   height = static_cast<std::size_t>(layer_.height);
        choose_kernels();
        filter_lines(height, width, width, 1);
        if (settings_.paper_faithful) choose_kernels();
        filter_lines(width, height, 1, width);
    }

    double power() const {
        const std::size_t tiles = (layer_.pixels() + kTile - 1) / kTile;
        std::vector<double> parts(tiles, 0);
        parallel_for(layer_.pixels(), kTile, [&](std::size_t begin, std::size_t end) {
            double sum = 0;
            for (std::size_t pixel = begin; pixel < end; ++pixel) {
                if (!takes_part(pixel)) continue;
                const glm::dvec3 e(irradiance_[pixel]);
                sum += (e.x + e.y + e.z) / 3 * static_cast<double>(area(pixel));
            }
            parts[begin / kTile] = sum;
        });
        double sum = 0;
        for (const double part : parts) sum += part;
        return sum;
    }

private:
    bool takes_part(std::size_t pixel) const {
        return (layer_.flags[pixel] & view::kReceiver) && covered_[pixel] && finite(irradiance_[pixel]);
    }

    float area(std::size_t pixel) const {
        return glm::length(glm::cross(layer_.footprint_u[pixel], layer_.footprint_v[pixel]));
    }

    void choose_kernels() {
        kernels_.assign(layer_.pixels(), 0);
        if (settings_.filter == scene::DenoiseFilter::fixed) return;
        parallel_for(kernels_.size(), kTile, [&](std::size_t begin, std::size_t end) {
            for (std::size_t pixel = begin; pixel < end; ++pixel) {
                kernels_[pixel] = static_cast<std::uint8_t>(
                    adaptive_level(luminance(irradiance_[pixel]), scene_luminance_));
            }
        });
    }

    /// Line i begins at pixel i * `line_step`, its pixels are `step` apart.
    void filter_lines(std::size_t lines, std::size_t length, std::size_t line_step, std::size_t step) {
        parallel_for(lines, kLines, [&](std::size_t begin, std::size_t end) {
            std::vector<LinePixel> line(length);
            LineScratch scratch;
            for (std::size_t i = begin; i < end; ++i) {
                for (std::size_t k = 0; k < length; ++k) line[k] = pixel(i * line_step + k * step);
                if (settings_.paper_faithful) {
                    gather(line, scratch);
                } else {
                    exchange(line, largest_radius_, scratch);
                }
                for (std::size_t k = 0; k < length; ++k)
                    irradiance_[i * line_step + k * step] = line[k].irradiance;
            }
        });
    }

    LinePixel pixel(std::size_t index) const {
        LinePixel found;
        found.irradiance = irradiance_[index];
        if (!takes_part(index)) return found;
        found.guide = guide_of(layer_, index);
        found.area = area(index);
        found.depth = layer_.depth[index];
        found.reach = &reaches_[kernels_[index]];
        return found;
    }

    const view::ReceiverLayer& layer_;
    std::span<const std::uint8_t> covered_;
    const scene::Denoise& settings_;
    float scene_luminance_;
    std::vector<Reach> reaches_;
    std::vector<std::uint8_t> kernels_;  ///< of reaches_, a pixel's
    std::size_t largest_radius_ = 0;
    std::span<glm::vec3> irradiance_;
};

}  // namespace

FilteredPower filter_irradiance(const view::ReceiverLayer& layer, std::span<const std::uint8_t> covered,
                                const scene::Denoise& settings, float weakest_light,
                                std::span<glm::vec3> irradiance) {
    LayerFilter filter(layer, covered, settings, weakest_light, irradiance);
    FilteredPower power;
    power.before = power.after = filter.power();
    if (settings.filter == scene::DenoiseFilter::none) return power;
    for (int pass = 0; pass < settings.passes; ++pass) filter.pass();
    power.after = filter.power();
    return power;
}

}  // namespace dapple::denoise
