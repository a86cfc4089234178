#pragma once
#include <vector>

#include "scene/medium.h"

namespace dapple::media {

/// A phase function ready for many calls.
class Phase {
public:
    explicit Phase(const scene::PhaseFunction& function);
    /// p [1/sr]; `cosine` may be beyond -1 and 1 by its rounding.
    double at(double cosine) const;

private:
    scene::PhaseFunction function_;  ///< a table's values are normalised
};

}  // namespace dapple::media
