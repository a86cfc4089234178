#pragma once
#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace dapple::testing_tools {

/// A program under test. What it prints goes to a file and can be read after wait().
class ChildProcess {
public:
    explicit ChildProcess(const std::vector<std::string>& arguments,
                          const std::string& output_file = "/dev/null")
        : output_file_(output_file) {
        std::vector<char*> argv;
        for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
        argv.push_back(nullptr);
        process_ = ::fork();
        if (process_ != 0) return;
        const int output = ::open(output_file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
        ::dup2(output, STDOUT_FILENO);
        ::dup2(output, STDERR_FILENO);
        ::execvp(argv[0], argv.data());
        ::_exit(127);
    }
    ~ChildProcess() {
        if (process_ <= 0) return;
        signal(SIGKILL);
        wait();
    }
    ChildProcess(const ChildProcess&) = delete;
    ChildProcess& operator=(const ChildProcess&) = delete;

    void signal(int number) const { ::kill(process_, number); }

    /// Its exit code, or minus the signal that ended it.
    int wait() {
        int status = 0;
        ::waitpid(process_, &status, 0);
        process_ = -1;
        return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    }

    std::string output() const {
        std::ifstream stream(output_file_);
        std::stringstream text;
        text << stream.rdbuf();
        return text.str();
    }

private:
    std::string output_file_;
    pid_t process_ = -1;
};

struct Outcome {
    int code = 0;
    std::string output;
};

/// Runs a program to its end.
inline Outcome run_program(const std::vector<std::string>& arguments, const std::string& output_file) {
    ChildProcess child(arguments, output_file);
    const int code = child.wait();
    return {code, child.output()};
}

}  // namespace dapple::testing_tools
