// What the light pass of photon_splatting costs in a pool, part by part, beside the least that it could: bare
// Embree with the same rays (those that land, and those back to the sun), and a bare raster of the same
// triangles into a map and of as many sprites of the same areas into one picture, all in one run. CPU seconds
// of all threads, medians; parts and limits take turns, so that what else the machine does falls on both.
//
//     bench_caustic_map [repetitions] [footprint...] [photons along a side...]
//
// Footprints by the names that timelines have; without any, tents.
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "bare_embree.h"
#include "base/hash.h"
#include "base/stats.h"
#include "gpu/pass_list.h"
#include "light/caustic_map.h"
#include "light/grid_blocks.h"
#include "light/landing.h"
#include "light/light_shadows.h"
#include "methods/coverage_scene.h"  // of the tests
#include "methods/photon_splatting/splat_builder.h"
#include "methods/photon_splatting/splat_renderer.h"
#include "spirv/light_caustic_map_frag.h"
#include "spirv/test_flat_frag.h"
#include "spirv/test_sprites_vert.h"
#include "spirv/test_surface_vert.h"

namespace {

using namespace dapple;

constexpr int kWidth = 960, kHeight = 540;
constexpr int kCells = 512;  // half a million triangles, as pool.yaml has

/// Numbers by name, one entry a repetition.
class Costs {
public:
    void add(const std::string& name, double number) { of_[name].push_back(number); }
    double median(const std::string& name) {
        std::vector<double>& all = of_[name];
        if (all.empty()) return 0;
        std::nth_element(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2), all.end());
        return all[all.size() / 2];
    }

private:
    std::map<std::string, std::vector<double>> of_;
};

/// CPU time and page faults from here on.
class Meter {
public:
    Meter() : cpu_s_(cpu_seconds()) { getrusage(RUSAGE_SELF, &first_); }
    void stop(Costs& costs, const std::string& name) const {
        costs.add(name, cpu_seconds() - cpu_s_);
        rusage last{};
        getrusage(RUSAGE_SELF, &last);
        const auto system = [](const rusage& usage) {
            return static_cast<double>(usage.ru_stime.tv_sec) +
                   1e-6 * static_cast<double>(usage.ru_stime.tv_usec);
        };
        costs.add(name + ", system", system(last) - system(first_));
        costs.add(name + ", faults", static_cast<double>(last.ru_minflt - first_.ru_minflt));
    }

private:
    double cpu_s_;
    rusage first_{};
};

template <class Work>
void measure(Costs& costs, const char* name, const Work& work) {
    const Meter meter;
    work();
    meter.stop(costs, name);
}

/// A draw without anything that a method would do.
class BareRaster {
public:
    BareRaster(gpu::Device& device, const scene::FrameScene& frame)
        : device_(device),
          mesh_(device, "bare map", test_surface_vert, light_caustic_map_frag,
                {.interface = {.storage_buffers = 1},
                 .color_formats = {gpu::Format::rgba32f},
                 .depth_test = true}),
          points_(device, "bare sprites", test_sprites_vert, test_flat_frag,
                  {.interface = {.storage_buffers = 1, .push_bytes = sizeof(glm::vec2)},
                   .topology = gpu::Topology::points,
                   .blend = gpu::Blend::add,
                   .color_formats = {gpu::Format::rgba32f}}),
          vertices_(device, "vertices", sizeof(Vertex) * frame.water->mesh.positions.size()),
          indices_(device, "indices", sizeof(glm::uvec3) * frame.water->mesh.triangles.size()),
          picture_(device, "picture", kWidth, kHeight, gpu::Format::rgba32f) {
        const scene::TriangleMesh& water = frame.water->mesh;
        const glm::dvec2 half = 0.5 * frame.state.water->extent.size;
        for (std::size_t i = 0; i < water.positions.size(); ++i) {
            const glm::dvec3 p = water.positions[i];
            vertices_.as<Vertex>()[i] = {{p.x / half.x, p.z / half.y, 0.5 - p.y},
                                         glm::vec4(p.y, glm::vec3(water.normals[i]))};
        }
        std::copy(water.triangles.begin(), water.triangles.end(), indices_.as<glm::uvec3>().begin());
    }

