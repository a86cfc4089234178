#include "grids/density_grid.h"

#include <nanovdb/NanoVDB.h>
#include <nanovdb/util/GridBuilder.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/error.h"
#include "grids/grid_buffer.h"

namespace dapple::grids {
namespace {

using Grid = nanovdb::NanoGrid<float>;
using Root = nanovdb::NanoRoot<float>;
using Upper = nanovdb::NanoUpper<float>;
using Lower = nanovdb::NanoLower<float>;
using Leaf = nanovdb::NanoLeaf<float>;

constexpr int kBlock = 8;  // voxels along a leaf
static_assert(Leaf::DIM == kBlock);

/// Neighbours of voxels as far out as this do not overflow.
constexpr int kFarthest = 1 << 30;

nanovdb::Coord coord(const glm::ivec3& v) {
    return {v.x, v.y, v.z};
}

glm::ivec3 vector(const nanovdb::Coord& c) {
    return {c[0], c[1], c[2]};
}

[[noreturn]] void fail(const std::string& message) {
    throw Error(ExitCode::input_unreadable, message);
}

std::string place(const glm::ivec3& v) {
    return std::to_string(v.x) + ", " + std::to_string(v.y) + ", " + std::to_string(v.z);
}

bool is_density(float value) {
    return std::isfinite(value) && value >= 0;
}

/// A transform that can be turned around.
void check_transform(const glm::dmat4& file_from_index) {
    const double volume = glm::determinant(glm::dmat3(file_from_index));
    bool finite = std::isfinite(volume);
    for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 4; ++row) finite = finite && std::isfinite(file_from_index[column][row]);
    }
    if (!finite || volume == 0) fail("the grid's transform gives its voxels no volume");
}

/// Walks a NanoVDB grid from its root, and looks at each offset before it is followed. Origins of nodes are
/// worked out on the way: those stored are not needed.
class Survey {
public:
    glm::ivec3 low{std::numeric_limits<int>::max()};
    glm::ivec3 high{std::numeric_limits<int>::min()};
    float maximum = 0;
    std::size_t active_voxels = 0;
    /// Aligned cubes of at least a block with a voxel that is active; where there are more than can be noted,
    /// some.
    struct Cube {
        glm::ivec3 low;
        int size;
    };
    std::vector<Cube> cubes;

    Survey(const std::byte* data, std::size_t size) : begin_(data), size_(size) {
        if (size < sizeof(Grid) + sizeof(Root)) fail("its voxels end too early");
        const auto* header = reinterpret_cast<const nanovdb::GridData*>(data);
        if (header->mMagic != NANOVDB_MAGIC_NUMBER || header->mGridSize != size ||
            header->mVersion.getMajor() != NANOVDB_MAJOR_VERSION_NUMBER ||
            header->mGridType != nanovdb::GridType::Float) {
            fail("its voxels are not laid out as they should be");
        }
        const auto& tree = reinterpret_cast<const Grid*>(data)->tree();
        tree_ = reinterpret_cast<const std::byte*>(&tree);
        const auto* nodes = tree.data();
        leaves_ = nodes_at<Leaf>(nodes->mNodeOffset[0], nodes->mNodeCount[0]);
        lowers_ = nodes_at<Lower>(nodes->mNodeOffset[1], nodes->mNodeCount[1]);
        uppers_ = nodes_at<Upper>(nodes->mNodeOffset[2], nodes->mNodeCount[2]);
        const auto* root = nodes_at<Root>(nodes->mNodeOffset[3], 1).data();
        const std::size_t tiles =
            static_cast<std::size_t>(begin_ + size_ - reinterpret_cast<const std::byte*>(root + 1)) /
            sizeof(Root::Tile);
        if (root->data()->mTableSize > tiles) fail("its voxels end too early");
        if (root->data()->mBackground != 0) fail("density outside of its voxels is not 0");
        visit(*root);
    }

private:
    template <typename Node>
    std::span<const Node> nodes_at(std::uint64_t offset, std::uint64_t count) const {
        if (count == 0) return {};
        const auto from_begin = static_cast<std::size_t>(tree_ - begin_);
        if (offset % alignof(Node) != 0 || offset > size_ - from_begin ||
            count > (size_ - from_begin - offset) / sizeof(Node)) {
            fail("its voxels end too early");
        }
        return {reinterpret_cast<const Node*>(tree_ + offset), static_cast<std::size_t>(count)};
    }

