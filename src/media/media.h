#pragma once
#include <cstddef>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "media/body.h"
#include "scene/frame_scene.h"

namespace dapple::media {

/// Light from beyond so many optical depths, e^-60 of it, is left out.
constexpr double kOpaque = 60;

/// Densities of all components along a straight segment. Between two places density is smooth (a polynomial
/// of degree three at most), so that the integral between them is exact by Simpson's rule, and its Hermite
/// interpolation from the values and their slopes is good to fourth order.
struct DensityProfile {
    /// Density on a piece of unit length by its values at the ends and in the middle.
    struct Parabola {
        double begin = 0, middle = 0, end = 0;
        double at(double t) const {
            return begin + t * (4 * middle - 3 * begin - end + t * 2 * (begin + end - 2 * middle));
        }
        /// Integral from 0.
        double column(double t) const {
            return t * (begin + t * (0.5 * (4 * middle - 3 * begin - end) +
                                     t * 2.0 / 3 * (begin + end - 2 * middle)));
        }
    };

    std::size_t components = 0;
    std::vector<double> place;   ///< m along the segment, ascending; the first 0, the last its length
    std::vector<float> density;  ///< [place * components + component], just after the place where it jumps
    std::vector<double> column;  ///< the same: integral of the density from 0 to the place, m
    std::vector<float> middle;   ///< the same: density half way from this place to the next

    /// Between a place and the next, which must not be the same: where the density is a cubic, the parabola
    /// of the same integral.
    Parabola parabola(std::size_t piece, std::size_t component) const;
    /// Integral of the density from 0 to `s`, m, which lies between a place and the next.
    double column_to(std::size_t piece, std::size_t component, double s) const;
};

/// What a ray meets of one medium.
struct Component {
    glm::dvec3 extinction{0};  ///< /m where density is 1
    glm::dvec3 scattering{0};  ///< /m where density is 1
    const scene::PhaseFunction* phase = nullptr;
};

/// A bounded medium that is not empty.
struct Part {
    std::size_t component;  ///< into Media::components()
    bool in_air, in_water;  ///< the sides that it may lie on
    Body body;
    bool on(bool water) const { return water ? in_water : in_air; }
};

/// The media of a frame. Component 0 is the water itself (density 1 in the water, 0 in the air; also where
/// the scene has no water), then FrameState::media in their order. Positions are m relative to
/// FrameScene::origin, directions unit. Which side of the water a segment is on is the caller's to say: a
/// segment does not cross the surface. Thread-safe; the scene must outlive it.
class Media {
public:
    explicit Media(const scene::FrameScene& scene);
    ~Media();

    const std::vector<Component>& components() const;
    const std::vector<Part>& parts() const;  ///< in the order of their components
    /// Whether a bounded medium that is not empty may lie on that side of the water.
    bool bounded(bool in_water) const;
    /// Whether anything on that side scatters light.
    bool scatters(bool in_water) const;
    /// Whether the box of a bounded medium meets the segment.
    bool may_meet(const glm::dvec3& origin, const glm::dvec3& direction, double length, bool in_water) const;

    /// Optical depth of a segment a channel. `length` may be infinite where no component is.
    glm::dvec3 optical_depth(const glm::dvec3& origin, const glm::dvec3& direction, double length,
                             bool in_water) const;
    /// Density of one component at a point on that side.
    double density(std::size_t component, const glm::dvec3& position, bool in_water) const;
    /// Density of all along a segment of finite length.
    DensityProfile profile(const glm::dvec3& origin, const glm::dvec3& direction, double length,
                           bool in_water) const;
    /// p(cos) of a component, /sr: `cosine` between the ways before and after scattering.
    double phase(std::size_t component, double cosine) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace dapple::media
