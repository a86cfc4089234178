#include "render/settle.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "base/error.h"
#include "ocean/lamp_mesh.h"
#include "ocean/water_surface.h"
#include "render/error_estimate.h"
#include "render/pilot_frame.h"
#include "render/pixel_error.h"
#include "scene/area_light.h"

namespace dapple::render {
namespace {

using scene::PhotonFootprint;

/// Settings beside the map's size.
struct Variant {
    PhotonFootprint footprint = PhotonFootprint::tent;
    int passes = 1;
};

/// What is tried: footprints that follow the water, the one with fewer pixels to draw last, and passes of a
/// filter.
std::vector<Variant> variants_of(const SettleRequest& request) {
    const scene::Caustics& caustics = request.pilots.front().caustics;
    std::vector<PhotonFootprint> footprints{caustics.photon_splatting.footprint};
    if (request.choose_footprint) footprints = {PhotonFootprint::tent, PhotonFootprint::photon_difference};
    std::vector<int> passes{caustics.denoise.passes};
    if (request.choose_passes) passes = {1, 2, 4};
    std::vector<Variant> variants;
    for (const PhotonFootprint footprint : footprints)
        for (const int count : passes) variants.push_back({footprint, count});
    return variants;
}

/// What one pilot told.
struct PilotCurves {
    std::vector<ErrorCurve> curves;  ///< of each variant, without the mesh's part; empty: no light is traced
    std::vector<double> least;       ///< maps of them that were looked at and do; 0: the curve alone tells
    double by_mesh = 0, by_pixels = 0;
    double room = 0;  ///< what map and filter may make
    int finest = 0;   ///< map tried
    std::uint64_t memory = 0;
};

/// Share that the map may have of what no map changes, where that alone misses the target: more photons would
/// buy next to nothing.
constexpr double kBesideFloor = 0.5;
/// Of what the filter and the map may make together, the map's own at the finest map tried: what is left is
/// the filter's.
constexpr double kBesideFilter = 0.5;
/// Maps are chosen in steps of so many photons a side.
constexpr int kMapStep = 8;
/// Order at which the error of the water's mesh falls with its cells (2: each triangle's light is a linear
/// function of its vertices'), and so the error of a mesh over what half as many cells each way change.
constexpr double kMeshShare = 1.0 / 3;

int whole_map(double map) {
    return kMapStep * static_cast<int>(std::ceil(map / kMapStep));
}

bool filtered(const scene::Caustics& caustics) {
    return caustics.denoise.filter != scene::DenoiseFilter::none ||
           caustics.buffer_scale != scene::BufferScale::full;
}

/// E as the method finds it at that resolution, before any filter.
scene::Caustics unfiltered(scene::Caustics caustics, int resolution, PhotonFootprint footprint) {
    caustics.map.map_resolution = resolution;
    caustics.photon_splatting.footprint = footprint;
    caustics.denoise.filter = scene::DenoiseFilter::none;
    caustics.buffer_scale = scene::BufferScale::full;
    return caustics;
}

/// The same frame on water of half as many cells each way; nothing where its mesh is not of cells, or flat
/// water's.
std::optional<scene::FrameState> on_coarse_water(scene::FrameState state) {
    if (!state.water || state.water->surface.type == scene::WaterSurfaceType::mesh_sequence ||
        ocean::is_flat(state.water->surface))
        return std::nullopt;
    if (ocean::has_rings(*state.water)) {
        state.water->rings.cells = std::max(4, state.water->rings.cells / 2);
    } else {
        const scene::FrameState meshed = ocean::with_mesh_for_lamps(scene::with_emitter_parts(state));
        state.water->mesh_cells = std::max(1, ocean::grid_size(*meshed.water).cells_x / 2);
    }
    return state;
}

scene::FrameState with_one_sample(scene::FrameState state) {
    state.clip.samples = 1;
    return state;
}

/// The climb of one pilot from coarse maps to fine ones.
class Climb {
public:
    Climb(const SettleRequest& request, const scene::FrameState& state, const std::vector<Variant>& variants,
          FrameSceneBuilder& builder, methods::CausticMethod& method, gpu::Device& device)
        : request_(request),
          samples_(state.clip.samples),
          state_(with_one_sample(state)),
          target_(state.caustics.target_error),
          variants_(variants),
          builder_(builder),
          method_(method),
          device_(device),
          frame_(checked(kCoarsestMap), builder, method, device, stats_) {
        for (const Variant& variant : variants)
            if (ladders_.empty() || ladders_.back().footprint != variant.footprint)
                ladders_.push_back({variant.footprint, {}, {}});
    }

