// Flicker of a clip against a reference: how much of a pixel's change from frame to frame the reference does
// not show. Arguments: folders of linear frames of the method and of `reference`, the clip's name, the first
// and the last frame, and a file for a picture of where it flickers. Prints, over all pixels that both cover
// in all frames and the three channels,
//   (mean over pixels of Var_t(E - E_ref) - mean of E_ref's own variance) / (mean of E_ref)^2
// and the same for the pixels that see one plane only: at edges between objects E of the method is that of
// the object in the pixel's middle, E of the reference the mean of both.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <vector>

#include "accuracy/flicker_series.h"
#include "base/error.h"
#include "image/exr.h"

namespace {

using namespace dapple;

struct Clip {
    std::string folder, name;
    image::Image frame(int number) const {
        char file[32];
        std::snprintf(file, sizeof file, ".%04d.exr", number);
        return image::read_exr(folder + "/linear/" + name + file);
    }
};

const std::vector<float>& channel(const image::Image& image, const std::string& name) {
    const image::Channel* found = image.find(name);
    if (!found) throw Error(ExitCode::input_unreadable, "no channel " + name);
    return found->values;
}

/// Whether the pixel's four neighbours lie in its plane, to a thousandth of their distance.
bool sees_one_plane(const image::Image& image, int x, int y) {
    const auto at = [&](int px, int py, const char* layer) {
        const auto i = static_cast<std::size_t>(py) * static_cast<std::size_t>(image.width) +
                       static_cast<std::size_t>(px);
        const std::string prefix(layer);
        return glm::dvec3(channel(image, prefix + ".X")[i], channel(image, prefix + ".Y")[i],
                          channel(image, prefix + ".Z")[i]);
    };
    const glm::dvec3 point = at(x, y, "P"), normal = at(x, y, "N");
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
            const int px = x + dx, py = y + dy;
            if (px < 0 || py < 0 || px >= image.width || py >= image.height) continue;
            const glm::dvec3 step = at(px, py, "P") - point;
            if (std::abs(glm::dot(step, normal)) > 1e-3 * (1e-6 + glm::length(step))) return false;
        }
    return true;
}

int compare(const Clip& ours, const Clip& reference, int first, int last, const std::string& map) {
    std::vector<test::Series> series;
    std::vector<bool> covered, one_plane;
    double l1 = 0, l1_sum = 0;
    for (int number = first; number <= last; ++number) {
        const image::Image a = ours.frame(number), b = reference.frame(number);
        if (a.width != b.width || a.height != b.height)
            throw Error(ExitCode::failure, "the clips' resolutions differ");
        const std::size_t pixels = a.pixels();
        if (series.empty()) {
            series.resize(3 * pixels);
            covered.assign(pixels, true);
            one_plane.assign(pixels, true);
        }
        for (int y = 0; y < a.height; ++y)
            for (int x = 0; x < a.width; ++x) {
                const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(a.width) +
                               static_cast<std::size_t>(x);
                if (!(channel(a, "covered")[i] > 0 && channel(b, "covered")[i] > 0)) covered[i] = false;
                if (one_plane[i] && !sees_one_plane(a, x, y)) one_plane[i] = false;
            }
        for (std::size_t c = 0; c < 3; ++c) {
            const std::string suffix(1, "RGB"[c]);
            const std::vector<float>& e = channel(a, "E." + suffix);
            const std::vector<float>& r = channel(b, "E." + suffix);
            const std::vector<float>& v = channel(b, "E.variance." + suffix);
            for (std::size_t i = 0; i < pixels; ++i) {
                const double difference = static_cast<double>(e[i]) - static_cast<double>(r[i]);
                series[3 * i + c].add(difference, static_cast<double>(r[i]), static_cast<double>(v[i]));
                l1 += std::abs(difference);
                l1_sum += static_cast<double>(r[i]);
            }
        }
    }
    test::FlickerSums all, planes;
    for (std::size_t i = 0; i < series.size(); ++i) {
        if (!covered[i / 3]) continue;
        all.add(series[i]);
        if (one_plane[i / 3]) planes.add(series[i]);
    }
    const auto count = static_cast<double>(series.size());
    if (!map.empty()) {
        image::Image picture;
        picture.width = reference.frame(first).width;
        picture.height = reference.frame(first).height;
        for (std::size_t c = 0; c < 3; ++c) {
            std::vector<float>& values = picture.add(std::string(1, "RGB"[c])).values;
            for (std::size_t i = 0; i < values.size(); ++i) {
                const test::Series& s = series[3 * i + c];
                values[i] = static_cast<float>(s.squares / (s.frames - 1) - s.reference_variance / s.frames);
            }
        }
        image::write_exr_verified(map, picture);
    }
    all.print("all pixels", "E", count);
    planes.print("pixels that see one plane", "E", count);
    std::printf("relative L1 distance, frame by frame: %.4f\n", l1 / l1_sum);
    return 0;
}

}  // namespace

int main(int argc, char** argv) try {
    if (argc != 6 && argc != 7) {
        std::fprintf(stderr, "usage: compare_flicker FOLDER REFERENCE_FOLDER CLIP FIRST LAST [MAP.exr]\n");
        return 2;
    }
    return compare({argv[1], argv[3]}, {argv[2], argv[3]}, std::atoi(argv[4]), std::atoi(argv[5]),
                   argc == 7 ? argv[6] : "");
} catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
