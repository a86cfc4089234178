#include "grids/vdb_file.h"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "base/error.h"
#include "grids/grid_buffer.h"
#include "grids/reader_process.h"
#include "grids/vdb_reply.h"

namespace dapple::grids {
namespace {

/// A listing reads voxels only where the file does not say how many there are.
constexpr std::size_t kMostInfoBytes = std::size_t{1} << 30;

/// Time that a file of `bytes` may take: a slow disk on a busy machine.
double most_seconds(double bytes) {
    return 60 + bytes / 2e6;
}

/// "path: message", of which the path's end and the message are kept where it gets long.
[[noreturn]] void fail(ExitCode code, const std::string& path, const std::string& message) {
    constexpr std::size_t longest_path = 300;
    const std::string shown =
        path.size() <= longest_path ? path : "..." + path.substr(path.size() - longest_path);
    throw Error(code, clipped(shown + ": " + message.substr(0, 600)));
}

/// Bytes of the file.
double size_of(const std::string& path) {
    struct stat state {};
    if (::stat(path.c_str(), &state) != 0) fail(ExitCode::input_unreadable, path, std::strerror(errno));
    if (!S_ISREG(state.st_mode)) fail(ExitCode::input_unreadable, path, "is no regular file");
    return static_cast<double>(state.st_size);
}

/// Text of a field that should end with a 0.
template <std::size_t size>
std::string text_of(const char (&field)[size]) {
    return clipped(std::string(field, ::strnlen(field, size)));
}

struct Answer {
    Reply reply;
    std::vector<GridEntry> entries;
    GridBuffer voxels;
};

/// Asks a reader process; throws where it does not answer, or answers with a fault.
Answer ask(const std::string& path, std::vector<std::string> arguments) {
    const double bytes = size_of(path);
    arguments.insert(arguments.begin(), reader_program());
    constexpr std::size_t most_text = sizeof(Reply) + kMostGrids * sizeof(GridEntry);
    ProcessOutput output = run_reader(arguments, most_seconds(bytes), most_text);
    if (!output.failure.empty()) {
        fail(ExitCode::input_unreadable, path, "reading it " + output.failure + "; it may be damaged");
    }
    Answer answer;
    if (output.text.size() >= sizeof(Reply)) std::memcpy(&answer.reply, output.text.data(), sizeof(Reply));
    const Reply& reply = answer.reply;
    if (std::memcmp(reply.mark, kReplyMark, sizeof reply.mark) != 0 || reply.grids > kMostGrids ||
        output.text.size() != sizeof(Reply) + reply.grids * sizeof(GridEntry)) {
        fail(ExitCode::failure, arguments[0], "gives no answer that this program understands");
    }
    if (reply.outcome == Outcome::too_large) {
        fail(ExitCode::out_of_memory_budget, path, text_of(reply.message));
    }
    if (reply.outcome != Outcome::done) fail(ExitCode::input_unreadable, path, text_of(reply.message));
    answer.entries.resize(reply.grids);
    if (reply.grids > 0) {
        std::memcpy(answer.entries.data(), output.text.data() + sizeof(Reply),
                    reply.grids * sizeof(GridEntry));
    }
    answer.voxels = std::move(output.voxels);
    return answer;
}

VdbGridInfo info_of(const GridEntry& entry) {
    VdbGridInfo info;
    info.name = text_of(entry.name);
    info.value_type = text_of(entry.value_type);
    info.grid_class = text_of(entry.grid_class);
    info.active_voxels = entry.active_voxels;
    info.low = {entry.low[0], entry.low[1], entry.low[2]};
    info.high = {entry.high[0], entry.high[1], entry.high[2]};
    info.voxel_size = {entry.voxel_size[0], entry.voxel_size[1], entry.voxel_size[2]};
    info.loading_bytes = entry.loading_bytes;
    return info;
}

}  // namespace

std::vector<VdbGridInfo> read_vdb_info(const std::string& path) {
    std::vector<VdbGridInfo> infos;
    for (const GridEntry& entry : ask(path, {"info", path, std::to_string(kMostInfoBytes)}).entries) {
        infos.push_back(info_of(entry));
    }
    return infos;
}

std::shared_ptr<const DensityGrid> read_vdb(const std::string& path, const std::string& grid,
                                            std::size_t most_bytes) {
    Answer answer = ask(path, {"read", path, grid, std::to_string(most_bytes)});
    glm::dmat4 file_from_index{1.0};
    std::memcpy(&file_from_index, answer.reply.file_from_index, sizeof file_from_index);
    try {
        if (answer.reply.voxels_bytes == 0) return empty_grid(file_from_index);
        if (answer.reply.voxels_bytes != answer.voxels.size) {
            throw Error(ExitCode::input_unreadable, "its voxels end too early");
        }
        return grid_of_buffer(std::move(answer.voxels), file_from_index);
    } catch (const Error& fault) {
        fail(fault.code(), path, "grid '" + clipped(grid).substr(0, 60) + "': " + fault.what());
    }
}

}  // namespace dapple::grids
