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
        std::uint32_t places;  ///< 2 of a box, whose columns are straight; 0: it is left out
    };
    std::vector<Column> columns;
    std::uint32_t entry = 0;  ///< floats
};

/// Columns of the bounded media of a frame along many lines, found on the device from dense bricks of the
/// grids' density in 3-D textures. Columns up to the places of a table are off by what Gauss's rule of two
/// nodes on steps of a voxel leaves (and a device whose filters round weights to 8 bits), a few thousandths
/// of a grid's column; between places they are linear.
class MediaColumns {
public:
    /// Places of a grid on a line.
    static constexpr std::uint32_t kPlaces = 64;
    /// Floats of a medium with so many places on a line.
    static constexpr std::uint32_t entry(std::uint32_t places) { return 2 + places; }

    explicit MediaColumns(gpu::Device& device);
    ~MediaColumns();
    /// A frame's media, which must outlive their use. Uploads bricks.
    void begin(const scene::FrameScene& scene, const media::Media& media, FrameStats& stats);
    /// Of the media on one side, with so many places for grids, and with boxes or without.
    ColumnTable table(bool in_water, std::uint32_t places = kPlaces, bool boxes = true) const;
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
