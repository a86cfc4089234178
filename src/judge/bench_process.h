#pragma once
#include <functional>
#include <string>
#include <vector>

namespace dapple::judge {

/// How a child process ended.
struct ProcessEnd {
    int exit_code = 0;
    int signal = 0;     ///< that ended it; 0: it ended by itself
    std::string error;  ///< its line "ERROR [CODE] ...", without that head; or how it was ended
    double wall_s = 0;  ///< from its start to its end
    double cpu_s = 0;   ///< all its threads

    bool done() const { return signal == 0 && exit_code == 0; }
};

/// Runs a program to its end, in a process group of its own, so that Ctrl-C on the terminal reaches only this
/// process; it is told to end (SIGTERM, once) when `stop` becomes true or when this process is gone.
/// `on_line` gets each line that it prints to standard output or error. `arguments[0]` is its path. Throws
/// Error(failure) where it cannot be started.
ProcessEnd run_process(const std::vector<std::string>& arguments, const std::function<bool()>& stop,
                       const std::function<void(const std::string&)>& on_line);

}  // namespace dapple::judge
