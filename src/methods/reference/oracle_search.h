#pragma once
#include <cstddef>
#include <vector>

#include "methods/reference/oracle_map.h"
#include "methods/reference/oracle_surface.h"

namespace dapple::oracle {

/// A solution of X(u, v) = receiver, positions relative to the receiver.
struct Root {
    Box enclosure;  ///< holds it, tightly
    Box alone_in;   ///< holds it and no other
    int sign = 1;   ///< of det dX/d(u, v)
};

struct RootSearch {
    std::vector<Root> roots;
    std::vector<Box> undecided;  ///< each solution in `domain` is in a root's enclosure or in one of these
    std::size_t boxes = 0;       ///< examined
};

/// All rays of the light that enter the water in `domain`, on facets that face it, and land on the receiver
/// (x = z = 0 at height map.plane).
RootSearch find_roots(const Surface::Local& surface, const MapConstants& map, const Box& domain);

}  // namespace dapple::oracle
