#include "judge/bench_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "base/error.h"
#include "image/exr.h"
#include "judge/check_pilots.h"
#include "metrics/errors.h"
#include "metrics/flicker_track.h"

namespace dapple::judge {
namespace {

using metrics::Picture;
using metrics::picture_of;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr double kBlock = 16;  ///< pixels of a block of metrics::Errors::block_rmse

const std::vector<float>& channel(const image::Image& image, const std::string& name,
                                  const std::string& path) {
    const image::Channel* found = image.find(name);
    if (found == nullptr) throw Error(ExitCode::input_unreadable, path + ": has no channel " + name);
    return found->values;
}

/// What is looked at of one frame.
struct Frame {
    std::string path;
    image::Image image;
    const std::vector<float>& operator[](const std::string& name) const { return channel(image, name, path); }
};

Frame read(const run::OutputPaths& paths, std::int64_t number, const std::string& layer, bool all) {
    Frame frame;
    frame.path = paths.linear(number);
    frame.image = image::read_exr(frame.path, [&](const std::string& name) {
        const std::string of = name.substr(0, name.rfind('.'));
        if (name == "covered" || name == "R" || name == "G" || name == "B" || name == layer || of == layer)
            return true;
        return all && (of == "E.variance" || of == "S.variance" || of == "P" || of == "N");
    });
    return frame;
}

/// The share of each pixel that the layer tells of.
std::vector<float> coverage(const Frame& frame, const std::string& layer) {
    if (layer == kScatteredLayer) return std::vector<float>(frame.image.pixels(), 1);
    return frame["covered"];
}

/// The layer with NaN, which metrics leave out, where `keep` is false.
Picture masked(const Frame& frame, const std::string& layer, const std::vector<bool>& keep) {
    image::Image image;
    image.width = frame.image.width;
    image.height = frame.image.height;
    image.chromaticities = frame.image.chromaticities;
    const std::string prefix = layer.empty() ? "" : layer + ".";
    for (const image::Channel& source : frame.image.channels) {
        const bool wanted = source.name == layer || source.name == prefix + "R" ||
                            source.name == prefix + "G" || source.name == prefix + "B";
        if (!wanted) continue;
        std::vector<float>& values = image.add(source.name).values;
        for (std::size_t i = 0; i < values.size(); ++i) values[i] = keep[i] ? source.values[i] : kNaN;
    }
    return picture_of(image, layer, frame.path);
}

/// Sum of the layer's luminance over all pixels, each by the share of it that is covered.
double light(const Frame& frame, const std::string& layer) {
    const Picture picture = picture_of(frame.image, layer, frame.path);
    const std::vector<float> covered = coverage(frame, layer);
    double sum = 0;
    for (std::size_t i = 0; i < covered.size(); ++i)
        sum += static_cast<double>(picture.luminance[i]) * static_cast<double>(covered[i]);
    return sum;
}

/// Pixels whose neighbours show the same surface: normals turned by 20 deg at most, and no step off the
/// tangent plane larger than a third of that along it.
std::vector<bool> inside_surfaces(const Frame& frame) {
    const int width = frame.image.width, height = frame.image.height;
    const std::vector<float>*p[3], *n[3];
    for (int c = 0; c < 3; ++c) {
        p[c] = &frame[std::string("P.") + "XYZ"[c]];
        n[c] = &frame[std::string("N.") + "XYZ"[c]];
    }
    const auto at = [](const std::vector<float>* const(&layer)[3], std::size_t i) {
        return glm::dvec3((*layer[0])[i], (*layer[1])[i], (*layer[2])[i]);
    };
    const double least_cosine = std::cos(20 * std::numbers::pi / 180);
    std::vector<bool> inside(frame.image.pixels(), true);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const auto i =
                static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
            const glm::dvec3 point = at(p, i), normal = at(n, i);
            for (int k = 0; k < 9 && inside[i]; ++k) {
                const int px = x + k % 3 - 1, py = y + k / 3 - 1;
                if (px < 0 || py < 0 || px >= width || py >= height) continue;
                const auto j = static_cast<std::size_t>(py) * static_cast<std::size_t>(width) +
                               static_cast<std::size_t>(px);
                if (j == i) continue;
                const glm::dvec3 step = at(p, j) - point;
                const double off = std::abs(glm::dot(step, normal));
                inside[i] = glm::dot(normal, at(n, j)) >= least_cosine && off <= glm::length(step) / 3;
            }
        }
    }
    return inside;
}

