#include "run/interruption.h"

#include <signal.h>
#include <unistd.h>

#include <atomic>

namespace dapple::run {
namespace {

constexpr int kStopping[] = {SIGINT, SIGTERM, SIGHUP};
constexpr int kIgnored[] = {SIGPIPE, SIGXFSZ};

std::atomic<int> signals_received = 0;
static_assert(std::atomic<int>::is_always_lock_free, "used in a signal handler");

extern "C" void on_stop_signal(int signal) {
    if (signals_received.fetch_add(1) > 0) _exit(signal == SIGINT ? 130 : 143);
}

void set_action(int signal, void (*handler)(int)) {
    struct sigaction action {};
    action.sa_handler = handler;
    action.sa_flags = SA_RESTART;  // the libraries below need not know of interrupted system calls
    sigemptyset(&action.sa_mask);
    sigaction(signal, &action, nullptr);
}

}  // namespace

Interruption::Interruption() {
    signals_received = 0;
    for (const int signal : kStopping) set_action(signal, on_stop_signal);
    for (const int signal : kIgnored) set_action(signal, SIG_IGN);
}

Interruption::~Interruption() {
    for (const int signal : kStopping) set_action(signal, SIG_DFL);
    for (const int signal : kIgnored) set_action(signal, SIG_DFL);
}

bool Interruption::requested() const {
    return signals_received > 0;
}

}  // namespace dapple::run