    void map(int columns, int rows) {
        if (!color_ || color_->width() != columns || color_->height() != rows) {
            color_.emplace(device_, "map", columns, rows, gpu::Format::rgba32f);
            depth_.emplace(device_, "depth", columns, rows, gpu::Format::depth32f);
        }
        gpu::PassList passes(device_);
        FrameStats stats;
        passes.draw("map", mesh_, {.buffers = {&vertices_}}, {.colors = {&*color_}, .depth = &*depth_},
                    {.vertices = static_cast<std::uint32_t>(indices_.bytes() / sizeof(std::uint32_t)),
                     .index_buffer = &indices_});
        passes.run(stats);
    }

    void clear() {
        sprites_.clear();
        covered_ = 0;
    }
    /// Squares, large splats of the same area as their parallelograms.
    void take(const methods::Splats& splats) {
        for (const auto* bands : {&splats.points, &splats.quads}) {
            std::vector<Sprite>& all = waiting_[bands == &splats.points ? 0 : 1];
            for (const LargeVector<layout::Splat>& band : *bands)
                for (const layout::Splat& splat : band) {
                    const float side = bands == &splats.points
                                           ? 2 * std::max(splat.edge_a.x, splat.edge_b.y)
                                           : 2 * std::sqrt(std::abs(splat.edge_a.x * splat.edge_b.y -
                                                                    splat.edge_a.y * splat.edge_b.x));
                    covered_ += static_cast<double>(side * side);
                    all.push_back({splat.center, std::min(side, device_.largest_point_size()), glm::vec4(1)});
                }
        }
    }
    /// Makes buffers of all that were taken.
    void finish() {
        for (const std::vector<Sprite>& all : waiting_) {
            const std::size_t most = device_.largest_storage_range() / sizeof(Sprite);
            for (std::size_t first = 0; first < all.size(); first += most) {
                const std::size_t count = std::min(most, all.size() - first);
                sprites_.emplace_back(device_, "sprites", count * sizeof(Sprite));
                std::copy_n(all.begin() + static_cast<std::ptrdiff_t>(first), count,
                            sprites_.back().as<Sprite>().begin());
            }
        }
        waiting_ = {};
    }
    /// Pixels of all sprites together.
    double covered() const { return covered_; }
    void sprites() {
        gpu::PassList passes(device_);
        FrameStats stats;
        gpu::Targets targets{.colors = {&picture_}};
        for (gpu::Buffer& buffer : sprites_) {
            gpu::Bindings bindings{.buffers = {&buffer}};
            bindings.set_push(glm::vec2(kWidth, kHeight));
            passes.draw("sprites", points_, std::move(bindings), targets,
                        {.vertices = static_cast<std::uint32_t>(buffer.bytes() / sizeof(Sprite))});
            targets.clear = false;
        }
        passes.run(stats);
    }

private:
    struct Vertex {  // as in test/surface.vert
        glm::vec3 clip;
        glm::vec4 value;
    };
    struct Sprite {  // as in test/sprites.vert
        glm::vec2 position;
        float width;
        glm::vec4 color;
    };
    gpu::Device& device_;
    gpu::RasterPipeline mesh_, points_;
    gpu::Buffer vertices_, indices_;
    gpu::Image picture_;
    std::optional<gpu::Image> color_, depth_;     // of the map: memory that is there already
    std::array<std::vector<Sprite>, 2> waiting_;  // points, quads
    std::vector<gpu::Buffer> sprites_;
    double covered_ = 0;
};

/// One pool, all sizes of maps.
class Bench {
public:
    explicit Bench(scene::FrameScene& frame)
        : frame_(frame),
          device_(gpu::DeviceOptions{}),
          rays_(frame),
          mapper_(device_),
          host_(methods::host_splat_renderer()),
          rasteriser_(methods::device_splat_renderer(device_)),
          media_(frame),
          bare_rays_(frame),
          bare_raster_(device_, frame) {
        view::LayerCounts counts;
        layers_.push_back(view::trace_layer(frame, rays_, {}, counts));
        results_.resize(1);
        rastered_.resize(1);
    }

