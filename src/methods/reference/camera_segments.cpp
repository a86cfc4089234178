#include "methods/reference/camera_segments.h"

#include <algorithm>
#include <cmath>

#include "view/camera.h"
#include "view/camera_medium.h"
#include "view/camera_paths.h"
#include "view/segment_recorder.h"

namespace dapple::reference {
namespace {

constexpr double kMostBeams = 0x1p20;

/// Tells segments that start at the eye.
struct EyeTest {
    bool perspective;
    glm::dvec3 eye;
    double margin;  ///< m: paths of an eye at the surface start a little below it
    bool in_water;

    explicit EyeTest(const scene::FrameScene& scene)
        : perspective(scene.state.camera.projection == scene::Projection::perspective),
          eye(scene.state.camera.position - scene.origin),
          margin(8 * view::surface_margin(eye)),
          in_water(perspective && view::camera_medium(scene).in_water) {}

    bool operator()(const view::SegmentLayer& layer, std::size_t pixel, std::size_t segment) const {
        return perspective && segment == layer.first[pixel] && (layer.in_water[segment] != 0) == in_water &&
               length(glm::dvec3(layer.origin[segment]) - eye) <= margin;
    }
};

glm::dvec3 quotient(const glm::dvec3& a, const glm::dvec3& b) {
    glm::dvec3 result(0);
    for (int channel = 0; channel < 3; ++channel)
        if (b[channel] > 0) result[channel] = a[channel] / b[channel];
    return result;
}

CameraBeam beam_of(const view::SegmentLayer& layer, std::size_t i) {
    CameraBeam beam;
    beam.origin = layer.origin[i];
    beam.direction = layer.direction[i];
    beam.u_origin = layer.spread_u_origin[i];
    beam.u_direction = layer.spread_u_direction[i];
    beam.v_origin = layer.spread_v_origin[i];
    beam.v_direction = layer.spread_v_direction[i];
    beam.length = layer.length[i];
    beam.in_water = layer.in_water[i];
    return beam;
}

}  // namespace

int CameraSegments::paths_across(std::size_t pixels) {
    const double fitting = std::sqrt(kMostBeams / static_cast<double>(std::max<std::size_t>(1, pixels)));
    return std::clamp(static_cast<int>(fitting), 2, kMostAcross);
}

double CameraSegments::bytes(std::size_t pixels) {
    // Vectors grow by doubling; a path behind the water has one segment in it, sometimes two.
    const double beams = static_cast<double>(pixels) * paths_across(pixels) * paths_across(pixels);
    // One layer of sub-pixel paths: pieces as they are recorded, and as they are kept (89 B), receivers (100
    // B).
    constexpr double kSubPath = kSegmentsAPixel * (2 * sizeof(view::PathPiece) + 89) + 100;
    return CameraBeams::kMostBytes + beams * 3 * sizeof(CameraBeam) +
           static_cast<double>(pixels) *
               (kSubPath + sizeof(EyeConnection::Target) + kSegmentsAPixel * sizeof(glm::dvec3));
}

CameraSegments::CameraSegments(const scene::FrameScene& scene, const rays::RayScene& rays,
                               const view::SegmentLayer& layer)
    : segments(layer.segments()), throughput(layer.throughput.begin(), layer.throughput.end()) {
    const EyeTest from_eye(scene);
    const std::size_t pixels = layer.first.size() - 1;
    std::vector<std::uint8_t> straight(segments, 0);
    bool simple = true;  // one segment from the eye in every pixel: no need to ask the paths beside
    for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
        for (std::size_t i = layer.first[pixel]; i < layer.first[pixel + 1]; ++i)
            straight[i] = from_eye(layer, pixel, i) ? 1 : 0;
        simple =
            simple && layer.first[pixel + 1] == layer.first[pixel] + 1 && straight[layer.first[pixel]] != 0;
    }
    const int across = simple ? 1 : paths_across(pixels);
    std::vector<std::uint32_t> alike(segments, simple ? 1 : 0);
    std::vector<CameraBeam> found;
    const glm::dvec2 size(1.0 / across);
    for (int k = 0; !simple && k < across * across; ++k) {
        view::LayerRequest request{layer.sample, layer.branch};
        request.offset = size * (glm::dvec2(k % across, k / across) + 0.5);
        view::LayerCounts ignored;
        view::SegmentLayer sub;
        view::trace_layer(scene, rays, request, ignored, &sub);
        for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
            const std::size_t count = std::min(layer.first[pixel + 1] - layer.first[pixel],
                                               sub.first[pixel + 1] - sub.first[pixel]);
            for (std::size_t number = 0; number < count; ++number) {
                const std::size_t own = layer.first[pixel] + number, other = sub.first[pixel] + number;
                if (layer.in_water[own] != sub.in_water[other] ||
                    (straight[own] != 0) != from_eye(sub, pixel, other))
                    continue;
                ++alike[own];
                if (straight[own] != 0) continue;
                CameraBeam beam = beam_of(sub, other);
                beam.segment = static_cast<std::uint32_t>(own);
                beam.factor =
                    glm::vec3(quotient(glm::dvec3(sub.throughput[other]), glm::dvec3(layer.throughput[own])) /
                              (size.x * size.y));
                found.push_back(beam);
            }
        }
    }
    for (CameraBeam& beam : found) beam.factor /= static_cast<float>(alike[beam.segment]);
    beams = CameraBeams::by_width(std::move(found), 0.5 * size);

    eye.emplace(scene, from_eye.in_water);
    for (std::size_t pixel = 0; pixel < pixels && from_eye.perspective; ++pixel) {
        const std::size_t own = layer.first[pixel];
        if (own == layer.first[pixel + 1] || straight[own] == 0 || alike[own] == 0) continue;
        const double share = static_cast<double>(alike[own]) / (across * across);
        eye->targets[pixel] = {static_cast<std::uint32_t>(own),
                               quotient(glm::dvec3(1 / share), glm::dvec3(layer.throughput[own]))};
    }
    eye->find_any();
}

}  // namespace dapple::reference
