#pragma once

namespace dapple::run {

/// Handles SIGINT, SIGTERM and SIGHUP from its construction on. The first asks the frame loop to stop: it
/// finishes its frame (or the method keeps what it has of it), enters it in the manifest and ends with 75. A
/// second one ends the process at once, with 130 after SIGINT and 143 after the others; at most temporary
/// files are left then. SIGPIPE and SIGXFSZ are ignored, so that a closed pipe or a limit on file size is an
/// error of the write. One object a process.
class Interruption {
public:
    Interruption();
    ~Interruption();  ///< restores the default actions
    Interruption(const Interruption&) = delete;
    Interruption& operator=(const Interruption&) = delete;

    bool requested() const;
};

}  // namespace dapple::run