    void run(int side, int repetitions) {
        frame_.state.caustics.map.map_resolution = side;
        Costs costs;
        for (int i = -1; i < repetitions; ++i) {  // the first one compiles shaders, and counts for nothing
            Costs unused;
            once(i < 0 ? unused : costs, i < 0);
        }
        print(side, costs);
    }

private:
    void once(Costs& costs, bool first) {
        FrameStats stats;
        const methods::SplatStyle style = methods::splat_style(frame_.state.caustics);
        host_->clear();
        rasteriser_->clear();
        const auto splat = [&](const light::BeamMesh& mesh, auto take) {
            methods::build_splats(frame_, media_, mesh, landings_, style, device_.largest_point_size(), take);
        };
        int columns = 0, rows = 0;
        const Meter tracing;
        mapper_.trace_each(frame_, rays_, 0, {light::Event::transmission}, frame_.state.caustics.map,
                           light::PhotonCells::tents, stats, [&](std::span<light::BeamMesh> meshes) {
                               tracing.stop(costs, "tracing");
                               const light::BeamMesh& mesh = meshes[0];
                               columns = mesh.columns;
                               rows = mesh.rows;
                               measure(costs, "landing", [&] { light::land(mesh, rays_, landings_); });
                               measure(costs, "footprints", [&] {
                                   splat(mesh, [&](const methods::Splats& splats) { host_->add(splats); });
                               });
                               splat(mesh, [&](const methods::Splats& splats) { rasteriser_->add(splats); });
                               if (!first) return;
                               take_rays(mesh);
                               bare_raster_.clear();
                               splat(mesh, [&](const methods::Splats& s) { bare_raster_.take(s); });
                               bare_raster_.finish();
                               photons_ = static_cast<std::size_t>(stats.counted("photons"));
                               splats_ = host_->points() + host_->quads();
                           });
        std::map<std::string, double> passes;
        for (const PassTime& pass : stats.passes()) passes[pass.name] += pass.cpu_s;
        for (const auto& [name, seconds] : passes) costs.add(name, seconds);
        measure(costs, "splatting", [&] { host_->render(frame_, style, layers_, results_, stats); });
        measure(costs, "rasteriser", [&] { rasteriser_->render(frame_, style, layers_, rastered_, stats); });
        measure(costs, "bare map", [&] { bare_raster_.map(columns, rows); });
        measure(costs, "bare landing", [&] { bare_rays_.intersect(landing_); });
        measure(costs, "bare shadows", [&] { bare_rays_.occluded(to_light_); });
        measure(costs, "bare splatting", [&] { bare_raster_.sprites(); });
    }

    /// Those of the light pass, in its order. What is shadowed is not landed.
    void take_rays(const light::BeamMesh& mesh) {
        std::vector<rays::Ray> landing, to_light;
        const light::GridBlocks blocks(mesh.rows, mesh.columns);
        for (std::size_t band = 0; band < blocks.bands(); ++band)
            blocks.visit_band(band, [&](std::size_t i) {
                if (!mesh.valid[i]) return;
                rays::Ray ray;
                ray.origin = mesh.origin[i] + mesh.start[i] * mesh.slope[i];
                ray.direction = mesh.slope[i];
                to_light.push_back(light::ray_to_light(frame_, frame_.state.lights[0], ray.origin));
                if (mesh.flux[i] > 0) landing.push_back(ray);
            });
        landing_ = test::BareEmbree::packets(landing);
        to_light_ = test::BareEmbree::packets(to_light);
    }

