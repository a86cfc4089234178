#include "video/encoder_process.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "base/error.h"

namespace dapple::video {

EncoderProcess::EncoderProcess(const std::vector<std::string>& arguments) {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) {
        throw Error(ExitCode::failure, std::string("no pipe to the encoder: ") + std::strerror(errno));
    }
    errors_ = std::tmpfile();  // a file, not a pipe: nobody has to empty it while pictures are fed

    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, ends[0], STDIN_FILENO);
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    if (errors_ != nullptr) posix_spawn_file_actions_adddup2(&files, ::fileno(errors_), STDERR_FILENO);

    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    sigset_t defaults;
    sigemptyset(&defaults);
    sigaddset(&defaults, SIGPIPE);
    sigaddset(&defaults, SIGXFSZ);
    posix_spawnattr_setsigdefault(&attributes, &defaults);
    posix_spawnattr_setpgroup(&attributes, 0);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);

    std::vector<char*> argv;
    argv.reserve(arguments.size() + 1);
    for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    const int fault = ::posix_spawnp(&process_, argv[0], &files, &attributes, argv.data(), environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    ::close(ends[0]);
    input_ = ends[1];
    if (fault != 0) {
        process_ = -1;
        close_input();
        if (errors_ != nullptr) std::fclose(errors_);
        throw Error(ExitCode::failure, arguments[0] + " cannot be started: " + std::strerror(fault));
    }
}

EncoderProcess::~EncoderProcess() {
    close_input();
    if (process_ > 0) {
        ::kill(process_, SIGKILL);
        while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
        }
    }
    if (errors_ != nullptr) std::fclose(errors_);
}

bool EncoderProcess::feed(std::span<const unsigned char> bytes) {
    while (!bytes.empty()) {
        const ssize_t count = ::write(input_, bytes.data(), bytes.size());
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) return false;
        bytes = bytes.subspan(static_cast<std::size_t>(count));
    }
    return true;
}

bool EncoderProcess::finish() {
    close_input();
    int status = 0;
    while (::waitpid(process_, &status, 0) < 0) {
        if (errno != EINTR) break;
    }
    process_ = -1;
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

std::string EncoderProcess::complaint() const {
    if (errors_ == nullptr) return "";
    std::string text(2048, '\0');
    std::rewind(errors_);
    text.resize(std::fread(text.data(), 1, text.size(), errors_));
    while (!text.empty() && text.back() == '\n') text.pop_back();
    return clipped(text);
}

void EncoderProcess::close_input() {
    if (input_ >= 0) ::close(input_);
    input_ = -1;
}

}  // namespace dapple::video
