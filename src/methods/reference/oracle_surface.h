#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "methods/reference/interval.h"
#include "scene/frame_state.h"

namespace dapple::oracle {

/// A sum of sinusoids' height [m], slopes and second derivatives [1/m] along x and z.
template <class T>
struct Jet {
    T height{}, x{}, z{}, xx{}, xz{}, zz{};
};

/// A rectangle of the horizontal plane, m.
struct Box {
    Interval x, z;
};
inline glm::dvec2 center(const Box& box) {
    return {middle(box.x), middle(box.z)};
}

/// Whether the surface stands in a ray's way.
enum class Sight : std::uint8_t { clear, blocked, undecided };

/// The surface of a list of waves at one time: h = sum a cos(k . (x, z) + phase), exactly as given by the
/// doubles a, k, omega and time.
class Surface {
public:
    /// `water.surface` is a list of waves (asserted).
    Surface(const scene::Water& water, double time);

    /// The surface about a point, which becomes its x = z = 0: phases are reduced there with 64 bits, so that
    /// far from the world's origin nothing is lost but what the input's doubles lack.
    class Local {
    public:
        Local(const Surface& surface, glm::dvec2 anchor);

        /// In plain double.
        Jet<double> at(double x, double z) const;

        /// Bounds of the jet at (x, z), about 1e-15 wide, and on the box of half-size (radius_x, radius_z)
        /// about it. Derivatives of the sum are taken at the centre, where waves cancel as they do in the
        /// sum; only the remainder of Taylor's formula is bounded wave by wave, and shrinks with the square
        /// of the box. False, and no jet at the centre, if the box is too large for that (a radian of some
        /// wave): `over` is then right, but wide.
        bool bounds(double x, double z, double radius_x, double radius_z, Jet<Interval>& at_center,
                    Jet<Interval>& over) const;

        /// Whether the surface leaves free the ray start + t direction, 0 < t < length, which starts on the
        /// surface; `above`: the ray is to run above the surface, else below. Positions relative to the
        /// anchor in x and z, direction unit.
        Sight sight(glm::dvec3 start, glm::dvec3 direction, double length, bool above) const;

    private:
        const Surface* surface_;
        std::vector<double> phases_;  ///< rad, in [-pi, pi], a wave
        double phase_error_ = 0;      ///< rad, bound
    };

    double height_bound() const { return sum_.height; }  ///< m, sum of the amplitudes

private:
    struct Wave {
        double k_x, k_z;      ///< rad/m
        double abs_x, abs_z;  ///< their magnitudes
        double amplitude;     ///< m
        double magnitude;     ///< m, of the amplitude
        long double phase;    ///< rad, at the world's origin and the time
    };
    std::vector<Wave> waves_;
    Jet<double> sum_;       ///< bounds of the jet: sums of amplitudes times powers of the wave numbers
    double largest_k_ = 0;  ///< rad/m, of |k_x| + |k_z|
};

}  // namespace dapple::oracle