    void print(int side, Costs& costs) const {
        const auto ms = [&](const char* name) { return 1e3 * costs.median(name); };
        const double bare = ms("bare map") + ms("bare landing") + ms("bare shadows");
        const double traced = ms("tracing") + ms("landing");
        const double pass = traced + ms("footprints");
        const double photons = static_cast<double>(photons_), covered = bare_raster_.covered();
        std::printf("%d^2: %.2f M photons, %.2f M splats of %.1f pixels; CPU ms\n", side, 1e-6 * photons,
                    1e-6 * static_cast<double>(splats_), covered / static_cast<double>(splats_));
        std::printf(
            "  tracing %.0f (map %.0f, refraction %.0f, shadow rays %.0f), landing rays %.0f, footprints "
            "%.0f; splatting %.0f, by the device %.0f\n",
            ms("tracing"), ms("caustic map"), ms("refraction"), ms("light shadows"), ms("landing"),
            ms("footprints"), ms("splatting"), ms("rasteriser"));
        const auto all = [&](const char* what) {
            double sum = 0;
            for (const char* part : {"tracing", "landing", "footprints"})
                sum += costs.median(std::string(part) + what);
            return sum;
        };
        std::printf("  system ms (page faults): to footprints %.0f (%.0f), splatting %.0f (%.0f)\n",
                    1e3 * all(", system"), all(", faults"), ms("splatting, system"),
                    costs.median("splatting, faults"));
        std::printf("  bare: map %.0f, shadow rays %.0f, landing rays %.0f; sprites %.0f\n", ms("bare map"),
                    ms("bare shadows"), ms("bare landing"), ms("bare splatting"));
        std::printf(
            "  ratio: map to landing %.2f, with footprints %.2f; splatting %.2f, by the device %.2f; all "
            "%.2f, were splatting bare %.2f\n",
            traced / bare, pass / bare, ms("splatting") / ms("bare splatting"),
            ms("rasteriser") / ms("bare splatting"), (pass + ms("splatting")) / (bare + ms("bare splatting")),
            (pass + ms("splatting")) / (bare + ms("splatting")));
        std::printf("  ns: a photon %.0f; splatting, a splat %.0f, a covered pixel %.1f\n",
                    1e6 * pass / photons, 1e6 * ms("splatting") / static_cast<double>(splats_),
                    1e6 * ms("splatting") / covered);
        const std::vector<glm::vec3>& irradiance = results_[0].irradiance;
        double off = 0, sum = 0;
        for (std::size_t i = 0; i < irradiance.size(); ++i) {
            off += static_cast<double>(glm::distance(irradiance[i], rastered_[0].irradiance[i]));
            sum += static_cast<double>(glm::length(irradiance[i]));
        }
        std::printf("  E of the device is off by %.1e\n", off / sum);
        std::printf("  bits of E: %s\n",
                    content_hash(irradiance.data(), irradiance.size() * sizeof(glm::vec3)).c_str());
        std::fflush(stdout);
    }

    scene::FrameScene& frame_;
    gpu::Device device_;
    rays::RayScene rays_;
    light::CausticMapper mapper_;
    std::unique_ptr<methods::SplatRenderer> host_, rasteriser_;
    media::Media media_;
    test::BareEmbree bare_rays_;
    BareRaster bare_raster_;
    std::vector<view::ReceiverLayer> layers_;
    std::vector<methods::LayerResult> results_, rastered_;
    light::Landings landings_;
    std::vector<RTCRay8> landing_, to_light_;
    std::size_t photons_ = 0, splats_ = 0;
};

}  // namespace

int main(int count, char** arguments) {
    const int repetitions = count > 1 ? std::max(1, std::atoi(arguments[1])) : 5;
    const std::map<std::string, scene::PhotonFootprint> kinds = {
        {"tent", scene::PhotonFootprint::tent},
        {"fixed", scene::PhotonFootprint::fixed},
        {"photon_differential", scene::PhotonFootprint::photon_differential},
        {"photon_difference", scene::PhotonFootprint::photon_difference},
        {"point", scene::PhotonFootprint::point}};
    std::vector<std::string> footprints;
    std::vector<int> sides;
    for (int i = 2; i < count; ++i) {
        if (kinds.contains(arguments[i]))
            footprints.emplace_back(arguments[i]);
        else
            sides.push_back(std::max(1, std::atoi(arguments[i])));
    }
    if (footprints.empty()) footprints = {"tent"};
    if (sides.empty()) sides = {512, 1024, 2048};
    scene::FrameScene frame = test::pool_scene(kWidth, kHeight, kCells, 0.53);
    std::erase_if(frame.state.objects,
                  [](const scene::Object& o) { return o.shape == scene::Shape::sphere; });
    frame.object_meshes.resize(frame.state.objects.size());
    Bench bench(frame);
    for (const std::string& footprint : footprints) {
        frame.state.caustics.photon_splatting.footprint = kinds.at(footprint);
        for (const int side : sides) {
            std::printf("%s, ", footprint.c_str());
            bench.run(side, repetitions);
        }
    }
}
