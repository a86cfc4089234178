#pragma once
#include <sys/types.h>

#include <cstddef>
#include <cstdio>
#include <span>
#include <string>
#include <vector>

namespace dapple::video {

/// A child process that is fed through its standard input. It runs in a process group of its own, so that
/// Ctrl-C on the terminal reaches only its parent, and without a shell.
class EncoderProcess {
public:
    /// `arguments[0]` is looked for in $PATH. Throws Error(failure) where it cannot be started.
    explicit EncoderProcess(const std::vector<std::string>& arguments);
    ~EncoderProcess();  ///< ends it, if it still runs
    EncoderProcess(const EncoderProcess&) = delete;
    EncoderProcess& operator=(const EncoderProcess&) = delete;

    /// False where the process does not read any more.
    bool feed(std::span<const unsigned char> bytes);
    /// Closes its input and waits for its end; true where it ended with 0.
    bool finish();
    /// What it wrote to standard error, made safe to print. After finish().
    std::string complaint() const;

private:
    void close_input();

    pid_t process_ = -1;
    int input_ = -1;
    std::FILE* errors_ = nullptr;
};

}  // namespace dapple::video
