// dapple-read-vdb: reads OpenVDB files for dapple in a process of its own, whose memory is limited and which
// may crash, as OpenVDB can on damaged files. Says what it finds as vdb_reply.h lays it out.
#include <nanovdb/util/OpenToNanoVDB.h>
#include <openvdb/io/File.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/tools/Prune.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "grids/openvdb_trees.h"
#include "grids/reader_limits.h"
#include "grids/vdb_reply.h"

namespace dapple::grids {
namespace {

/// Ends the reading with an outcome other than done.
struct Refusal {
    Outcome outcome;
    std::string message;
};

[[noreturn]] void refuse(const std::string& message) {
    throw Refusal{Outcome::unreadable, message};
}

[[noreturn]] void refuse_size(const std::string& message) {
    throw Refusal{Outcome::too_large, message};
}

std::string brief(const std::string& text, std::size_t longest = 60) {
    return text.size() <= longest ? text : text.substr(0, longest) + "...";
}

/// What OpenVDB knows of a file before its grids.
class FileHead : public openvdb::io::Archive {
public:
    explicit FileHead(std::istream& file) {
        readHeader(file);
        setFormatVersion(file);  // which what follows is laid out by
        setLibraryVersion(file);
        openvdb::MetaMap().readMeta(file);
        grids_ = readGridCount(file);
    }
    int grids() const { return grids_; }
    bool has_grid_ends() const { return inputHasGridOffsets(); }

private:
    int grids_ = 0;
};

/// Refuses a file that is shorter than it says. OpenVDB's reader looks neither at a file's length nor, but
/// for some compressions, at how much was left to read: it takes what is missing for names of nothing, or for
/// zeros.
void expect_whole_file(const std::string& path) {
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    const auto size = static_cast<std::int64_t>(file.tellg());
    if (size <= 0) refuse("is empty");
    file.seekg(0);
    const auto expect = [&](bool whole) {
        if (!whole)
            refuse("is cut off after " + std::to_string(size) + " bytes: it says that there are more");
    };
    const FileHead head(file);
    expect(!file.fail());
    if (!head.has_grid_ends()) return;
    for (int grid = 0; grid < head.grids(); ++grid) {
        openvdb::io::GridDescriptor described;
        described.read(file);
        expect(!file.fail() && described.getEndPos() <= size);
        described.seekToEnd(file);
    }
}

/// Where NanoVDB's converter writes to: the file that is shared with the parent.
class SharedVoxels {
public:
    static SharedVoxels create(std::uint64_t size, const SharedVoxels* = nullptr) {
        SharedVoxels voxels;
        if (::ftruncate(kVoxelsFile, static_cast<off_t>(size)) != 0) refuse("no file for its voxels");
        void* data = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, kVoxelsFile, 0);
        if (data == MAP_FAILED) run_out_of_memory(0);
        voxels.data_ = static_cast<std::uint8_t*>(data);
        voxels.size_ = size;
        return voxels;
    }
    std::uint8_t* data() { return data_; }
    const std::uint8_t* data() const { return data_; }
    std::uint64_t size() const { return size_; }
    bool empty() const { return size_ == 0; }
    void clear() {}

private:
    std::uint8_t* data_ = nullptr;
    std::uint64_t size_ = 0;
};

template <typename Value>
std::optional<Value> metadata(const openvdb::GridBase& grid, const char* name) {
    const auto found = grid.getMetadata<openvdb::TypedMetadata<Value>>(name);
    return found ? std::optional<Value>(found->value()) : std::nullopt;
}

/// Memory while a grid is loaded: OpenVDB's tree, and NanoVDB's of the same size. 0 where the file says
/// nothing.
std::uint64_t loading_bytes(const openvdb::GridBase& grid) {
    const std::int64_t tree =
        metadata<std::int64_t>(grid, openvdb::GridBase::META_FILE_MEM_BYTES).value_or(0);
    return tree > 0 ? 2 * static_cast<std::uint64_t>(tree) : 0;
}

GridEntry entry_of(openvdb::io::File& file, openvdb::GridBase::Ptr grid) {
    GridEntry entry;
    copy_text(entry.name, grid->getName().c_str());
    copy_text(entry.value_type, grid->valueType().c_str());
    copy_text(entry.grid_class, openvdb::GridBase::gridClassToString(grid->getGridClass()).c_str());
    entry.loading_bytes = loading_bytes(*grid);
    const openvdb::Vec3d voxel_size = grid->voxelSize();
    std::copy(voxel_size.asPointer(), voxel_size.asPointer() + 3, entry.voxel_size);

    auto count = metadata<std::int64_t>(*grid, openvdb::GridBase::META_FILE_VOXEL_COUNT);
    auto low = metadata<openvdb::Vec3i>(*grid, openvdb::GridBase::META_FILE_BBOX_MIN);
    auto high = metadata<openvdb::Vec3i>(*grid, openvdb::GridBase::META_FILE_BBOX_MAX);
    if (!count || !low || !high) {
        grid = file.readGrid(grid->getName());
        const openvdb::CoordBBox bounds = grid->evalActiveVoxelBoundingBox();
        count = static_cast<std::int64_t>(grid->activeVoxelCount());
        low = bounds.min().asVec3i();
        high = bounds.max().asVec3i();
        entry.loading_bytes = 2 * grid->memUsage();
    }
    entry.active_voxels = std::max<std::int64_t>(*count, 0);
    for (int axis = 0; axis < 3; ++axis) {
        entry.low[axis] = *count > 0 ? (*low)[axis] : 0;
        entry.high[axis] = *count > 0 ? (*high)[axis] : -1;
    }
    return entry;
}

openvdb::GridBase::Ptr find_grid(const openvdb::GridPtrVec& grids, const std::string& name) {
    std::string present;
    std::size_t left_out = 0;
    for (const openvdb::GridBase::Ptr& grid : grids) {
        if (grid->getName() == name) return grid;
        if (present.size() < 300) {
            present += (present.empty() ? "" : ", ") + brief(grid->getName());
        } else {
            ++left_out;
        }
    }
    if (left_out > 0) present += " and " + std::to_string(left_out) + " more";
    refuse(present.empty() ? "holds no grids" : "has no grid '" + brief(name) + "'; it holds " + present);
}

/// Voxels of one kind of fault.
struct Faults {
    std::uint64_t count = 0;
    openvdb::Coord first;