    PilotCurves run() {
        if (!frame_.lit()) return {};
        for (int map = kCoarsestMap; map <= kFinestMap && fits(map); map *= 2) {
            add_rung(map);
            if (maps_.size() < 3 || best().error() > room()) continue;
            find_floor();
            if (best().error() <= room() * (filtered(state_.caustics) ? kBesideFilter : 1)) break;
        }
        if (maps_.size() < 3)
            throw Error(ExitCode::out_of_memory_budget,
                        "caustics.target_error: three maps from " + std::to_string(kCoarsestMap) +
                            " photons a side on tell an error, and they do not fit; take fewer cascades");
        find_floor();
        std::vector<ErrorCurve> found = curves();
        return {std::move(found), least_, by_mesh_, by_pixels_, room(), maps_.back(), memory_};
    }

private:
    /// What is known of a footprint: the last three E, and what trios of maps told.
    struct Ladder {
        PhotonFootprint footprint;
        std::vector<PixelIrradiance> last;
        std::vector<Convergence> trios;
        double error() const {
            const Convergence& finest = trios.back();
            return finest.error * finest.ratio * finest.ratio;
        }
    };

    /// What the target leaves beside what no map changes.
    double room() const {
        const double floor = std::hypot(by_mesh_, by_pixels_);
        return std::max(std::sqrt(std::max(0.0, target_ * target_ - floor * floor)), kBesideFloor * floor);
    }

    /// The pilot with that map, which is not begun where it takes too much memory.
    scene::FrameState checked(int map) {
        if (request_.stop()) throw Error(ExitCode::interrupted, "interrupted while settings were chosen");
        scene::FrameState state = state_;
        state.caustics.map.map_resolution = map;
        check_memory(state);
        return state;
    }

    void check_memory(const scene::FrameState& state) {
        const std::uint64_t needed = request_.memory(state);
        if (needed > request_.most_memory)
            throw Error(ExitCode::out_of_memory_budget,
                        "caustics.target_error: a map_resolution of " +
                            std::to_string(state.caustics.map.map_resolution) + " has to be tried in frame " +
                            std::to_string(state.frame) +
                            ", which takes more memory than --max-memory leaves: ask for a larger error, or "
                            "allow more");
        memory_ = std::max(memory_, needed);
    }

    bool fits(int map) {
        scene::FrameState state = state_;
        state.caustics.map.map_resolution = map;
        const std::size_t pixels =
            static_cast<std::size_t>(state.clip.width) * static_cast<std::size_t>(state.clip.height);
        if (method_.bytes(scene::with_emitter_parts(state), pixels) > kMostMapMemory) return false;
        checked(map);
        return true;
    }

    void add_rung(int map) {
        maps_.push_back(map);
        for (Ladder& ladder : ladders_) {
            std::vector<PixelIrradiance>& last = ladder.last;
            if (last.size() == 3) last.erase(last.begin());
            last.push_back(frame_.irradiance(unfiltered(state_.caustics, map, ladder.footprint)));
            if (last.size() < 3) continue;
            ladder.trios.push_back(convergence(relative_difference(last[0], last[1]),
                                               relative_difference(last[1], last[2]),
                                               relative_difference(last[0], last[2])));
        }
    }

    const Ladder& best() const {
        return *std::min_element(ladders_.begin(), ladders_.end(),
                                 [](const Ladder& a, const Ladder& b) { return a.error() < b.error(); });
    }

    /// What no map changes, by the finest one so far.
    void find_floor() {
        if (floor_known_) return;
        floor_known_ = true;
        const Ladder& ladder = best();
        const scene::Caustics finest = unfiltered(state_.caustics, maps_.back(), ladder.footprint);
        if (const std::optional<scene::FrameState> coarse = on_coarse_water(state_)) {
            PilotFrame frame(*coarse, builder_, method_, device_, stats_);
            by_mesh_ = kMeshShare * relative_difference(frame.irradiance(finest), ladder.last.back());
        }
        scene::FrameState state = state_;
        state.caustics = finest;
        by_pixels_ = pixel_error(state, samples_, {ladder.last.back(), frame_.surfaces()},
                                 [&](const scene::FrameState& other) {
                                     check_memory(other);
                                     PilotFrame frame(other, builder_, method_, device_, stats_);
                                     return PixelPicture{frame.irradiance(finest), frame.surfaces()};
                                 });
    }

    std::vector<ErrorCurve> curves() {
        std::vector<ErrorCurve> curves;
        for (const Variant& variant : variants_) curves.push_back(curve_of(variant));
        // What is cheapest by laws alone is looked at, until what was looked at is cheapest.
        least_.assign(curves.size(), 0);
        const auto cost = [&](std::size_t v) {
            return least_[v] > 0 ? least_[v] : curves[v].resolution_for(room());
        };
        for (;;) {
            std::size_t cheapest = 0;
            for (std::size_t v = 1; v < curves.size(); ++v)
                if (cost(v) < cost(cheapest)) cheapest = v;
            if (least_[cheapest] > 0) break;
            least_[cheapest] = verified(variants_[cheapest], curves[cheapest]);
        }
        return curves;
    }

    /// Photons may lie among waves so that maps between the rungs do worse than both: what is chosen is
    /// looked at, and what is next to it where that does not do. The law is held to what the triangle's
    /// inequality leaves of it.
    double verified(const Variant& variant, ErrorCurve& curve) {
        constexpr double kNext = 1.19;  // four to a doubling
        double map = curve.resolution_for(room());
        for (; map < maps_.back(); map *= kNext) {
            const int tried = whole_map(map);
            if (std::find(maps_.begin(), maps_.end(), tried) != maps_.end()) return tried;
            const Ladder& truth = best();
            const double apart =
                relative_difference(frame_.irradiance(settings_of(variant, tried)), truth.last.back());
            const double told =
                std::clamp(curve.at(tried), std::max(0.0, apart - truth.error()), apart + truth.error());
            curve.add(tried, told);
            if (told <= room()) return tried;
        }
        return map;
    }

