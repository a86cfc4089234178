#include "methods/reference/light_pass.h"

#include <algorithm>
#include <array>

#include "base/parallel.h"

namespace dapple::reference {
namespace {

constexpr std::size_t kTile = 2048;       ///< strata
constexpr std::size_t kTilesAtOnce = 64;  ///< whose deposits are kept until they are added
/// Ranges of pixels, to which the threads add side by side.
constexpr std::size_t kRanges = 16;

struct Deposit {
    std::uint32_t pixel;
    glm::dvec3 irradiance;
};

/// Of one tile and layer.
using Deposits = std::array<std::vector<Deposit>, kRanges>;

void deposit(const LayerCells& layer, const Arrival& arrival, Deposits& deposits) {
    const DepositCells::Cell cell = layer.cells.find(arrival.place.key);
    if (cell.pixels.empty()) return;
    const glm::dvec3 in_cell = (cell.per_measure / arrival.place.density) * arrival.power;
    for (const std::uint32_t pixel : cell.pixels) {
        const std::size_t range = pixel * kRanges / layer.paths.size();
        deposits[range].push_back({pixel, in_cell / static_cast<double>(layer.paths[pixel])});
    }
}

}  // namespace

std::optional<PassResult> run_pass(const LightTracer& tracer, const LightPass& pass,
                                   std::span<const LayerCells* const> layers,
                                   const std::function<bool()>& stop,
                                   std::vector<std::vector<glm::dvec3>>& irradiance) {
    irradiance.resize(layers.size());
    for (std::size_t l = 0; l < layers.size(); ++l)
        irradiance[l].assign(layers[l]->paths.size(), glm::dvec3(0));
    PassResult result;
    std::vector<Deposits> tiles(kTilesAtOnce * layers.size());
    std::vector<EnergyAccount> found(kTilesAtOnce);
    for (std::size_t source = 0; source < tracer.sources(); ++source) {
        const std::size_t strata = tracer.strata(pass, source);
        result.rays += strata;
        for (std::size_t first = 0; first < strata; first += kTile * kTilesAtOnce) {
            if (stop()) return {};
            const std::size_t count = std::min(strata - first, kTile * kTilesAtOnce);
            parallel_for(count, kTile, [&](std::size_t begin, std::size_t end) {
                const Harvest harvest = tracer.trace(pass, source, first + begin, first + end);
                found[begin / kTile] = harvest.account;
                for (std::size_t l = 0; l < layers.size(); ++l) {
                    Deposits& deposits = tiles[begin / kTile * layers.size() + l];
                    for (const Arrival& arrival : harvest.arrivals) deposit(*layers[l], arrival, deposits);
                }
            });
            for (std::size_t tile = 0; tile * kTile < count; ++tile) result.account.add(found[tile]);
            parallel_for(kRanges * layers.size(), 1, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) {
                    const std::size_t l = i / kRanges;
                    for (std::size_t tile = 0; tile < kTilesAtOnce; ++tile) {
                        std::vector<Deposit>& deposits = tiles[tile * layers.size() + l][i % kRanges];
                        for (const Deposit& one : deposits) irradiance[l][one.pixel] += one.irradiance;
                        deposits.clear();
                    }
                }
            });
        }
    }
    return result;
}

}  // namespace dapple::reference