    void add(const openvdb::Coord& at, std::uint64_t voxels) {
        if (count == 0) first = at;
        count += voxels;
    }
    std::string text(const std::string& what) const {
        return std::to_string(count) + (count == 1 ? " voxel that is " : " voxels that are ") + what +
               " (the first at " + std::to_string(first.x()) + ", " + std::to_string(first.y()) + ", " +
               std::to_string(first.z()) + ")";
    }
};

/// Takes away what is active but 0, and the values of what is not active. Refuses what is no density.
void keep_density(openvdb::FloatGrid& grid) {
    Faults non_finite;
    Faults negative;
    for (auto voxel = grid.tree().beginValueAll(); voxel; ++voxel) {
        const float value = voxel.getValue();
        if (voxel.isValueOn() && !std::isfinite(value)) {
            non_finite.add(voxel.getCoord(), voxel.getVoxelCount());
        } else if (voxel.isValueOn() && value < 0) {
            negative.add(voxel.getCoord(), voxel.getVoxelCount());
        } else if (!voxel.isValueOn() || value == 0) {
            voxel.setValue(0.0F);  // which may have been -0
            voxel.setValueOff();
        }
    }
    std::string faults = non_finite.count > 0 ? non_finite.text("NaN or infinite") : "";
    if (negative.count > 0) faults += (faults.empty() ? "" : " and ") + negative.text("negative");
    if (!faults.empty()) refuse("is no density: it has " + faults);
    grid.tree().root().setBackground(0, false);
    openvdb::tools::pruneInactive(grid.tree(), false);
}

openvdb::FloatGrid::Ptr float_grid(const openvdb::GridBase::Ptr& grid) {
    if (grid->isType<openvdb::DoubleGrid>()) {
        return std::make_shared<openvdb::FloatGrid>(*openvdb::gridPtrCast<openvdb::DoubleGrid>(grid));
    }
    return openvdb::gridPtrCast<openvdb::FloatGrid>(grid);
}

void read_grid(const std::string& path, const std::string& name, std::uint64_t most_bytes, Reply& reply) {
    openvdb::io::File file(path);
    file.open(false);
    const openvdb::GridPtrVecPtr present = file.readAllGridMetadata();
    const openvdb::GridBase::Ptr found = find_grid(*present, name);
    const std::string quoted = "grid '" + brief(name) + "' ";
    if (!found->isType<openvdb::FloatGrid>() && !found->isType<openvdb::DoubleGrid>()) {
        refuse(quoted + "is of type " + brief(found->valueType()) + "; a density is float, half or double");
    }
    if (found->getGridClass() == openvdb::GRID_LEVEL_SET) {
        refuse(quoted + "is a level set, which holds distances; a density is a fog volume");
    }
    const std::uint64_t needed = loading_bytes(*found);
    if (needed > most_bytes) {
        const std::int64_t voxels =
            metadata<std::int64_t>(*found, openvdb::GridBase::META_FILE_VOXEL_COUNT).value_or(0);
        refuse_size(quoted + "has " + std::to_string(voxels) + " voxels, which take " + mebibytes(needed) +
                    " of memory; " + mebibytes(most_bytes) + " are left");
    }
    openvdb::FloatGrid::Ptr grid = float_grid(file.readGrid(name));
    const auto map = grid->transform().baseMap();
    if (!map->isLinear()) refuse(quoted + "has a transform that is not linear");
    const openvdb::Mat4d matrix = map->getAffineMap()->getMat4();  // of row vectors: its rows are our columns
    std::copy(matrix.asPointer(), matrix.asPointer() + 16, reply.file_from_index);
    try {
        keep_density(*grid);
    } catch (const Refusal& refusal) {
        throw Refusal{refusal.outcome, quoted + refusal.message};
    }
    if (grid->tree().empty()) return;
    const openvdb::CoordBBox bounds = grid->evalActiveVoxelBoundingBox();
    constexpr std::int64_t farthest = (std::int64_t{1} << 30) - 4096;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (bounds.min()[axis] < -farthest || bounds.max()[axis] > farthest) {
            refuse(quoted + "has voxels that lie too far out, beyond index 2^30");
        }
    }
    // What the converter would refuse or keep for nothing.
    grid->setTransform(openvdb::math::Transform::createLinearTransform(1.0));
    grid->setName("");
    const auto handle = nanovdb::openToNanoVDB<SharedVoxels>(*grid, nanovdb::StatsMode::Disable,
                                                             nanovdb::ChecksumMode::Disable);
    reply.voxels_bytes = handle.size();
    if (reply.voxels_bytes > most_bytes) run_out_of_memory(0);
}