/// Variance of a pixel's luminance: the channels' light is that of the same rays, so that their errors add.
std::vector<float> luminance_variance(const Frame& reference, const std::string& layer, double samples) {
    image::Image deviation;
    deviation.width = reference.image.width;
    deviation.height = reference.image.height;
    deviation.chromaticities = reference.image.chromaticities;
    for (const char* c : {"R", "G", "B"}) {
        const std::vector<float>& variance = reference[layer + "." + c];
        std::vector<float>& values = deviation.add(c).values;
        for (std::size_t i = 0; i < values.size(); ++i)
            values[i] = std::sqrt(variance[i] / static_cast<float>(samples));
    }
    std::vector<float> squares = picture_of(deviation, "", reference.path).luminance;
    for (float& value : squares) value *= value;
    return squares;
}

double square(double x) {
    return x * x;
}

/// What the error would be without the reference's own noise, whose square has the mean `noise`.
double root_less(double square_sum, double noise) {
    return std::sqrt(std::max(0.0, square_sum - noise));
}

/// Sums over frames, weighted by the pixels that count.
struct Sums {
    double count = 0, mean = 0, bias = 0, mae = 0, squares = 0, block_squares = 0, variance = 0;
    void add(const metrics::Errors& e, std::size_t counted, double mean_variance) {
        const auto n = static_cast<double>(counted);
        count += n;
        mean += n * e.mean;
        bias += n * e.bias;
        mae += n * e.mae;
        squares += n * square(e.rmse);
        block_squares += n * square(e.block_rmse);
        variance += n * mean_variance;
    }
    double share(double sum) const { return metrics::share_of(sum, mean); }
};

/// Contrast between neighbours of which both count.
class Contrast {
public:
    void add(const Picture& picture, const std::vector<bool>& keep) {
        const auto width = static_cast<std::size_t>(picture.width);
        const auto step = [&](std::size_t i, std::size_t j) {
            if (keep[i] && keep[j])
                sum_ += std::abs(static_cast<double>(picture.luminance[j]) -
                                 static_cast<double>(picture.luminance[i]));
        };
        for (std::size_t i = 0; i < keep.size(); ++i) {
            if ((i + 1) % width != 0) step(i, i + 1);
            if (i + width < keep.size()) step(i, i + width);
        }
    }
    double over(const Contrast& other) const {
        return sum_ == other.sum_ ? 1 : metrics::share_of(sum_, other.sum_);
    }

private:
    double sum_ = 0;
};

/// Mean over the pixels and channels of the picture that count, of the variance in `layer`.
double mean_variance(const Frame& reference, const std::string& layer, const std::vector<bool>& keep,
                     double samples) {
    double sum = 0, count = 0;
    for (const char* c : {"R", "G", "B"}) {
        const std::vector<float>& values = reference[layer + "." + c];
        for (std::size_t i = 0; i < values.size(); ++i) {
            if (!keep[i]) continue;
            sum += static_cast<double>(values[i]);
            ++count;
        }
    }
    return count > 0 ? sum / count / samples : 0;
}

}  // namespace

bool has_layer(const run::OutputPaths& paths, std::int64_t frame, const std::string& layer) {
    const std::string channel = layer + ".R";
    const image::Image image =
        image::read_exr(paths.linear(frame), [&](const std::string& name) { return name == channel; });
    return image.find(channel) != nullptr;
}

