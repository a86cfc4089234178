#include "accuracy/scatter_pictures.h"

#include <cstdio>
#include <filesystem>
#include <glm/glm.hpp>
#include <utility>

#include "base/error.h"
#include "image/exr.h"
#include "methods/reference/reference.h"
#include "rays/ray_scene.h"
#include "view/camera_paths.h"

namespace dapple::test {

image::Image scattered(const scene::FrameScene& scene, methods::CausticMethod& method, gpu::Device& device,
                       FrameStats& stats, const std::string& checkpoint) {
    const scene::Clip& clip = scene.state.clip;
    const rays::RayScene rays(scene);
    methods::FrameContext context{scene, rays, device, stats, {}, {}};
    context.checkpoint.file = checkpoint;
    for (int light = 0; light < static_cast<int>(scene.state.lights.size()); ++light)
        for (const auto event : {light::Event::transmission, light::Event::reflection})
            context.chains.push_back({light, event});
    method.begin(context);
    image::Image picture;
    picture.width = clip.width;
    picture.height = clip.height;
    for (const char* name : {"S.R", "S.G", "S.B", "direct"}) picture.add(name);
    picture.channels[3].values.assign(picture.pixels(), 1);
    for (int sample = 0; sample < clip.samples; ++sample) {
        view::LayerCounts counts;
        view::SegmentLayer segments;
        view::trace_layer(scene, rays, {.sample = sample}, counts, &segments);
        std::vector<glm::vec3> radiance(segments.segments(), glm::vec3(0));
        method.in_scatter(context, segments, radiance);
        for (std::size_t pixel = 0; pixel < picture.pixels(); ++pixel)
            for (std::size_t i = segments.first[pixel]; i < segments.first[pixel + 1]; ++i) {
                for (int c = 0; c < 3; ++c)
                    picture.channels[static_cast<std::size_t>(c)].values[pixel] +=
                        segments.throughput[i][c] * radiance[i][c] / static_cast<float>(clip.samples);
                if (!segments.primary[i]) picture.channels[3].values[pixel] = 0;
            }
        if (sample > 0) continue;
        for (methods::DataLayer& data : method.in_scatter_data())
            picture.add(data.name).values = std::move(data.values);
    }
    return picture;
}

const std::vector<float>& channel(const image::Image& image, const std::string& name) {
    const image::Channel* found = image.find(name);
    if (!found) throw Error(ExitCode::input_unreadable, "no channel " + name);
    return found->values;
}

std::string by_reference(const std::string& standard_error, int most_rays) {
    return "caustics={method: reference, standard_error: " + standard_error +
           ", most_rays: " + std::to_string(most_rays) + "}";
}

image::Image kept_reference(const scene::FrameScene& scene, const std::string& folder, gpu::Device& device) {
    const int frame = static_cast<int>(scene.state.frame);
    char name[32];
    std::snprintf(name, sizeof name, "/reference.%04d", frame);
    const std::string file = folder + name + ".exr", partial = folder + name + ".partial";
    if (!std::filesystem::exists(file)) {
        methods::Reference method;
        FrameStats stats;
        const double begin = cpu_seconds();
        const image::Image made = scattered(scene, method, device, stats, partial);
        std::printf("reference, frame %d: standard error %.4f, %.3g rays, %.0f CPU-s\n", frame,
                    stats.counted("reference volume standard error"), stats.counted("reference volume rays"),
                    cpu_seconds() - begin);
        std::fflush(stdout);
        image::write_exr_verified(file, made);
        std::filesystem::remove(partial);
    }
    image::Image kept = image::read_exr(file);
    if (kept.width != scene.state.clip.width || kept.height != scene.state.clip.height)
        throw Error(ExitCode::input_unreadable, file + ": its size is not the clip's");
    return kept;
}

}  // namespace dapple::test
