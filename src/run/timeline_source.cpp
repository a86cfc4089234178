#include "run/timeline_source.h"

#include <algorithm>

#include "base/hash.h"
#include "rays/ray_scene.h"
#include "render/film.h"
#include "render/settle.h"

namespace dapple::run {
namespace {

color::Grade grade(const scene::Output& output) {
    const scene::ColorDecisionList& cdl = output.cdl;
    return {output.exposure, {cdl.slope, cdl.offset, cdl.power, cdl.saturation}};
}

/// The colour config by content, since a path says nothing on another machine. The processor's id covers
/// look-up tables that the config refers to.
std::string color_identity(const color::Grader& grader) {
    const std::string& path = grader.description().config;
    const std::string config = path == "shipped" ? content_hash(color::shipped_config()) : hash_files({path});
    return content_hash(config + " " + grader.processor_id({}));
}

}  // namespace

color::ViewSettings view_settings(const scene::Output& output) {
    return {output.ocio_config, output.display, output.view, output.look};
}

TimelineSource::TimelineSource(const timeline::Timeline& timeline, gpu::Device& device)
    : timeline_(timeline),
      renderer_(device),
      grader_(view_settings(timeline.at(timeline.clip().first_frame).output)),
      fingerprint_hash_(content_hash(timeline.fingerprint())) {}

scene::FrameState TimelineSource::state(std::int64_t frame) const {
    scene::FrameState state = timeline_.at(frame);
    if (settled_) render::apply(*settled_, state.caustics);
    return state;
}

void TimelineSource::tell_settled(std::vector<render::PlanLine>& lines) const {
    if (!settled_) return;
    const auto method = std::find_if(lines.begin(), lines.end(), [](const render::PlanLine& line) {
        return line.pass.starts_with("caustics: ");
    });
    lines.insert(method == lines.end() ? method : method + 1, settled_line());
}

render::PlanLine TimelineSource::settled_line() const {
    return render::plan_line(*settled_, timeline_.at(timeline_.clip().first_frame).caustics);
}

void TimelineSource::settle(const std::optional<render::SettledCaustics>& known, std::uint64_t most_memory,
                            const std::function<bool()>& stop) {
    const scene::Clip& clip = timeline_.clip();
    if (timeline_.at(clip.first_frame).caustics.target_error == 0) return;
    settled_ = known;
    if (known) return;
    render::SettleRequest request;
    for (const std::int64_t frame : render::pilot_frames(clip)) request.pilots.push_back(timeline_.at(frame));
    const scene::Caustics& caustics = request.pilots.front().caustics;
    request.choose_footprint =
        caustics.method == "photon_splatting" && !timeline_.gives("caustics.footprint");
    request.choose_passes =
        caustics.denoise.filter != scene::DenoiseFilter::none && !timeline_.gives("caustics.denoise.passes");
    request.most_memory = most_memory;
    request.stop = stop;
    settled_ = renderer_.settle(request);
}

std::vector<render::PlanLine> TimelineSource::plan(std::int64_t frame) {
    std::vector<render::PlanLine> lines = renderer_.plan(state(frame));
    tell_settled(lines);
    return lines;
}

SourceFrame TimelineSource::render(std::int64_t frame, FrameStats& stats,
                                   const methods::Checkpoint& checkpoint) {
    const scene::FrameState state = this->state(frame);
    render::RenderedFrame rendered = renderer_.render(state, stats, checkpoint);
    tell_settled(rendered.plan);
    if (settled_) {
        stats.count("settled map_resolution", settled_->map_resolution);
        for (const render::PilotError& pilot : settled_->pilots)
            stats.count("estimated error, frame " + std::to_string(pilot.frame), pilot.error);
    }
    SourceFrame result{
        std::move(rendered.linear), {}, std::move(rendered.non_finite), std::move(rendered.plan)};
    const ScopedPass pass(stats, "grade");
    color::GradedPicture graded = grader_.apply(result.linear, grade(state.output));
    result.graded = std::move(graded.picture);
    if (result.non_finite.count == 0 && graded.non_finite > 0) result.non_finite.first = "the graded picture";
    result.non_finite.count += graded.non_finite;

    const NamedTexts common = {{"dapple:frame", std::to_string(frame)},
                               {"dapple:version", DAPPLE_VERSION},
                               {"dapple:timeline", fingerprint_hash_},
                               {"dapple:caustics", state.caustics.method},
                               {"dapple:seed", std::to_string(state.clip.seed)}};
    for (image::Image* picture : {&result.linear, &result.graded}) {
        picture->metadata.insert(picture->metadata.end(), common.begin(), common.end());
    }
    const NamedTexts view = grader_.metadata();
    result.graded.metadata.insert(result.graded.metadata.end(), view.begin(), view.end());
    return result;
}

std::size_t TimelineSource::bytes(std::int64_t frame) const {
    const scene::FrameState state = this->state(frame);
    // Writing holds the picture four times (itself, encoded, read back, decoded), when the rendering's own
    // memory is free again: its float channels and the graded picture. In double, which no size overflows.
    const double pixels = static_cast<double>(state.clip.width) * static_cast<double>(state.clip.height);
    constexpr std::size_t channels = render::Film::kOwnChannels + render::Film::kMostMethodChannels + 4;
    const double writing = std::min(pixels * 4 * channels * sizeof(float), 0x1p62);
    // What the program and its libraries, lavapipe above all, take for a picture of one pixel: 104 MB,
    // measured.
    constexpr std::size_t kProgram = 100 << 20;
    // Luminance of three frames, for the figures in time.
    const auto kept = static_cast<std::size_t>(std::min(pixels * 3 * sizeof(float), 0x1p62));
    const std::size_t settling = settled_ ? settled_->most_memory : 0;
    return kProgram + kept + std::max({renderer_.bytes(state), static_cast<std::size_t>(writing), settling});
}

image::ExrOptions TimelineSource::linear_exr() const {
    image::ExrOptions options = graded_exr();
    options.chromaticities = grader_.working_chromaticities();
    return options;
}

image::ExrOptions TimelineSource::graded_exr() const {
    image::ExrOptions options;
    options.fps_numerator = timeline_.clip().fps.numerator;
    options.fps_denominator = timeline_.clip().fps.denominator;
    return options;
}

std::string to_string(gpu::DeviceType type) {
    switch (type) {
        case gpu::DeviceType::cpu:
            return "CPU";
        case gpu::DeviceType::integrated:
            return "integrated GPU";
        case gpu::DeviceType::discrete:
            return "discrete GPU";
        case gpu::DeviceType::other:
            break;
    }
    return "other";
}

NamedTexts instruction_sets() {
    std::string processor;
    const auto add = [&](bool present, const char* name) {
        if (present) processor += (processor.empty() ? "" : " ") + std::string(name);
    };
    add(__builtin_cpu_supports("avx2") != 0, "avx2");
    add(__builtin_cpu_supports("fma") != 0, "fma");
    add(__builtin_cpu_supports("avx512f") != 0, "avx512f");
    return {{"program", "x86-64-v3, no contraction; Embree avx2"}, {"processor", processor}};
}

NamedTexts library_versions(const color::Grader& grader) {
    return {{"embree", rays::embree_version()},
            {"openexr", image::openexr_version()},
            {"ocio", grader.description().ocio_version}};
}

Job job_of(const timeline::Timeline& timeline, const gpu::Device& device, const TimelineSource& source) {
    const color::ViewDescription& view = source.grader().description();
    Job job;
    job.clip = timeline.clip();
    job.parts = {{"timeline", content_hash(timeline.fingerprint())},
                 {"input files", hash_files(timeline.input_files())},
                 {"colour config", color_identity(source.grader())},
                 {"program", program_identity()},
                 {"device type", to_string(device.info().type)}};
    if (timeline.at(job.clip.first_frame).caustics.target_error > 0) {
        std::string pilots;
        for (const std::int64_t frame : render::pilot_frames(job.clip)) pilots += std::to_string(frame) + " ";
        job.parts.emplace_back("pilot frames", pilots);
    }
    job.settled = source.settled();
    job.provenance = {{"device", device.info().name},
                      {"driver", device.info().driver},
                      {"vulkan", device.info().api_version}};
    for (const auto& [name, text] : instruction_sets())
        job.provenance.emplace_back("instructions: " + name, text);
    const NamedTexts libraries = library_versions(source.grader());
    job.provenance.insert(job.provenance.end(), libraries.begin(), libraries.end());
    const NamedTexts color = {{"ocio config", view.config},
                              {"ocio config name", view.config_name},
                              {"ocio config id", view.config_id},
                              {"display", view.display},
                              {"view", view.view},
                              {"look", view.look}};
    job.provenance.insert(job.provenance.end(), color.begin(), color.end());
    return job;
}

}  // namespace dapple::run