std::vector<GridEntry> list_grids(const std::string& path) {
    openvdb::io::File file(path);
    file.open(false);
    const openvdb::GridPtrVecPtr present = file.readAllGridMetadata();
    std::vector<GridEntry> entries;
    for (const openvdb::GridBase::Ptr& grid : *present) {
        if (entries.size() == kMostGrids) refuse("says that it holds more than 10000 grids");
        entries.push_back(entry_of(file, grid));
    }
    return entries;
}

int run(int count, char** arguments) {
    const std::string verb = count > 1 ? arguments[1] : "";
    const bool info = verb == "info" && count == 4;
    const bool read = verb == "read" && count == 5;
    if (!info && !read) {
        std::fprintf(stderr, "dapple-read-vdb is run by dapple, which reads OpenVDB files with it\n");
        return 2;
    }
    const std::uint64_t most_bytes = std::strtoull(arguments[count - 1], nullptr, 10);
    confine_process();
    Reply reply;
    std::memcpy(reply.mark, kReplyMark, sizeof reply.mark);
    std::vector<GridEntry> entries;
    try {
        openvdb::initialize();
        limit_memory(arguments[2], most_bytes);
        expect_whole_file(arguments[2]);
        if (info) {
            entries = list_grids(arguments[2]);
        } else {
            read_grid(arguments[2], arguments[3], most_bytes, reply);
        }
        reply.outcome = Outcome::done;
        reply.grids = static_cast<std::uint32_t>(entries.size());
    } catch (const Refusal& refusal) {
        reply.outcome = refusal.outcome;
        copy_text(reply.message, refusal.message.c_str());
    } catch (const std::exception& fault) {
        // Of whatever part of the file it took for something else.
        copy_text(reply.message, ("cannot be read to its end: it is cut off, damaged or no OpenVDB file (" +
                                  brief(fault.what(), 200) + ")")
                                     .c_str());
    }
    write_all(&reply, sizeof reply);
    if (!entries.empty() && reply.outcome == Outcome::done) {
        write_all(entries.data(), entries.size() * sizeof(GridEntry));
    }
    // Without taking apart trees that go with the process.
    std::fflush(nullptr);
    std::_Exit(0);
}

}  // namespace
}  // namespace dapple::grids

int main(int count, char** arguments) {
    return dapple::grids::run(count, arguments);
}
