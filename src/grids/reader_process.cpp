#include "grids/reader_process.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <utility>

#include "base/error.h"
#include "grids/vdb_reply.h"

namespace dapple::grids {
namespace {

constexpr const char* kProgram = "dapple-read-vdb";

class File {
public:
    File() = default;
    explicit File(int descriptor) : descriptor_(descriptor) {}
    File(File&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
    File& operator=(File&& other) noexcept {
        std::swap(descriptor_, other.descriptor_);
        return *this;
    }
    ~File() { close(); }
    int get() const { return descriptor_; }
    void close() {
        if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
    }

private:
    int descriptor_ = -1;
};

/// The same file under a number that no file of the child has.
File moved_up(int descriptor) {
    const File old(descriptor);
    File moved(::fcntl(descriptor, F_DUPFD_CLOEXEC, kReplyFile + 1));
    if (moved.get() < 0) {
        throw Error(ExitCode::failure, std::string("no file for the reader: ") + std::strerror(errno));
    }
    return moved;
}

/// A child that is killed with its owner.
class Child {
public:
    Child(const std::vector<std::string>& arguments, int output, int voxels) {
        posix_spawn_file_actions_t files;
        posix_spawn_file_actions_init(&files);
        posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
        posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
        posix_spawn_file_actions_addopen(&files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
        posix_spawn_file_actions_adddup2(&files, voxels, kVoxelsFile);
        posix_spawn_file_actions_adddup2(&files, output, kReplyFile);
        posix_spawn_file_actions_addclosefrom_np(&files, kReplyFile + 1);

        posix_spawnattr_t attributes;
        posix_spawnattr_init(&attributes);
        sigset_t signals;
        sigfillset(&signals);
        posix_spawnattr_setsigdefault(&attributes, &signals);
        sigemptyset(&signals);
        posix_spawnattr_setsigmask(&attributes, &signals);
        posix_spawnattr_setpgroup(&attributes, 0);
        posix_spawnattr_setflags(&attributes,
                                 POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETPGROUP);

        std::vector<char*> argv;
        argv.reserve(arguments.size() + 1);
        for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
        argv.push_back(nullptr);
        const int fault = ::posix_spawn(&process_, argv[0], &files, &attributes, argv.data(), environ);
        posix_spawnattr_destroy(&attributes);
        posix_spawn_file_actions_destroy(&files);
        if (fault != 0) {
            process_ = -1;
            throw Error(ExitCode::failure, clipped(arguments[0]) + ", which reads OpenVDB files, cannot be " +
                                               "started: " + std::strerror(fault));
        }
    }
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;
    ~Child() {
        kill();
        if (process_ > 0) wait();
    }

    void kill() const {
        if (process_ > 0) ::kill(process_, SIGKILL);
    }
    int wait() {
        int status = 0;
        while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) {
        }
        process_ = -1;
        return status;
    }

private:
    pid_t process_ = -1;
};

std::string how_it_ended(int status) {
    if (WIFSIGNALED(status)) {
        return std::string("crashed with signal ") + std::to_string(WTERMSIG(status)) + ", " +
               ::strsignal(WTERMSIG(status));
    }
    return WEXITSTATUS(status) == 0 ? "" : "ended with code " + std::to_string(WEXITSTATUS(status));
}

/// Reads to the end of the child's output; why it stopped before, or nothing.
std::string read_output(int from, double most_seconds, std::size_t most_text, std::vector<std::byte>& text) {
    using Clock = std::chrono::steady_clock;
    const auto end = Clock::now() + std::chrono::duration<double>(most_seconds);
    std::array<std::byte, 65536> part;
    for (;;) {
        const double left = std::chrono::duration<double>(end - Clock::now()).count();
        pollfd watched{from, POLLIN, 0};
        const int ready = left > 0 ? ::poll(&watched, 1, static_cast<int>(left * 1000) + 1) : 0;
        if (ready == 0) {
            char seconds[32];
            std::snprintf(seconds, sizeof seconds, "%.3g", most_seconds);
            return std::string("took longer than ") + seconds + " s";
        }
        if (ready < 0) {
            if (errno == EINTR) continue;
            return std::strerror(errno);
        }
        const ssize_t count = ::read(from, part.data(), part.size());
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) return std::strerror(errno);
        if (count == 0) return "";
        text.insert(text.end(), part.begin(), part.begin() + count);
        if (text.size() > most_text) return "said too much";
    }
}

/// The file's content. Nobody else has it open any more, so that it keeps its size.
GridBuffer mapped(const File& file) {
    struct stat state {};
    if (::fstat(file.get(), &state) != 0 || state.st_size <= 0) return {};
    const auto size = static_cast<std::size_t>(state.st_size);
    void* data = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, file.get(), 0);
    if (data == MAP_FAILED) {
        throw Error(ExitCode::failure, std::string("voxels cannot be mapped: ") + std::strerror(errno));
    }
    return {{static_cast<const std::byte*>(data),
             [size](const std::byte* begin) { ::munmap(const_cast<std::byte*>(begin), size); }},
            size};
}

}  // namespace

ProcessOutput run_reader(const std::vector<std::string>& arguments, double most_seconds,
                         std::size_t most_text) {
    const int memory = ::memfd_create("dapple voxels", MFD_CLOEXEC);
    if (memory < 0)
        throw Error(ExitCode::failure, std::string("no memory to read into: ") + std::strerror(errno));
    const File voxels = moved_up(memory);
    int ends[2] = {-1, -1};
    if (::pipe2(ends, O_CLOEXEC) != 0) {
        throw Error(ExitCode::failure, std::string("no pipe to the reader: ") + std::strerror(errno));
    }
    const File from_child(ends[0]);
    File to_parent = moved_up(ends[1]);

    ProcessOutput output;
    Child child(arguments, to_parent.get(), voxels.get());
    to_parent.close();
    output.failure = read_output(from_child.get(), most_seconds, most_text, output.text);
    if (!output.failure.empty()) child.kill();
    const std::string ending = how_it_ended(child.wait());
    if (output.failure.empty()) output.failure = ending;
    if (output.failure.empty()) output.voxels = mapped(voxels);
    return output;
}

std::string reader_program() {
    std::error_code ignored;
    const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", ignored);
    const std::filesystem::path beside = self.parent_path() / kProgram;
    return std::filesystem::exists(beside, ignored) ? beside.string() : DAPPLE_READ_VDB;
}

}  // namespace dapple::grids
