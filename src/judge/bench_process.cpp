#include "judge/bench_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "base/error.h"
#include "base/stats.h"

namespace dapple::judge {
namespace {

constexpr int kLookEvery = 100;  // ms, whether to stop

/// Between fork and exec: calls that are safe after the fork of a process with threads.
[[noreturn]] void become(char* const* argv, int output, pid_t parent) {
    ::setpgid(0, 0);
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (::getppid() != parent) ::_exit(127);  // it ended before the line above
    ::dup2(output, STDOUT_FILENO);
    ::dup2(output, STDERR_FILENO);
    ::execv(argv[0], argv);
    ::_exit(127);
}

double seconds(const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

/// The text after "ERROR [CODE] "; empty where the line is none.
std::string error_of(const std::string& line) {
    const std::string head = "ERROR [";
    const std::size_t end = line.find("] ");
    return line.starts_with(head) && end != std::string::npos ? clipped(line.substr(end + 2)) : "";
}

}  // namespace

ProcessEnd run_process(const std::vector<std::string>& arguments, const std::function<bool()>& stop,
                       const std::function<void(const std::string&)>& on_line) {
    std::vector<char*> argv;
    argv.reserve(arguments.size() + 1);
    for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) {
        throw Error(ExitCode::failure, std::string("no pipe to a run: ") + std::strerror(errno));
    }
    const double start = wall_seconds();
    const pid_t parent = ::getpid();
    const pid_t child = ::fork();
    if (child == 0) become(argv.data(), ends[1], parent);
    ::close(ends[1]);
    if (child < 0) {
        ::close(ends[0]);
        throw Error(ExitCode::failure, std::string("no process for a run: ") + std::strerror(errno));
    }

    ProcessEnd end;
    std::string text;
    bool told = false;
    for (bool open = true; open;) {
        if (!told && stop()) {
            ::kill(child, SIGTERM);
            told = true;
        }
        pollfd ready{ends[0], POLLIN, 0};
        if (::poll(&ready, 1, kLookEvery) <= 0) continue;
        char buffer[4096];
        const ssize_t count = ::read(ends[0], buffer, sizeof buffer);
        if (count < 0 && errno == EINTR) continue;
        open = count > 0;
        if (open) text.append(buffer, static_cast<std::size_t>(count));
        for (std::size_t line_end = 0; (line_end = text.find('\n')) != std::string::npos;) {
            const std::string line = text.substr(0, line_end);
            text.erase(0, line_end + 1);
            if (const std::string error = error_of(line); !error.empty()) end.error = error;
            on_line(line);
        }
    }
    ::close(ends[0]);
    int status = 0;
    rusage usage{};
    while (::wait4(child, &status, 0, &usage) < 0 && errno == EINTR) {
    }
    end.wall_s = wall_seconds() - start;
    end.cpu_s = seconds(usage.ru_utime) + seconds(usage.ru_stime);
    if (WIFSIGNALED(status)) {
        end.signal = WTERMSIG(status);
        end.error = "ended by signal " + std::to_string(end.signal) + " (" + ::strsignal(end.signal) + ")";
    } else {
        end.exit_code = WEXITSTATUS(status);
        if (end.exit_code == 127 && end.error.empty()) end.error = arguments[0] + " cannot be started";
    }
    return end;
}

}  // namespace dapple::judge
