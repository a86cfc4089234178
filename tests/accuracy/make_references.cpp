// Makes the stored references of the figures of accuracy: make_references FOLDER [NAME...]. Names: floor
// (own integration, see below), sloped_floor, curved_floor, column, murky_column (the method `reference`). A
// file holds the channel E (murky_column: S) for a sun of irradiance 1, and its own noise, a relative L1
// norm, as the attribute `noise`.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <numbers>
#include <string>
#include <vector>

#include "accuracy/scattered.h"
#include "accuracy/scenes.h"
#include "base/error.h"
#include "base/hash.h"
#include "base/parallel.h"
#include "image/exr.h"
#include "methods/reference/oracle_map.h"
#include "methods/reference/reference.h"
#include "methods/reference/sine_sum.h"

namespace {

using namespace dapple;

void write(const std::string& folder, const std::string& name, int side, const std::vector<double>& values,
           double noise, const char* channel = "E") {
    image::Image picture;
    picture.width = picture.height = side;
    std::ranges::transform(values, picture.add(channel).values.begin(),
                           [](double value) { return static_cast<float>(value); });
    char text[32];
    std::snprintf(text, sizeof text, "%.3e", noise);
    picture.metadata.emplace_back("noise", text);
    image::ExrOptions options;
    options.zip_level = 9;
    image::write_exr_verified(folder + "/" + name + ".exr", picture, options);
    std::printf("%s: noise %.3e\n", name.c_str(), noise);
}

// ---- the level floor, from the analytic forward map -------------------------------------------------------
//
// The map from the water to the floor is tabulated in cells of 1 mm at corners, middles of edges and centre;
// biquadratic interpolation between these is off by less than 1e-9 m, since the map's third derivatives are
// below 100 /m^2. Cells that land within one pixel give it their flux (Simpson's rule); of the others 4096
// points, a Fibonacci lattice turned round by a random shift (Cranley & Patterson 1976) of its own, are
// landed. Two such integrals are independent but for the cells that need no points, which have no noise.

constexpr int kCells = 2000;
constexpr int kPoints = 4181, kStep = 2584;  // neighbours in Fibonacci's sequence

struct Landing {
    double x, z, flux;  ///< m; W/m^2 of horizontal area of water
};

/// 1 - F of unpolarised light, by the angles' cosines.
double transmitted(double cosine, double index) {
    const double inside = std::sqrt(1 - (1 - cosine * cosine) / (index * index));
    const double s = (cosine - index * inside) / (cosine + index * inside);
    const double p = (index * cosine - inside) / (index * cosine + inside);
    return 1 - 0.5 * (s * s + p * p);
}

/// The map at the points of a row of the table.
void land_row(const scene::FrameState& state, const reference::SineSum& sea, double z, int points,
              double first_x, double step, std::vector<Landing>& row) {
    const auto n = static_cast<std::size_t>(points);
    std::vector<double> x(n), zs(n, z), height(n), slope_x(n), slope_z(n);
    for (std::size_t i = 0; i < n; ++i) x[i] = first_x + step * static_cast<double>(i);
    sea.evaluate(x, zs, height, slope_x, slope_z);
    oracle::MapConstants map;
    map.light = state.lights[0].direction;
    map.eta = 1 / state.water->refractive_index;
    map.plane = -test::kFloorDepth;
    row.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
        const auto ray = oracle::departure(map, x[i], z, height[i], slope_x[i], slope_z[i]);
        const auto at = oracle::landing(ray, x[i], z);
        const double length = std::sqrt(1 + slope_x[i] * slope_x[i] + slope_z[i] * slope_z[i]);
        row[i] = {at.x, at.z, ray.facing * transmitted(ray.facing / length, state.water->refractive_index)};
    }
}

