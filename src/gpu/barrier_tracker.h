#pragma once
// Private to gpu/*.cpp.
#include <optional>
#include <unordered_map>
#include <vector>

#include "gpu/device_state.h"

namespace dapple::gpu {

/// How a pass touches one buffer or image.
struct Use {
    const void* resource;  // the address of its State names it
    vk::PipelineStageFlags2 stages;
    vk::AccessFlags2 reads;
    vk::AccessFlags2 writes;
};

/// What passes so far did to a resource.
struct History {
    vk::PipelineStageFlags2 write_stages;
    vk::AccessFlags2 writes;
    vk::PipelineStageFlags2 read_stages;  // since the last write
};

/// Orders a pass after the passes whose results it reads or overwrites. One global memory barrier for all
/// hazards of a pass: buffers and images keep their layout and queue, and a finer barrier would gain nothing
/// in order of one queue.
class BarrierTracker {
public:
    /// The barrier that has to come before a pass with these uses, if any.
    std::optional<vk::MemoryBarrier2> before(const std::vector<Use>& uses) {
        vk::MemoryBarrier2 barrier;
        for (const Use& use : uses) {
            const History& history = histories_[use.resource];
            const bool after_write = static_cast<bool>(history.writes);
            const bool after_read = use.writes && history.read_stages;
            if (!after_write && !after_read) continue;
            barrier.srcStageMask |= history.write_stages;
            barrier.srcAccessMask |= history.writes;
            if (use.writes) barrier.srcStageMask |= history.read_stages;
            barrier.dstStageMask |= use.stages;
            barrier.dstAccessMask |= use.reads | use.writes;
        }
        for (const Use& use : uses) {
            History& history = histories_[use.resource];
            if (use.writes)
                history = {use.stages, use.writes, {}};
            else
                history.read_stages |= use.stages;
        }
        if (!barrier.srcStageMask) return std::nullopt;
        return barrier;
    }

private:
    std::unordered_map<const void*, History> histories_;
};

}  // namespace dapple::gpu
