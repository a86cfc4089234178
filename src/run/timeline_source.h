#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "color/grader.h"
#include "gpu/device.h"
#include "image/exr.h"
#include "render/frame_renderer.h"
#include "render/settled_caustics.h"
#include "run/frame_source.h"
#include "run/job.h"
#include "timeline/timeline.h"

namespace dapple::run {

/// The frames of a timeline: its state at a frame, rendered on the device and graded. Throws on construction
/// where the OCIO config, display, view or look cannot be had (color/grader.h).
class TimelineSource : public FrameSource {
public:
    TimelineSource(const timeline::Timeline& timeline, gpu::Device& device);

    /// What render() would do and why; builds the scene, casts no light.
    std::vector<render::PlanLine> plan(std::int64_t frame);
    SourceFrame render(std::int64_t frame, FrameStats& stats, const methods::Checkpoint& checkpoint) override;
    std::size_t bytes(std::int64_t frame) const override;
    /// Settings for the timeline's caustics.target_error, which all frames have from then on; found by its
    /// pilot frames (render/settle.h) unless they are `known`. Does nothing where there is no target_error.
    void settle(const std::optional<render::SettledCaustics>& known, std::uint64_t most_memory,
                const std::function<bool()>& stop);
    const std::optional<render::SettledCaustics>& settled() const { return settled_; }
    /// What plans say of it; something must be settled.
    render::PlanLine settled_line() const;
    /// See FrameRenderer::limit_memory.
    void limit_memory(std::size_t most_bytes) { renderer_.limit_memory(most_bytes); }

    image::ExrOptions linear_exr() const;
    image::ExrOptions graded_exr() const;
    const color::Grader& grader() const { return grader_; }

private:
    scene::FrameState state(std::int64_t frame) const;
    void tell_settled(std::vector<render::PlanLine>& lines) const;

    const timeline::Timeline& timeline_;
    render::FrameRenderer renderer_;
    color::Grader grader_;
    std::string fingerprint_hash_;
    std::optional<render::SettledCaustics> settled_;
};

/// Where a timeline's pictures are looked at.
color::ViewSettings view_settings(const scene::Output& output);

/// What decides the pictures of the timeline, and how they are made. Reads the input files to hash their
/// contents: Error(input_unreadable) where one is missing.
Job job_of(const timeline::Timeline& timeline, const gpu::Device& device, const TimelineSource& source);

/// "CPU", "integrated GPU", ...
std::string to_string(gpu::DeviceType type);

/// Instruction sets that decide bits: what the program is compiled for, and what this processor has.
NamedTexts instruction_sets();

/// Libraries that have a part in the pictures, and their versions.
NamedTexts library_versions(const color::Grader& grader);

}  // namespace dapple::run
