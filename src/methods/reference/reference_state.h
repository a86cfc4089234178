#pragma once
#include <algorithm>
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
    double saved_at = 0;                     ///< s
    std::vector<DataLayer> in_scatter_data;  ///< of the last layer of segments

    /// Seconds between two writes of the checkpoint.
    static constexpr double kSavePeriod = 20;

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
