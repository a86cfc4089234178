#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

#include "metrics/flicker.h"

namespace dapple::run {

/// Tells how a run goes: on standard output one updating line where that is a terminal, else a plain line for
/// each frame, written at once; and on demand one line of JSON for each event in a file. A closed standard
/// output or a full disk below the event log does not stop the rendering.
class Reporter {
public:
    /// `event_log`: path to append to, empty: none. Throws Error(output_unwritable) where it cannot be
    /// opened.
    explicit Reporter(const std::string& event_log = "");
    ~Reporter();
    Reporter(const Reporter&) = delete;
    Reporter& operator=(const Reporter&) = delete;

    void run_started(const std::string& folder, std::size_t frames);
    void frame_kept(std::int64_t frame);
    void frame_rendered(std::int64_t frame, double wall_s, double cpu_s, std::uint64_t bytes,
                        std::size_t non_finite);
    /// How the clip flickers; it has a worst frame.
    void clip_measured(const metrics::ClipFlicker& clip);
    void preview_made(const std::string& path, std::uint64_t bytes);
    /// Something that the user should know but that stops nothing; on standard error.
    void warning(const std::string& message);
    void note(const std::string& message);
    /// What is going on, in the updating line; only where that is a terminal.
    void status(const std::string& text);
    /// The last line: what was done, in how long.
    void run_ended(int exit_code, const std::string& summary);
    /// For the event log only: the caller prints its error.
    void run_failed(int exit_code, const std::string& message);

    std::size_t rendered() const { return rendered_; }
    std::size_t kept() const { return kept_; }
    double seconds() const;  ///< since run_started

private:
    void progress(const std::string& text);
    void update_line(const std::string& text);
    void line(const std::string& text);
    void event(const std::string& name, const std::string& members);
    std::string time_left() const;

    int event_log_ = -1;
    bool terminal_ = false;
    bool line_open_ = false;  ///< the terminal shows a progress line without an end
    std::size_t frames_ = 0;
    std::size_t rendered_ = 0;
    std::size_t kept_ = 0;
    double rendering_s_ = 0;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// "0:07", "12:34", "1:02:03".
std::string format_duration(double seconds);

}  // namespace dapple::run
