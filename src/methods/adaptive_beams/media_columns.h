#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <vector>

#include "gpu/device.h"
#include "gpu/pass_list.h"
#include "layout/beam_media.h"
#include "media/media.h"
#include "scene/frame_scene.h"

namespace dapple::methods::adaptive_beams {

/// How a table of columns along lines on one side of the water is laid out.
struct ColumnTable {
    struct Column {
        std::size_t part;      ///< index into media::Media::parts()
        std::uint32_t first;   ///< float of the entry
        std::uint32_t places;  ///< of a line at most; 2 of a box, whose columns are straight; 0: left out
    };
    std::vector<Column> columns;
    std::uint32_t entry = 0;  ///< floats
};

/// Columns of the bounded media of a frame along many lines, found on the device from dense bricks of the
/// grids' density in 3-D textures. Columns up to the places of a table are off by what Gauss's rule of two
/// nodes on steps of a voxel leaves (and a device whose filters round weights to 8 bits), a few thousandths
/// of a grid's column; between places they are linear. Places are even along a line from where it enters a
/// grid to where it leaves it, at least one a voxel: what is thin is resolved however much of the grid lies
/// about it.
class MediaColumns {
public:
    /// Places of a grid on a line: more where it crosses more voxels than that, up to the most.
    static constexpr std::uint32_t kLeastPlaces = 64;
    static constexpr std::uint32_t kMostPlaces = 1024;
    /// That a line across so many voxels needs.
    static std::uint32_t places(double voxels);
    /// Floats of a medium with so many places on a line.
    static constexpr std::uint32_t entry(std::uint32_t places) { return 3 + places; }

    explicit MediaColumns(gpu::Device& device);
    ~MediaColumns();
    /// A frame's media, which must outlive their use. Uploads bricks.
    void begin(const scene::FrameScene& scene, const media::Media& media, FrameStats& stats);
    /// Voxels of a part that a segment crosses; 0 of a box. `direction` is unit.
    double voxels(std::size_t part, const glm::dvec3& origin, const glm::dvec3& direction,
                  double length) const;
    /// Of the media on one side, for lines that cross at most so many voxels of each part; with at most so
    /// many places for grids, and with boxes or without.
    ColumnTable table(bool in_water, std::span<const double> voxels, std::uint32_t most = kMostPlaces,
                      bool boxes = true) const;
    /// Appends the passes that write entries of `entry` floats (at least the table's), one a line, to
    /// `columns`; lines on the other side are left out.
    void add(gpu::PassList& passes, const ColumnTable& table, bool in_water, const gpu::Buffer& lines,
             std::size_t count, const gpu::Buffer& columns, std::uint32_t entry) const;
    /// m of the world: how wide a voxel of a part is, about; of a box infinite.
    float step(std::size_t part) const;
    bool is_box(std::size_t part) const;
    /// Greatest density of a part.
    float thickest(std::size_t part) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace dapple::methods::adaptive_beams
