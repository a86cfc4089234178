#pragma once
#include <vector>

#include "scene/medium.h"

namespace dapple::reference {

/// Phase functions of the reference, written apart from shaders/optics on purpose (own_optics.h says why).
class OwnPhase {
public:
    explicit OwnPhase(const scene::PhaseFunction& phase);

    /// p, /sr, of the cosine between the directions of travel before and after; its integral over the sphere
    /// is 1.
    double operator()(double cosine) const;

private:
    /// Fournier & Forand, Proc. SPIE 2258, 194 (1994), in the form of Fournier & Jonasz, Proc. SPIE 3761, 62
    /// (1999).
    double fournier_forand(double cosine) const;
    double table(double angle) const;

    scene::PhaseFunction phase_;
    double table_norm_ = 1;  ///< 1 / integral of the table over the sphere
};

}  // namespace dapple::reference
