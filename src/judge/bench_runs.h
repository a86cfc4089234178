#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gpu/device.h"
#include "judge/bench_process.h"
#include "judge/bench_timing.h"
#include "run/interruption.h"
#include "run/job.h"
#include "run/manifest.h"
#include "run/reporter.h"

namespace dapple::judge {

/// Renders timelines by processes of this program.
class Renderings {
public:
    Renderings(int threads, std::string device, const run::Interruption& interruption,
               run::Reporter& reporter);

    /// What a render of these would make. Throws what a render would throw before its first frame.
    run::Job job(const std::string& timeline, const std::vector<std::string>& overrides);

    /// `render` into `folder`, frames in this order, all of the clip where none are named. Frames of another
    /// job are given up; `anew` renders those of the same job too. `name` stands in the progress line.
    ProcessEnd render(const std::string& name, const std::string& timeline,
                      const std::vector<std::string>& overrides, const std::vector<std::int64_t>& frames,
                      const std::string& folder, bool anew);

    /// Lines of `render --plan` of the clip.
    std::vector<std::string> plan(const std::string& timeline, const std::vector<std::string>& overrides);

    const gpu::Device& device() const { return device_; }
    int threads() const { return threads_; }
    bool interrupted() const { return interruption_.requested(); }
    /// Shown at the head of progress lines.
    void set_head(std::string head) { head_ = std::move(head); }

private:
    std::vector<std::string> call(const std::string& timeline,
                                  const std::vector<std::string>& overrides) const;
    /// Whether frames in the folder are of this job.
    bool fits(const std::string& folder, const std::string& timeline,
              const std::vector<std::string>& overrides);

    int threads_;
    std::string device_name_;
    gpu::Device device_;
    const run::Interruption& interruption_;
    run::Reporter& reporter_;
    std::string head_;
};

/// A job that is rendered several times for its times.
class TimedRun {
public:
    /// Takes up the repeats in `folder` where they are of the same job, frames, threads and device.
    TimedRun(std::string name, std::string timeline, std::vector<std::string> overrides,
             std::vector<std::int64_t> frames, std::int64_t warm_up, std::string folder,
             Renderings& renderings);

    /// Renders one repeat more. False where it was interrupted. A failure is kept in failure().
    bool add_repeat();
    const std::vector<Repeat>& repeats() const { return repeats_; }
    /// Why the last repeat failed; empty where none did.
    const std::string& failure() const { return failure_; }
    /// Of the last repeat.
    std::optional<run::Manifest> manifest() const;
    const std::string& folder() const { return folder_; }
    const std::string& name() const { return name_; }
    double mean_process_s() const;  ///< 0 before the first repeat

private:
    /// Whether the last repeat's pictures are there, whole.
    bool holds_pictures() const;
    void save() const;
    std::string timings_file() const { return folder_ + "/timings.json"; }

    std::string name_, timeline_;
    std::vector<std::string> overrides_;
    std::vector<std::int64_t> frames_;
    std::int64_t warm_up_;
    std::string folder_;
    Renderings& renderings_;
    std::string identity_;
    std::vector<Repeat> repeats_;
    std::string failure_;
};

/// Renders until every run has `wanted` repeats or has failed; repeats outermost, so that what else the
/// machine does is spread over all runs. False where it was interrupted.
bool add_repeats(std::vector<TimedRun>& runs, std::size_t wanted, Renderings& renderings,
                 run::Reporter& reporter);

/// A frame that is not judged, for what a process does once: of the clip, where that has another one.
/// `frames` ascend.
std::int64_t warm_up_frame(const std::vector<std::int64_t>& frames, const scene::Clip& clip);

}  // namespace dapple::judge