    /// The child `offset` bytes after its parent.
    template <typename Node, typename Parent>
    static const Node& child_of(const Parent& parent, std::int64_t offset, std::span<const Node> nodes) {
        const std::uint64_t first = reinterpret_cast<std::uintptr_t>(nodes.data());
        const std::uint64_t at =
            reinterpret_cast<std::uintptr_t>(&parent) + static_cast<std::uint64_t>(offset);
        const std::uint64_t distance = at - first;  // wraps to something large where it is before
        if (distance % sizeof(Node) != 0 || distance / sizeof(Node) >= nodes.size()) {
            fail("the tree of its voxels leads nowhere");
        }
        return nodes[static_cast<std::size_t>(distance / sizeof(Node))];
    }

    void visit(const Root& root) {
        for (std::uint32_t i = 0; i < root.data()->mTableSize; ++i) {
            const Root::Tile& tile = *root.data()->tile(i);
            const glm::ivec3 origin = vector(tile.origin());
            const glm::ivec3 far = glm::abs(origin + static_cast<int>(Upper::DIM) / 2);
            if (std::max({far.x, far.y, far.z}) > kFarthest) fail("its voxels lie too far out");
            if (tile.child != 0) {
                visit(child_of(root, tile.child, uppers_), origin);
            } else {
                add(origin, static_cast<int>(Upper::DIM), tile.state != 0, tile.value);
            }
        }
    }

    template <typename Node>
    void visit(const Node& node, const glm::ivec3& origin) {
        constexpr int child_size = static_cast<int>(Node::ChildNodeType::DIM);
        const auto& data = *node.data();
        for (std::uint32_t n = 0; n < Node::SIZE; ++n) {
            const glm::ivec3 at = origin + vector(Node::OffsetToLocalCoord(n)) * child_size;
            if (!data.mChildMask.isOn(n)) {
                add(at, child_size, data.mValueMask.isOn(n), data.mTable[n].value);
            } else if constexpr (std::is_same_v<Node, Upper>) {
                visit(child_of(node, data.mTable[n].child, lowers_), at);
            } else {
                visit(child_of(node, data.mTable[n].child, leaves_), at);
            }
        }
    }

    void visit(const Leaf& leaf, const glm::ivec3& origin) {
        if (!leaf.data()->mValueMask.isOff()) keep({origin, kBlock});
        for (std::uint32_t n = 0; n < Leaf::SIZE; ++n) {
            add(origin + vector(Leaf::OffsetToLocalCoord(n)), 1, leaf.data()->mValueMask.isOn(n),
                leaf.data()->mValues[n]);
        }
    }

    /// A damaged tree may lead to the same nodes again and again.
    void keep(const Cube& cube) {
        if (cubes.size() <= DensityGrid::kMostBlocks) cubes.push_back(cube);
    }

    /// A cube of voxels of one value.
    void add(const glm::ivec3& at, int size, bool active, float value) {
        if (!is_density(value)) fail("density is no finite, positive number at " + place(at));
        if (!active && value != 0) fail("density outside of its voxels is not 0");
        if (!active) return;
        if (size >= kBlock) keep({at, size});
        low = glm::min(low, at);
        high = glm::max(high, at + (size - 1));
        maximum = std::max(maximum, value);
        active_voxels +=
            static_cast<std::size_t>(size) * static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
    }

    const std::byte* begin_;
    std::size_t size_;
    const std::byte* tree_ = nullptr;
    std::span<const Leaf> leaves_;
    std::span<const Lower> lowers_;
    std::span<const Upper> uppers_;
};