ErrorJudge::ErrorJudge(run::OutputPaths reference, std::vector<std::int64_t> frames, std::string layer,
                       int samples)
    : reference_(std::move(reference)),
      frames_(std::move(frames)),
      layer_(std::move(layer)),
      samples_(samples) {
    std::sort(frames_.begin(), frames_.end());
    if (layer_ == "E" && has_layer(reference_, frames_.front(), "E.variance")) variance_ = "E.variance";
    // There is none at half volume resolution.
    if (layer_ == kScatteredLayer && has_layer(reference_, frames_.front(), "S.variance"))
        variance_ = "S.variance";
    const bool noise_known = !variance_.empty();
    const std::vector<std::int64_t> pilots = pilot_frames(frames_);
    std::vector<Picture> pictures;
    double sum = 0, count = 0, variance = 0, deviation = 0;
    for (const std::int64_t number : frames_) {
        const Frame frame = read(reference_, number, layer_, noise_known);
        const Picture picture = picture_of(frame.image, layer_, frame.path);
        const std::vector<float> covered = coverage(frame, layer_);
        std::vector<float> squares;
        if (noise_known) squares = luminance_variance(frame, variance_, samples_);
        for (std::size_t i = 0; i < covered.size(); ++i) {
            if (!(covered[i] > 0)) continue;
            sum += static_cast<double>(picture.luminance[i]);
            ++count;
            if (!noise_known) continue;
            variance += static_cast<double>(squares[i]);
            deviation += std::sqrt(static_cast<double>(squares[i]));
        }
        if (std::ranges::find(pilots, number) != pilots.end()) {
            pictures.push_back(picture_of(frame.image, "", frame.path));
            to_rec709(pictures.back(), frame.image);
        }
    }
    noise_.mean = count > 0 ? sum / count : 0;
    noise_.pixels = count;
    if (noise_known && sum > 0) {
        noise_.rmse = std::sqrt(variance / count) / noise_.mean;
        // Of a normal distribution E|x| = sqrt(2 / pi) sigma.
        noise_.l1 = std::sqrt(2 / std::numbers::pi) * deviation / count / noise_.mean;
    }
    std::vector<const Picture*> pointers;
    pointers.reserve(pictures.size());
    for (const Picture& picture : pictures) pointers.push_back(&picture);
    exposures_ = metrics::exposures_of(pointers);
}

