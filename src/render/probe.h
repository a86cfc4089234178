#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

#include "methods/sliced_beams/point_paths.h"
#include "scene/frame_state.h"

namespace dapple::render {

/// What the oracle (methods/reference/oracle.h) knows of one chain at a point.
struct OracleCount {
    std::string chain;        ///< "sun > water:T", "panel, point 3 of 16 > water:T"
    int paths = 0;            ///< with light of the lamp, that waves leave alone, as those on the mesh
    int sign_sum = 0;         ///< of these
    int behind_waves = 0;     ///< others, that waves block between light and facet or facet and point
    bool proven = false;      ///< there are no more, of either kind
    std::string unavailable;  ///< why it cannot say anything; the numbers mean nothing then
};

/// The point that a camera path ended on, and the light that comes to it.
struct ProbedReceiver {
    std::string object;            ///< as object_name
    glm::dvec3 position{0, 0, 0};  ///< m, world
    glm::dvec3 normal{0, 1, 0};    ///< unit, geometric, towards the side that is seen
    bool in_water = false;
    bool in_glass = false;         ///< in a body of glass, whose light is not listed
    bool behind_specular = false;  ///< seen through or by water, glass or mirrors
    double distance = 0;           ///< m, from the camera's place on a straight line
    methods::sliced_beams::PointPaths paths;
    /// Sum over the paths that nothing blocks, W/m^2 a channel. At the point: a pixel's E is a mean.
    glm::dvec3 irradiance{0, 0, 0};
    std::vector<OracleCount> oracle;  ///< a chain; only of water that is a list of waves
};

/// The end of one camera path of a pixel.
struct ProbedView {
    enum class Sees { receiver, sky, nothing };
    int branch = 0;  ///< view::LayerRequest
    Sees sees = Sees::nothing;
    glm::dvec3 throughput{0, 0, 0};  ///< share of the end's radiance that the pixel gets
    std::optional<ProbedReceiver> receiver;
};

/// The name of an object, or "objects[2]" where it has none.
std::string object_name(const scene::FrameState& state, std::uint32_t object);

/// Follows the camera paths of a point of the picture (pixel coordinates: the first pixel's centre is at 0.5)
/// and lists the light paths to their ends, on the water mesh; none that met glass. A view a branch that the
/// path has, in their order. Casts no light and needs no device. Errors: Error(input_unreadable).
std::vector<ProbedView> probe(const scene::FrameState& state, glm::dvec2 place);

}  // namespace dapple::render