/// None where there would be too many.
CellBlocks blocks_of(const Survey& survey, std::size_t most_blocks) {
    CellBlocks blocks;
    blocks.first = (survey.low - 1) >> 3;
    blocks.count = (survey.high >> 3) - blocks.first + 1;
    const double many = static_cast<double>(blocks.count.x) * static_cast<double>(blocks.count.y) *
                        static_cast<double>(blocks.count.z);
    if (many > static_cast<double>(most_blocks) || survey.cubes.size() > most_blocks) return blocks;
    blocks.occupied.assign(static_cast<std::size_t>(many) / 64 + 1, 0);
    for (const Survey::Cube& cube : survey.cubes) {
        // The last cells of the blocks before reach into the cube.
        const glm::ivec3 low = glm::max((cube.low >> 3) - 1, blocks.first);
        const glm::ivec3 high = (cube.low + (cube.size - 1)) >> 3;
        for (int z = low.z; z <= high.z; ++z) {
            for (int y = low.y; y <= high.y; ++y) {
                for (int x = low.x; x <= high.x; ++x) {
                    const std::size_t i = blocks.index({x, y, z});
                    blocks.occupied[i / 64] |= std::uint64_t{1} << (i % 64);
                }
            }
        }
    }
    return blocks;
}

class NanoDensityGrid final : public DensityGrid {
public:
    NanoDensityGrid(GridBuffer buffer, const glm::dmat4& file_from_index,
                    std::size_t most_blocks = kMostBlocks)
        : buffer_(std::move(buffer)) {
        check_transform(file_from_index);
        file_from_index_ = file_from_index;
        bytes_ = buffer_.size;
        if (buffer_.size == 0) return;
        const Survey survey(buffer_.data.get(), buffer_.size);
        if (survey.active_voxels == 0) return;
        low_ = survey.low;
        high_ = survey.high;
        maximum_ = survey.maximum;
        active_voxels_ = survey.active_voxels;
        blocks_ = blocks_of(survey, most_blocks);
        bytes_ += sizeof(std::uint64_t) * blocks_.occupied.size();
    }

    /// Not to be asked of an empty grid.
    const Grid& grid() const { return *reinterpret_cast<const Grid*>(buffer_.data.get()); }

private:
    GridBuffer buffer_;
};

float mix(float a, float b, float share_of_b) {
    return a + share_of_b * (b - a);
}

}  // namespace

std::shared_ptr<const DensityGrid> grid_of_buffer(GridBuffer buffer, const glm::dmat4& file_from_index) {
    return std::make_shared<NanoDensityGrid>(std::move(buffer), file_from_index);
}

std::shared_ptr<const DensityGrid> empty_grid(const glm::dmat4& file_from_index) {
    return std::make_shared<NanoDensityGrid>(GridBuffer{}, file_from_index);
}

std::shared_ptr<const DensityGrid> DensityGrid::from_values(glm::ivec3 low, glm::ivec3 size,
                                                            std::span<const float> values,
                                                            const glm::dmat4& file_from_index,
                                                            std::size_t most_blocks) {
    nanovdb::GridBuilder<float> builder;
    builder.setStats(nanovdb::StatsMode::Disable);
    builder.setChecksum(nanovdb::ChecksumMode::Disable);
    auto voxels = builder.getAccessor();
    std::size_t next = 0;
    bool empty = true;
    for (int z = 0; z < size.z; ++z) {
        for (int y = 0; y < size.y; ++y) {
            for (int x = 0; x < size.x; ++x) {
                const glm::ivec3 at = low + glm::ivec3(x, y, z);
                const float value = values[next++];
                if (!is_density(value)) fail("density is no finite, positive number at " + place(at));
                if (value == 0) continue;
                voxels.setValue(coord(at), value);
                empty = false;
            }
        }
    }
    if (empty) return empty_grid(file_from_index);
    const auto handle = std::make_shared<nanovdb::GridHandle<nanovdb::HostBuffer>>(builder.getHandle<>());
    GridBuffer buffer{{handle, reinterpret_cast<const std::byte*>(handle->data())},
                      static_cast<std::size_t>(handle->size())};
    return std::make_shared<NanoDensityGrid>(std::move(buffer), file_from_index, most_blocks);
}

