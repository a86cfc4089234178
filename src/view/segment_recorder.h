#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "media/media.h"
#include "view/segment_layer.h"

namespace dapple::view {

/// Share of the light beyond which a segment is cut: the last bit of a float.
constexpr double kLeastTransmittance = 0x1p-24;

/// A straight piece of a camera path, between two specular events or the path's ends.
struct PathPiece {
    std::size_t pixel = 0;
    glm::dvec3 origin{0};     ///< m, relative to FrameScene::origin; the end nearer to the camera
    glm::dvec3 direction{0};  ///< unit, away from the camera
    double length = 0;        ///< m; infinite where the path leaves the scene
    bool in_water = false;
    bool primary = true;       ///< no specular event before `origin`
    glm::dvec3 throughput{0};  ///< from the pixel to `origin`
    glm::dvec3 origin_du{0}, origin_dv{0}, direction_du{0}, direction_dv{0};  ///< by pixel x and y
};

/// Keeps the pieces of paths that lie in media that scatter. Tiles record apart from each other, in any
/// order, on any thread.
class SegmentRecorder {
public:
    SegmentRecorder(const media::Media& media, std::size_t tiles);

    /// Pieces of one pixel come from one tile, in the order of the path.
    void record(std::size_t tile, const PathPiece& piece);
    /// Fills all but `sample` and `branch`; ordered by pixel.
    void write(int width, int height, SegmentLayer& layer) const;
    /// Bytes of a piece that is kept.
    static constexpr std::size_t bytes_a_piece() { return sizeof(Kept); }

    /// m: beyond it no light that a piece's near end could show is scattered. Water that scatters ends where
    /// it lets through kLeastTransmittance of the least extinct channel that it scatters in; other media end
    /// with their boxes. 0 where nothing scatters on the piece.
    double farthest(const PathPiece& piece) const;

private:
    /// A piece as the layer has it.
    struct Kept {
        std::uint32_t pixel;
        float length;
        std::uint8_t in_water, primary;
        glm::vec3 origin, direction, throughput;
        glm::vec3 spread_u_origin, spread_u_direction, spread_v_origin, spread_v_direction;
    };

    const media::Media& media_;
    std::vector<std::vector<Kept>> pieces_;  ///< a tile
};

}  // namespace dapple::view
