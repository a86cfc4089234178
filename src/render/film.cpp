#include "render/film.h"

#include <cassert>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <iterator>

#include "base/parallel.h"

namespace dapple::render {
namespace {

constexpr std::size_t kTile = 4096;

image::Channel channel(const std::string& name, std::size_t pixels) {
    return {name, image::PixelType::float32, std::vector<float>(pixels)};
}

class ImageWriter {
public:
    ImageWriter(image::Image& image) : image_(image) {}

    void scalar(const std::string& name, const std::vector<float>& values, float scale) {
        image::Channel& added = image_.channels.emplace_back(channel(name, image_.pixels()));
        for (std::size_t i = 0; i < values.size(); ++i) added.values[i] = scale * values[i];
    }

    /// Three channels `prefix` + a letter of `letters`.
    void vector(const std::string& prefix, const char* letters, const std::vector<glm::vec3>& values,
                float scale) {
        for (int axis = 0; axis < 3; ++axis) {
            image::Channel& added =
                image_.channels.emplace_back(channel(prefix + letters[axis], image_.pixels()));
            for (std::size_t i = 0; i < values.size(); ++i) added.values[i] = scale * values[i][axis];
        }
    }

private:
    image::Image& image_;
};

}  // namespace

Film::Film(int width, int height, int samples, const scene::Sky& sky, bool volume)
    : width_(width),
      height_(height),
      weight_(1.0f / static_cast<float>(samples)),
      volume_(volume),
      sky_radiance_(sky.radiance) {
    const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    for (auto* sum : {&beauty_, &direct_, &caustics_, &sky_, &environment_, &irradiance_, &albedo_,
                      &position_, &normal_}) {
        sum->assign(pixels, glm::vec3(0));
    }
    if (volume) {
        for (auto* sum : {&volume_direct_, &volume_caustics_}) sum->assign(pixels, glm::vec3(0));
    }
    for (auto* sum : {&alpha_, &covered_, &depth_}) sum->assign(pixels, 0);
}

std::size_t Film::sum_bytes_per_pixel(bool volume) {
    return (9 + (volume ? 2 : 0)) * sizeof(glm::vec3) + (3 + kMostMethodChannels) * sizeof(float);
}

std::size_t Film::picture_bytes_per_pixel(bool volume) {
    return (kOwnChannels + kMostMethodChannels + (volume ? kVolumeChannels : 0)) * sizeof(float);
}

void Film::add(const view::ReceiverLayer& layer, LayerShading shading, glm::dvec3 origin) {
    const bool data = layer.sample == 0 && layer.branch == 0;
    if (data) {
        method_data_ = std::move(shading.caustics.data);
        std::move(shading.volume_data.begin(), shading.volume_data.end(), std::back_inserter(method_data_));
    }
    const float inverse_pi = glm::one_over_pi<float>();
    parallel_for(layer.pixels(), kTile, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::uint32_t flags = layer.flags[i];
            const glm::vec3 throughput = weight_ * layer.throughput[i];
            if (flags & view::kEnvironment) {
                environment_[i] += throughput * sky_radiance_;
                beauty_[i] += throughput * sky_radiance_;
            }
            if (flags & view::kReceiver) {
                const glm::vec3 response = throughput * shading.albedo[i] * inverse_pi;
                direct_[i] += response * shading.direct[i];
                caustics_[i] += response * shading.caustics.irradiance[i];
                sky_[i] += response * shading.sky[i];
                beauty_[i] += response * (shading.direct[i] + shading.caustics.irradiance[i] +
                                          shading.sky[i] + shading.flat_water[i]);
            }
            if (volume_) {
                volume_direct_[i] += weight_ * shading.volume_direct[i];
                volume_caustics_[i] += weight_ * shading.volume_caustics[i];
                beauty_[i] += weight_ * (shading.volume_direct[i] + shading.volume_caustics[i]);
            }
            if (layer.branch == 0) {
                if (std::isfinite(layer.depth[i])) alpha_[i] += weight_;
                if (shading.caustics.covered[i]) {
                    covered_[i] += 1;
                    irradiance_[i] += shading.caustics.irradiance[i];
                }
            }
            if (data) {
                depth_[i] = std::isfinite(layer.depth[i]) ? layer.depth[i] : 0;
                if (flags & view::kReceiver) {
                    albedo_[i] = shading.albedo[i];
                    position_[i] = glm::vec3(glm::dvec3(layer.position[i]) + origin);
                    normal_[i] = layer.shading_normal[i];
                }
            }
        }
    });
}

image::Image Film::finish(NonFinite& non_finite) const {
    image::Image image;
    image.width = width_;
    image.height = height_;
    ImageWriter write(image);
    write.vector("", "RGB", beauty_, 1);
    write.scalar("A", alpha_, 1);
    write.vector("direct.", "RGB", direct_, 1);
    write.vector("caustics.", "RGB", caustics_, 1);
    write.vector("sky.", "RGB", sky_, 1);
    write.vector("environment.", "RGB", environment_, 1);
    std::vector<glm::vec3> mean_irradiance = irradiance_;
    for (std::size_t i = 0; i < mean_irradiance.size(); ++i)
        mean_irradiance[i] /= std::max(1.0f, covered_[i]);
    if (volume_) {
        std::vector<glm::vec3> volume = volume_direct_;
        for (std::size_t i = 0; i < volume.size(); ++i) volume[i] += volume_caustics_[i];
        write.vector("volume.", "RGB", volume, 1);
        write.vector("volume_direct.", "RGB", volume_direct_, 1);
        write.vector("volume_caustics.", "RGB", volume_caustics_, 1);
    }
    write.vector("E.", "RGB", mean_irradiance, 1);
    write.vector("albedo.", "RGB", albedo_, 1);
    write.vector("P.", "XYZ", position_, 1);
    write.vector("N.", "XYZ", normal_, 1);
    write.scalar("Z", depth_, 1);
    write.scalar("covered", covered_, weight_);
    assert(image.channels.size() == kOwnChannels + (volume_ ? kVolumeChannels : 0) &&
           method_data_.size() <= kMostMethodChannels);
    for (const methods::DataLayer& layer : method_data_) {
        assert(layer.values.size() == image.pixels() && !image.find(layer.name));
        write.scalar(layer.name, layer.values, 1);
    }
    for (image::Channel& channel : image.channels) {
        for (std::size_t i = 0; i < channel.values.size(); ++i) {
            if (std::isfinite(channel.values[i])) continue;
            channel.values[i] = 0;
            const std::size_t width = static_cast<std::size_t>(width_);
            if (non_finite.count++ == 0) {
                non_finite.first =
                    channel.name + " " + std::to_string(i % width) + "," + std::to_string(i / width);
            }
        }
    }
    return image;
}

}  // namespace dapple::render
