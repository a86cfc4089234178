#pragma once
#include <cstddef>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "denoise/adaptive_kernel.h"
#include "denoise/guide.h"

namespace dapple::denoise {

/// A kernel as exchange() uses it: every pixel within the radius counts, by equation 23 with the distance
/// scale in pixels in place of centimetres, so that pictures of any scale are filtered alike.
struct Reach {
    explicit Reach(const Kernel& k);
    Kernel kernel;
    std::vector<float> weights;  ///< at 1, 2, ... pixels, up to the radius
    float at(std::size_t pixels) const { return pixels <= weights.size() ? weights[pixels - 1] : 0; }
};

/// A pixel of a row or column on its way through a filter.
struct LinePixel {
    Guide guide;
    float area = 0;                ///< m^2, of the footprint
    float depth = 0;               ///< m along the camera's axis
    const Reach* reach = nullptr;  ///< not null where there is a surface
    glm::vec3 irradiance{0};       ///< W/m^2
};

/// What exchange() and gather() need beside the line; kept between lines to spare allocations.
struct LineScratch {
    std::vector<float> weights, sums;
    std::vector<glm::vec3> received;
};

/// The default filter along a line: pixels exchange light with their neighbours,
///     E'(p) = E(p) + 1/A(p) sum over q of g(p, q) (E(q) - E(p)),
///     g(p, q) = w(p, q) min(A(p) / W(p), A(q) / W(q)),   W(p) = 1 + sum over q of w(p, q),
/// A being footprints' areas and w = max(reach of p, reach of q) edge_stop(p, q). w and so g are symmetric:
/// what q gives p receives, and the sum of A E stays whatever the radii are; equal E stays to the bit; and as
/// the sum of g(p, q) is less than A(p), E' is a mean of E's with weights that are not negative. Where A and
/// W are even this is the cross-bilateral mean itself. (It is Metropolis and Hastings' rule: proposals w / W
/// with A as the stationary distribution.)
void exchange(std::span<LinePixel> line, std::size_t largest_radius, LineScratch& scratch);

/// The paper's filter along a line: equations 21 to 24 and algorithm 4, with its own unit of length, 1 cm.
/// The radius is that of the pixel that gathers, so the sum of light changes.
void gather(std::span<LinePixel> line, LineScratch& scratch);

}  // namespace dapple::denoise