    scene::Caustics settings_of(const Variant& variant, int map) const {
        if (!filtered(state_.caustics)) return unfiltered(state_.caustics, map, variant.footprint);
        scene::Caustics settings = state_.caustics;
        settings.map.map_resolution = map;
        settings.photon_splatting.footprint = variant.footprint;
        settings.denoise.passes = variant.passes;
        return settings;
    }

    ErrorCurve curve_of(const Variant& variant) {
        if (filtered(state_.caustics)) return held_against_finest(variant);
        return told_by_trios(*std::find_if(ladders_.begin(), ladders_.end(), [&](const Ladder& ladder) {
            return ladder.footprint == variant.footprint;
        }));
    }

    ErrorCurve told_by_trios(const Ladder& ladder) const {
        ErrorCurve curve;
        const std::size_t trios = ladder.trios.size();
        for (std::size_t k = 0; k < trios; ++k) curve.add(maps_[k], ladder.trios[k].error);
        const Convergence& finest = ladder.trios.back();
        curve.add(maps_[trios], finest.error * finest.ratio);
        curve.add(maps_[trios + 1], ladder.error());
        return curve;
    }

    /// Filters blur, and that does not fall as the photons' error does: each map, filtered, is held against
    /// the finest one that is not.
    ErrorCurve held_against_finest(const Variant& variant) {
        ErrorCurve curve;
        const Ladder& truth = best();
        for (const int map : maps_) {
            const double apart =
                relative_difference(frame_.irradiance(settings_of(variant, map)), truth.last.back());
            curve.add(map, std::hypot(apart, truth.error()));
        }
        return curve;
    }

    const SettleRequest& request_;
    const int samples_;
    const scene::FrameState state_;  ///< of one camera path a pixel
    const double target_;
    const std::vector<Variant>& variants_;
    FrameSceneBuilder& builder_;
    methods::CausticMethod& method_;
    gpu::Device& device_;
    std::uint64_t memory_ = 0;
    FrameStats stats_;
    PilotFrame frame_;
    std::vector<int> maps_;
    std::vector<Ladder> ladders_;  ///< of each footprint
    std::vector<double> least_;    ///< of each variant, as PilotCurves'
    bool floor_known_ = false;
    double by_mesh_ = 0, by_pixels_ = 0;
};

/// The least map that is within all pilots' room, as far as maps were tried.
int map_for(const std::vector<PilotCurves>& pilots, std::size_t variant) {
    double map = kCoarsestMap;
    int finest = kCoarsestMap;
    for (const PilotCurves& pilot : pilots) {
        if (pilot.curves.empty()) continue;
        const double least = pilot.least[variant];
        map = std::max(map, least > 0 ? least : pilot.curves[variant].resolution_for(pilot.room));
        finest = std::max(finest, pilot.finest);
    }
    if (!(map < finest)) return finest;
    return whole_map(map);
}

}  // namespace

SettledCaustics settle(const SettleRequest& request, FrameSceneBuilder& builder,
                       methods::CausticMethod& method, gpu::Device& device) {
    const std::vector<Variant> variants = variants_of(request);
    std::vector<PilotCurves> pilots;
    for (const scene::FrameState& state : request.pilots)
        pilots.push_back(Climb(request, state, variants, builder, method, device).run());
    const scene::Caustics& given = request.pilots.front().caustics;
    SettledCaustics settled;
    settled.target = given.target_error;
    double least = HUGE_VAL;
    for (std::size_t v = 0; v < variants.size(); ++v) {
        SettledCaustics found = settled;
        found.map_resolution = map_for(pilots, v);
        found.footprint = variants[v].footprint;
        found.denoise_passes = variants[v].passes;
        found.pilots.clear();
        for (std::size_t p = 0; p < pilots.size(); ++p) {
            const double by_map = pilots[p].curves.empty() ? 0 : pilots[p].curves[v].at(found.map_resolution);
            found.pilots.push_back({request.pilots[p].frame,
                                    std::hypot(by_map, pilots[p].by_mesh, pilots[p].by_pixels),
                                    pilots[p].by_mesh, pilots[p].by_pixels});
        }
        if (v > 0 && found.map_resolution > settled.map_resolution) continue;
        if (v > 0 && found.map_resolution == settled.map_resolution && !(found.error() < least)) continue;
        least = found.error();
        settled = found;
    }
    for (const PilotCurves& pilot : pilots) {
        settled.finest_tried = std::max(settled.finest_tried, pilot.finest);
        settled.most_memory = std::max(settled.most_memory, pilot.memory);
    }
    // Where no pilot shows caustics, nothing is known.
    if (settled.finest_tried == 0) settled.map_resolution = scene::CausticMapParameters().map_resolution;
    return settled;
}

}  // namespace dapple::render