class FloorIntegral {
public:
    explicit FloorIntegral(const scene::FrameState& state)
        : state_(state), sea_(state.water->surface.waves, state.time) {
        const scene::Extent& extent = state.water->extent;
        corner_ = extent.center - 0.5 * extent.size;
        cell_ = extent.size / double{kCells};
    }
    /// Two integrals, W/m^2 a pixel.
    std::array<std::vector<double>, 2> run() const {
        constexpr auto pixels = static_cast<std::size_t>(test::kFloorPixels * test::kFloorPixels);
        constexpr int band = 50;
        constexpr auto bands = static_cast<std::size_t>(kCells / band);
        std::vector<std::array<std::vector<double>, 2>> parts(bands);
        parallel_for(bands, 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t b = begin; b < end; ++b) {
                for (auto& half : parts[b]) half.assign(pixels, 0);
                for (int row = 0; row < band; ++row) add_row(static_cast<int>(b) * band + row, parts[b]);
            }
        });
        std::array<std::vector<double>, 2> sums;
        for (auto& half : sums) half.assign(pixels, 0);
        for (const auto& part : parts)
            for (std::size_t h = 0; h < 2; ++h)
                for (std::size_t i = 0; i < pixels; ++i) sums[h][i] += part[h][i];
        const double a_pixel = 1.0 / static_cast<double>(pixels);
        for (auto& half : sums)
            for (double& value : half) value *= cell_.x * cell_.y / a_pixel;
        return sums;
    }

private:
    static int pixel(double metres) {
        return static_cast<int>(std::floor((metres + 0.5) * test::kFloorPixels));
    }
    static bool inside(int p) { return p >= 0 && p < test::kFloorPixels; }
    static std::size_t index(int x, int z) { return static_cast<std::size_t>(z * test::kFloorPixels + x); }

    void add_row(int row, std::array<std::vector<double>, 2>& halves) const {
        std::vector<Landing> lines[3];
        for (int k = 0; k < 3; ++k)
            land_row(state_, sea_, corner_.y + cell_.y * (row + 0.5 * k), 2 * kCells + 1, corner_.x,
                     0.5 * cell_.x, lines[k]);
        for (int column = 0; column < kCells; ++column) {
            const Landing* nodes[3];
            for (int k = 0; k < 3; ++k) nodes[k] = lines[k].data() + 2 * column;
            add_cell(nodes, static_cast<std::uint64_t>(row) * kCells + static_cast<std::uint64_t>(column),
                     halves);
        }
    }
    void add_cell(const Landing* const (&nodes)[3], std::uint64_t number,
                  std::array<std::vector<double>, 2>& halves) const {
        double low_x = 1e9, high_x = -1e9, low_z = 1e9, high_z = -1e9;
        for (const Landing* line : nodes)
            for (int i = 0; i < 3; ++i) {
                low_x = std::min(low_x, line[i].x);
                high_x = std::max(high_x, line[i].x);
                low_z = std::min(low_z, line[i].z);
                high_z = std::max(high_z, line[i].z);
            }
        // A quadratic leaves the range of its three values by an eighth of its second difference at most;
        // here that is 3 um at most, since the second derivatives are below 20 /m.
        constexpr double more = 1e-5;
        const int x0 = pixel(low_x - more), x1 = pixel(high_x + more);
        const int z0 = pixel(low_z - more), z1 = pixel(high_z + more);
        if (x1 < 0 || z1 < 0 || x0 >= test::kFloorPixels || z0 >= test::kFloorPixels) return;
        if (x0 == x1 && z0 == z1) {
            constexpr double simpson[3] = {1.0 / 6, 4.0 / 6, 1.0 / 6};
            double flux = 0;
            for (int k = 0; k < 3; ++k)
                for (int i = 0; i < 3; ++i) flux += simpson[k] * simpson[i] * nodes[k][i].flux;
            for (auto& half : halves) half[index(x0, z0)] += flux;
            return;
        }
        for (std::size_t h = 0; h < 2; ++h) add_points(nodes, number, h, halves[h]);
    }
    void add_points(const Landing* const (&nodes)[3], std::uint64_t number, std::size_t half,
                    std::vector<double>& sums) const {
        // Coefficients of s^i t^k, s and t in [0, 1].
        double x[3][3], z[3][3], flux[3][3];
        const auto coefficients = [&](auto&& value, double(&out)[3][3]) {
            double along[3][3];
            const auto fit = [](double a, double b, double c, double(&to)[3]) {
                to[0] = a;
                to[1] = -3 * a + 4 * b - c;
                to[2] = 2 * a - 4 * b + 2 * c;
            };
            for (int k = 0; k < 3; ++k)
                fit(value(nodes[k][0]), value(nodes[k][1]), value(nodes[k][2]), along[k]);
            for (int i = 0; i < 3; ++i) {
                double column[3];
                fit(along[0][i], along[1][i], along[2][i], column);
                for (int k = 0; k < 3; ++k) out[k][i] = column[k];
            }
        };
        coefficients([](const Landing& l) { return (l.x + 0.5) * test::kFloorPixels; }, x);
        coefficients([](const Landing& l) { return (l.z + 0.5) * test::kFloorPixels; }, z);
        coefficients([](const Landing& l) { return l.flux / kPoints; }, flux);
        const auto at = [](const double(&c)[3][3], double s, double t) {
            return c[0][0] + s * (c[0][1] + s * c[0][2]) + t * (c[1][0] + s * (c[1][1] + s * c[1][2])) +
                   t * t * (c[2][0] + s * (c[2][1] + s * c[2][2]));
        };
        double s = hash_uniform(1 + half, 0, number, 0), t = hash_uniform(1 + half, 0, number, 1);
        constexpr double step_s = 1.0 / kPoints, step_t = double{kStep} / kPoints;
        for (int i = 0; i < kPoints; ++i) {
            const double px = at(x, s, t), pz = at(z, s, t);
            if (px >= 0 && pz >= 0 && px < test::kFloorPixels && pz < test::kFloorPixels)
                sums[index(static_cast<int>(px), static_cast<int>(pz))] += at(flux, s, t);
            s += step_s;
            t += step_t;
            s -= s >= 1 ? 1 : 0;
            t -= t >= 1 ? 1 : 0;
        }
    }

    scene::FrameState state_;
    reference::SineSum sea_;
    glm::dvec2 corner_, cell_;
};

