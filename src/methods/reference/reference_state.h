#pragma once
#include <algorithm>
#include <cmath>
#include <string>

#include "base/error.h"
#include "methods/reference/light_tracer.h"
#include "methods/reference/progress_file.h"
#include "methods/reference/receiver_charts.h"
#include "methods/reference/reference.h"

namespace dapple::methods {

/// What the reference knows of a frame.
struct Reference::State {
    State(FrameContext& context, reference::ReferenceOptions options)
        : charts(context.scene), tracer(context.scene, context.rays, context.chains, charts, options) {}

    reference::ReceiverCharts charts;
    reference::LightTracer tracer;
    std::string job;
    reference::Progress progress;            ///< of all layers of the frame
    reference::EnergyAccount account;        ///< of all passes of E in this call of the program
    double passes = 0;                       ///< in it
    double saved_at = 0;                     ///< s
    std::vector<DataLayer> in_scatter_data;  ///< of the last layer of segments
    double scattered = 0;                    ///< S summed up over the pixels of all layers, and channels
    double scattered_variance = 0;           ///< of it

    /// Seconds between two writes of the checkpoint.
    static constexpr double kSavePeriod = 20;

    void add_account(const reference::EnergyAccount& pass) {
        account.add(pass);
        passes += 1;
    }
    /// A layer's sum of S and its variance. Channels' light is that of the same rays, so that their errors
    /// add; layers are traced by rays of their own.
    void add_scattered(const glm::dvec3& sum, const glm::dvec3& variance) {
        const glm::dvec3 error = glm::sqrt(variance);
        scattered += sum.x + sum.y + sum.z;
        const double all = error.x + error.y + error.z;
        scattered_variance += all * all;
    }
    /// Standard error of that sum, a share of it.
    double scattered_error() const { return scattered > 0 ? std::sqrt(scattered_variance) / scattered : 0; }
    /// Light that is dropped, W, mean over the passes.
    void count_losses(FrameStats& stats) const {
        const auto set = [&](const char* name, double sum) {
            if (sum > 0) stats.count(name, sum / passes - stats.counted(name));
        };
        set("reference lost to weak branches, W", account.weak);
        set("reference lost to long chains, W", account.long_chains);
        set("reference lost at edges of glass, W", account.astray);
    }
    void save(const Checkpoint& checkpoint) {
        if (!checkpoint.file.empty()) reference::write_progress(checkpoint.file, job, progress);
        saved_at = wall_seconds();
    }
    void save_at_times(const Checkpoint& checkpoint) {
        if (wall_seconds() - saved_at > kSavePeriod) save(checkpoint);
    }
    [[noreturn]] void interrupt(const Checkpoint& checkpoint) {
        save(checkpoint);
        throw Error(ExitCode::interrupted, "interrupted");
    }
};

/// Raises a count to a value.
inline void count_most(FrameStats& stats, const char* name, double value) {
    stats.count(name, std::max(0.0, value - stats.counted(name)));
}

}  // namespace dapple::methods
