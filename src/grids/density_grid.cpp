#include "grids/density_grid.h"

#include <vector>

namespace dapple::grids {

struct DensityGrid::Reader::State {};
DensityGrid::Reader::Reader(const DensityGrid&) : state_(std::make_unique<State>()) {}
DensityGrid::Reader::~Reader() = default;

}  // namespace dapple::grids
