#pragma once
#include <stdexcept>
#include <string>

namespace dapple {

/// Exit codes of the program (CONVENTIONS.md, "Errors and exit codes").
enum class ExitCode : int {
    done = 0,
    failure = 1,
    usage = 2,
    timeline_invalid = 3,
    input_unreadable = 4,
    output_unwritable = 5,
    check_failed = 6,
    device = 7,
    out_of_memory_budget = 33,
    interrupted = 75,
};

/// Bad input or a failed environment: `what()` is one line that says what, where, and what would be right.
/// Broken invariants are assertions, expected failures are return values.
class Error : public std::runtime_error {
public:
    Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
    ExitCode code() const noexcept { return code_; }

private:
    ExitCode code_;
};

/// A library's own message, made safe to print: control characters become spaces, and what passes 1023 bytes
/// is cut.
std::string clipped(const std::string& library_message);

}  // namespace dapple
