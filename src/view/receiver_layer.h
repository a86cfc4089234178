#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace dapple::view {

/// What a camera path ended on, and how.
enum ReceiverFlags : std::uint32_t {
    kReceiver = 1u << 0,         ///< a diffuse surface was hit; else the fields of the receiver mean nothing
    kEnvironment = 1u << 1,      ///< the path left the scene through the air: it sees the sky
    kInWater = 1u << 2,          ///< the receiver is lit and seen through the water (it lies in it)
    kBehindSpecular = 1u << 3,   ///< the camera sees it through or by a specular surface
    kFootprintCapped = 1u << 4,  ///< grazing view: the footprint was cut to a longest length
    kInGlass = 1u << 5,          ///< the receiver lies in a body of glass (and neither in water nor in air)
};

/// Where a camera path splits.
enum PathSplits : std::uint8_t {
    kSplits = 1u << 0,       ///< branch 1 has a path too
    kSplitsAgain = 1u << 1,  ///< branch + 2 has a path too; of branches 0 and 1
};

/// One camera path a pixel, at one sub-pixel offset (`sample`) and one choice at its Fresnel splits
/// (`branch`): always an image, row-major from the top left, width * height entries an array. Positions are
/// m, relative to FrameScene::origin.
struct ReceiverLayer {
    int width = 0;
    int height = 0;
    int sample = 0;
    int branch = 0;
    std::vector<std::uint32_t> flags;      ///< ReceiverFlags
    std::vector<std::uint8_t> splits;      ///< PathSplits: which other branches the pixel has
    std::vector<std::uint32_t> object;     ///< index into FrameState::objects
    std::vector<std::uint32_t> primitive;  ///< as rays::Hit
    std::vector<glm::vec3> position;
    std::vector<glm::vec3>
        footprint_u;  ///< d(position)/d(pixel x) on the tangent plane, through the whole chain
    std::vector<glm::vec3> footprint_v;       ///< the same for a pixel down
    std::vector<glm::vec3> geometric_normal;  ///< unit, towards the side that the path arrives from
    std::vector<glm::vec3> shading_normal;    ///< unit, same side
    std::vector<glm::vec3>
        throughput;             ///< of the path from the pixel to its end: Fresnel, mirrors, extinction, n^2
    std::vector<glm::vec2> uv;  ///< of the object's texture
    std::vector<float> uv_width;  ///< extent of the footprint in uv
    std::vector<float> depth;     ///< m along the camera's axis to the first surface hit; infinite: none
    std::size_t pixels() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
};

}  // namespace dapple::view
