#include "run/reporter.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>

#include "base/error.h"

namespace dapple::run {
namespace {

using Json = nlohmann::ordered_json;

/// Writes what it can: whoever reads our output may have gone.
bool write_text(int descriptor, const std::string& text) {
    std::size_t done = 0;
    while (done < text.size()) {
        const ssize_t count = ::write(descriptor, text.data() + done, text.size() - done);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) return false;
        done += static_cast<std::size_t>(count);
    }
    return true;
}

std::string seconds_text(double seconds) {
    char text[32];
    std::snprintf(text, sizeof text, "%.2f s", seconds);
    return text;
}

/// The members of an object as text, without its braces; names and values in pairs.
std::string members(const Json& object) {
    const std::string text = object.dump(-1, ' ', false, Json::error_handler_t::replace);
    return text.substr(1, text.size() - 2);
}

}  // namespace

std::string format_duration(double seconds) {
    const long long whole = std::llround(seconds);
    char text[48];
    if (whole < 3600) {
        std::snprintf(text, sizeof text, "%lld:%02lld", whole / 60, whole % 60);
    } else {
        std::snprintf(text, sizeof text, "%lld:%02lld:%02lld", whole / 3600, whole / 60 % 60, whole % 60);
    }
    return text;
}

Reporter::Reporter(const std::string& event_log) : terminal_(::isatty(STDOUT_FILENO) == 1) {
    if (event_log.empty()) return;
    event_log_ = ::open(event_log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
    if (event_log_ < 0) {
        throw Error(ExitCode::output_unwritable, event_log + ": cannot be opened: " + std::strerror(errno));
    }
}

Reporter::~Reporter() {
    if (line_open_) write_text(STDOUT_FILENO, "\n");
    if (event_log_ >= 0) ::close(event_log_);
}

void Reporter::run_started(const std::string& folder, std::size_t frames) {
    frames_ = frames;
    start_ = std::chrono::steady_clock::now();
    event("run_started", members({{"folder", folder}, {"frames", frames}}));
}

void Reporter::frame_kept(std::int64_t frame) {
    ++kept_;
    event("frame_kept", members({{"frame", frame}}));
    progress("frame " + std::to_string(frame) + ": kept");
}

void Reporter::frame_rendered(std::int64_t frame, double wall_s, double cpu_s, std::uint64_t bytes,
                              std::size_t non_finite) {
    ++rendered_;
    rendering_s_ += wall_s;
    event("frame_rendered", members({{"frame", frame},
                                     {"wall_s", wall_s},
                                     {"cpu_s", cpu_s},
                                     {"bytes", bytes},
                                     {"non_finite", non_finite}}));
    progress("frame " + std::to_string(frame) + ": " + seconds_text(wall_s));
}

void Reporter::clip_measured(const metrics::ClipFlicker& clip) {
    const metrics::ClipFlicker::Frame& worst = clip.frames.at(*clip.worst_frame);
    event("clip_measured", members({{"measured_frames", clip.frames.size()},
                                    {"mean", clip.mean},
                                    {"flicker", clip.flicker},
                                    {"worst_frame", *clip.worst_frame},
                                    {"worst_flicker", worst.flicker},
                                    {"worst_jump_share", worst.jump_share}}));
    char text[160];
    std::snprintf(
        text, sizeof text, "flicker %.3g in the mean, %.3g in frame %lld, where %.2g %% of the pixels jump",
        clip.flicker, worst.flicker, static_cast<long long>(*clip.worst_frame), 100 * worst.jump_share);
    line(text);
}

void Reporter::preview_made(const std::string& path, std::uint64_t bytes) {
    event("preview_made", members({{"path", path}, {"bytes", bytes}}));
    line("preview " + path);
}

void Reporter::warning(const std::string& message) {
    event("warning", members({{"message", message}}));
    if (line_open_) line("");
    write_text(STDERR_FILENO, "WARNING " + message + "\n");
}

void Reporter::note(const std::string& message) {
    event("note", members({{"message", message}}));
    line(message);
}

void Reporter::status(const std::string& text) {
    if (terminal_) update_line(text);
}

void Reporter::run_ended(int exit_code, const std::string& summary) {
    event(
        "run_ended",
        members({{"exit_code", exit_code}, {"rendered", rendered_}, {"kept", kept_}, {"wall_s", seconds()}}));
    line(summary);
}

void Reporter::run_failed(int exit_code, const std::string& message) {
    event("run_failed", members({{"exit_code", exit_code}, {"message", message}}));
    line("");
}

double Reporter::seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

std::string Reporter::time_left() const {
    const std::size_t done = rendered_ + kept_;
    if (done >= frames_ || rendered_ == 0) return "";
    // As if all frames to come were to be rendered: kept ones only make it shorter.
    const double left = rendering_s_ / static_cast<double>(rendered_) * static_cast<double>(frames_ - done);
    return ", " + format_duration(left) + " left";
}

void Reporter::progress(const std::string& text) {
    const std::string full = text + ", " + std::to_string(rendered_ + kept_) + " of " +
                             std::to_string(frames_) + " done" + time_left();
    if (terminal_) {
        update_line(full);
    } else {
        write_text(STDOUT_FILENO, full + "\n");
    }
}

void Reporter::update_line(const std::string& text) {
    write_text(STDOUT_FILENO, "\r\033[K" + text);  // CSI K: erase to the end of the line (ECMA-48)
    line_open_ = true;
}

void Reporter::line(const std::string& text) {
    if (line_open_) write_text(STDOUT_FILENO, "\n");
    line_open_ = false;
    if (!text.empty()) write_text(STDOUT_FILENO, text + "\n");
}

void Reporter::event(const std::string& name, const std::string& members_text) {
    if (event_log_ < 0) return;
    const double now =
        std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
    const Json head = {{"v", 1}, {"t", now}, {"event", name}};
    if (!write_text(event_log_, "{" + members(head) + "," + members_text + "}\n")) {
        ::close(event_log_);
        event_log_ = -1;
        warning(std::string("the event log ends here: it cannot be written: ") + std::strerror(errno));
    }
}

}  // namespace dapple::run