ErrorJudge::Judged ErrorJudge::judge(const run::OutputPaths& run, const Pixels& wanted) const {
    const bool noise_known = !variance_.empty();
    Judged judged;
    Sums all, inside_only;
    double flip = 0, light_sum = 0, reference_light = 0, counted = 0, covered_pixels = 0;
    double variance_of_luminance = 0, largest = 0, lit = 0, dark = 0;
    Contrast contrast, reference_contrast;
    metrics::FlickerTrack track;
    for (const std::int64_t number : frames_) {
        const Frame ours = read(run, number, layer_, false);
        const Frame reference = read(reference_, number, layer_, true);
        const std::size_t pixels = reference.image.pixels();
        if (ours.image.width != reference.image.width || ours.image.height != reference.image.height)
            throw Error(ExitCode::input_unreadable, ours.path + ": its size is not the reference's");
        const std::vector<float> covered = coverage(reference, layer_);
        const std::vector<float> covered_by_us = coverage(ours, layer_);
        std::vector<bool> keep(pixels), keep_inside = inside_surfaces(reference);
        const std::vector<bool> looked_at = wanted ? wanted(number) : std::vector<bool>(pixels, true);
        for (std::size_t i = 0; i < pixels; ++i) {
            covered_pixels += covered[i] > 0 ? 1 : 0;
            keep[i] = covered[i] > 0 && covered[i] == covered_by_us[i] && looked_at[i];
            keep_inside[i] = keep_inside[i] && keep[i];
        }
        Picture a = masked(ours, layer_, keep), b = masked(reference, layer_, keep);
        exclude_together(a, b);
        const metrics::Errors errors = metrics::errors_of(a, b, 1, noise_.mean);
        all.add(errors, a.counted(), noise_known ? mean_variance(reference, variance_, keep, samples_) : 0);
        largest = std::max(largest, errors.largest);
        contrast.add(a, keep);
        reference_contrast.add(b, keep);
        for (std::size_t i = 0; i < pixels; ++i) {
            lit += b.luminance[i] > 0 ? 1 : 0;
            dark += b.luminance[i] > 0 && !(a.luminance[i] > 0) ? 1 : 0;
        }
        Picture inner = masked(ours, layer_, keep_inside), inner_b = masked(reference, layer_, keep_inside);
        exclude_together(inner, inner_b);
        inside_only.add(metrics::errors_of(inner, inner_b, 1, noise_.mean), inner.counted(), 0);

        light_sum += light(ours, layer_);
        reference_light += light(reference, layer_);
        counted += static_cast<double>(b.counted());
        if (noise_known) {
            const std::vector<float> squares = luminance_variance(reference, variance_, samples_);
            for (std::size_t i = 0; i < pixels; ++i)
                variance_of_luminance += keep[i] ? static_cast<double>(squares[i]) : 0;
        }
        Picture beauty = picture_of(ours.image, "", ours.path);
        Picture reference_beauty = picture_of(reference.image, "", reference.path);
        to_rec709(beauty, ours.image);
        to_rec709(reference_beauty, reference.image);
        flip += metrics::flip_hdr(beauty, reference_beauty, exposures_).mean;

        if (number == frames_[frames_.size() / 2]) {
            judged.map = {number, a.width, a.height, std::vector<float>(pixels, kNaN)};
            for (std::size_t i = 0; i < pixels; ++i) {
                const double off = std::abs(static_cast<double>(a.luminance[i]) - b.luminance[i]);
                if (keep[i]) judged.map.values[i] = static_cast<float>(metrics::share_of(off, noise_.mean));
            }
        }
        track.add(number, std::move(a), std::move(b));
    }
    ClipErrors& errors = judged.errors;
    errors.rmse = all.share(std::sqrt(all.squares * all.count));
    errors.rmse_less_noise = all.share(root_less(all.squares, all.variance) * std::sqrt(all.count));
    errors.block_rmse = all.share(std::sqrt(all.block_squares * all.count));
    errors.block_rmse_less_noise =
        all.share(root_less(all.block_squares, all.variance / kBlock) * std::sqrt(all.count));
    errors.l1 = all.share(all.mae);
    errors.l1_inside = inside_only.share(inside_only.mae);
    errors.bias = all.share(all.bias);
    errors.largest = all.share(largest * all.count);
    errors.dark = lit > 0 ? dark / lit : 0;
    errors.detail = contrast.over(reference_contrast);
    errors.bias_error = noise_known ? all.share(std::sqrt(variance_of_luminance)) : 0;
    errors.energy = metrics::share_of(light_sum - reference_light, reference_light);
    errors.flip = flip / static_cast<double>(frames_.size());
    errors.mean = all.count > 0 ? all.mean / all.count : 0;
    errors.compared = covered_pixels > 0 ? counted / covered_pixels : 0;
    errors.inside = counted > 0 ? inside_only.count / counted : 0;

    const metrics::ClipFlicker clip = track.clip();
    if (!clip.frames.empty() && counted > 0) {
        errors.flicker = clip.flicker;
        // H of independent noise has 1 + 1/4 + 1/4 of its variance.
        const double noise = 1.5 * variance_of_luminance / counted;
        if (noise_known)
            errors.flicker_less_noise = std::isinf(clip.flicker)
                                            ? clip.flicker
                                            : clip.flicker - metrics::share_of(noise, square(clip.mean));
    }
    return judged;
}

}  // namespace dapple::judge