/// Remembers the block it was in last. Most cells have all their corners in one block.
struct DensityGrid::Reader::State {
    const DensityGrid& density;
    nanovdb::DefaultReadAccessor<float> accessor;
    glm::dvec3 first;  ///< least and greatest index positions where density is not 0
    glm::dvec3 last;
    glm::ivec3 block{1};            ///< its least corner; this one is none
    const float* values = nullptr;  ///< of the block; null where it has one value
    float value = 0;

    explicit State(const NanoDensityGrid& grid)
        : density(grid),
          accessor(grid.grid().getAccessor()),
          first(glm::dvec3(grid.low()) - 1.0),
          last(glm::dvec3(grid.high()) + 1.0) {}

    void enter(const glm::ivec3& new_block) {
        if (new_block == block) return;
        block = new_block;
        const Leaf* leaf = accessor.probeLeaf(coord(block));
        values = leaf != nullptr ? leaf->data()->mValues : nullptr;
        if (values == nullptr) value = accessor.getValue(coord(block));
    }

    bool holds(const glm::ivec3& least_corner) const {
        return glm::all(glm::greaterThanEqual(least_corner, density.low() - 1)) &&
               glm::all(glm::lessThanEqual(least_corner, density.high()));
    }

    void corners(const glm::ivec3& cell, float (&out)[8]) {
        const glm::ivec3 in_block = cell & (kBlock - 1);
        if (std::max({in_block.x, in_block.y, in_block.z}) < kBlock - 1) {
            enter(cell - in_block);
            if (values == nullptr) {
                std::fill(out, out + 8, value);
                return;
            }
            const float* v = values + Leaf::CoordToOffset(coord(in_block));
            for (int corner = 0; corner < 8; ++corner) {
                out[corner] = v[(corner & 1) * kBlock * kBlock + (corner >> 1 & 1) * kBlock + (corner >> 2)];
            }
            return;
        }
        for (int corner = 0; corner < 8; ++corner) {
            out[corner] = accessor.getValue(
                {cell.x + (corner & 1), cell.y + (corner >> 1 & 1), cell.z + (corner >> 2)});
        }
    }
};

DensityGrid::Reader::Reader(const DensityGrid& grid) {
    static_assert(sizeof(State) <= sizeof(room_) && alignof(State) <= 16);
    static_assert(std::is_trivially_destructible_v<State>);
    if (!grid.empty()) state_ = new (room_.data()) State(static_cast<const NanoDensityGrid&>(grid));
}

float DensityGrid::Reader::voxel(glm::ivec3 at) {
    return state_ ? state_->accessor.getValue(coord(at)) : 0.0F;
}

float DensityGrid::Reader::density(const glm::dvec3& at) {
    // Written so that NaN is outside.
    if (!state_ || !(at.x > state_->first.x && at.x < state_->last.x && at.y > state_->first.y &&
                     at.y < state_->last.y && at.z > state_->first.z && at.z < state_->last.z)) {
        return 0;
    }
    const glm::dvec3 least = glm::floor(at);
    const glm::vec3 share(at - least);
    float c[8];
    state_->corners(glm::ivec3(least), c);
    return mix(mix(mix(c[0], c[1], share.x), mix(c[2], c[3], share.x), share.y),
               mix(mix(c[4], c[5], share.x), mix(c[6], c[7], share.x), share.y), share.z);
}

void DensityGrid::Reader::cell(glm::ivec3 cell, float (&corners)[8]) {
    if (state_ && state_->holds(cell)) {
        state_->corners(cell, corners);
    } else {
        std::fill(corners, corners + 8, 0.0F);
    }
}

bool DensityGrid::Reader::block_is_empty(glm::ivec3 at) {
    if (!state_) return true;
    const Leaf* leaf = state_->accessor.probeLeaf(coord(at));
    return leaf != nullptr ? leaf->data()->mValueMask.isOff() : !state_->accessor.isActive(coord(at));
}

}  // namespace dapple::grids