void make_floor(const std::string& folder) {
    const auto halves = FloorIntegral(test::level_floor(1)).run();
    std::vector<double> mean(halves[0].size());
    double difference = 0, sum = 0;
    for (std::size_t i = 0; i < mean.size(); ++i) {
        mean[i] = 0.5 * (halves[0][i] + halves[1][i]);
        difference += 0.5 * std::abs(halves[0][i] - halves[1][i]);
        sum += mean[i];
    }
    // Half the difference of two equal estimates has the spread of their mean.
    write(folder, "floor", test::kFloorPixels, mean, difference / sum);
}

void make_picture(const std::string& folder, const std::string& name, scene::FrameState state,
                  double standard_error, gpu::Device& device) {
    state.caustics.reference.standard_error = standard_error;
    state.caustics.reference.most_rays = 4000;
    methods::Reference method;
    const test::Picture picture = test::take_picture(state, method, device);
    std::vector<double> values;
    for (const glm::vec3& e : picture.result.irradiance) values.push_back(static_cast<double>(e.g));
    // A mean of standard errors; |error| of a normal distribution is 0.8 of that.
    const double noise = std::sqrt(2 / std::numbers::pi) * picture.stats.counted("reference standard error");
    write(folder, name, state.clip.width, values, noise);
    std::printf("%.0f rays, %.0f s of CPU\n", picture.stats.counted("reference rays"), cpu_seconds());
    std::fflush(stdout);
}

/// Of light that media scatter.
void make_scattered(const std::string& folder, const std::string& name, scene::FrameState state,
                    double standard_error, gpu::Device& device) {
    state.caustics.reference.standard_error = standard_error;
    state.caustics.reference.most_rays = 4000;
    methods::Reference method;
    const test::ScatteredPicture picture = test::take_scattered(state, method, device);
    const double noise =
        std::sqrt(2 / std::numbers::pi) * picture.stats.counted("reference volume standard error");
    write(folder, name, state.clip.width, picture.radiance, noise, "S");
    std::printf("%.0f rays, %.0f s of CPU\n", picture.stats.counted("reference volume rays"), cpu_seconds());
    std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) try {
    if (argc < 2) {
        std::fprintf(stderr, "usage: make_references FOLDER [NAME...]\n");
        return 2;
    }
    const std::string folder = argv[1];
    const auto wanted = [&](const char* name) {
        return argc == 2 || std::find_if(argv + 2, argv + argc, [&](const char* argument) {
                                return std::string(argument) == name;
                            }) != argv + argc;
    };
    if (wanted("floor")) make_floor(folder);
    gpu::Device device{{}};
    constexpr double cells = 64;  // of what the camera sees the floor through: as the tests
    if (wanted("sloped_floor"))
        make_picture(folder, "sloped_floor", test::sloped_floor(cells), 0.008, device);
    if (wanted("curved_floor"))
        make_picture(folder, "curved_floor", test::curved_floor(cells), 0.008, device);
    if (wanted("murky_column")) make_scattered(folder, "murky_column", test::murky_column(16), 0.004, device);
    if (wanted("column")) make_picture(folder, "column", test::column_in_pool(cells), 0.008, device);
    return 0;
} catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
