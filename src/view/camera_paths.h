#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <vector>

#include "rays/ray_scene.h"
#include "scene/frame_scene.h"
#include "view/receiver_layer.h"
#include "view/segment_layer.h"

namespace dapple::view {

/// Specular events after which a path is given up and counted.
constexpr int kLongestChain = 8;

/// Choices at Fresnel splits that a path has.
constexpr int kBranches = 4;
/// Share of a pixel's radiance (mean of the channels) of a side of a split that has a branch of its own; a
/// face of glass reflects 0.04 upright.
constexpr double kWorthFollowing = 0.05;

/// Whether the camera is under water in this frame: below the first crossing of the water mesh above it;
/// where the mesh does not cover it, below the rest plane of open water. A camera at the surface (nearer to
/// it than 2^-20 of its distance from FrameScene::origin plus 1 m) is under it. An orthographic camera is
/// looked at in the middle of its picture; its paths start in the water or the air each by itself.
bool camera_in_water(const scene::FrameScene& scene);

/// Follows one camera path a pixel through water, glass and mirrors to its receiver (at most kLongestChain
/// specular events). A `branch` is a choice at Fresnel splits. At the first split branches 0 and 2 take the
/// refracted ray (weight T), 1 and 3 the reflected one (weight F). At the first later split whose weaker side
/// has at least kWorthFollowing of the pixel, 0 and 1 take the stronger side, 2 and 3 the weaker. Pixels
/// that do not split so are in branch 0 only, or in 0 and 1 (in others their flags and their throughput are
/// 0). At total reflection the whole weight goes on. Other splits follow the stronger side, and what is
/// dropped is counted. The sample is Camera::sample_offset(sample, samples).
///
/// Throughput carries, from the pixel outwards, Fresnel's share, (n_from / n_to)^2 at each crossing (radiance
/// scales by n^2), exp(-optical depth) of the media on each way and the colour of each mirror. Open water
/// goes on outside its rectangle as the flat plane y = 0. Paths that leave the scene in the air see the
/// environment; those that leave it in the water, or meet more than kLongestChain events, end black (flags
/// and throughput 0). Within a body of glass there is its absorption, and neither water nor another medium;
/// whether air or water lies outside is decided where a path leaves it. A camera may stand in glass.
/// Footprints are carried through refraction, reflection and the curvature of the interpolated normals (Igehy
/// 1999); they are cut at 64 times the width of the beam, and at the length of the path (and 64 pixels of an
/// orthographic picture).
struct LayerRequest {
    int sample = 0;
    int branch = 0;
    /// Where in the pixel the path starts, [0, 1)^2, in place of the sample's offset.
    std::optional<glm::dvec2> offset = {};
    /// Part of the picture to trace, which the layer then has the size of.
    struct Window {
        glm::ivec2 corner{0, 0};  ///< pixels
        glm::ivec2 size{1, 1};    ///< pixels
    };
    std::optional<Window> window = {};
    /// Pixels to trace: those with any of these bits of PathSplits in `splits`, a layer's. Empty: all.
    std::uint8_t only = 0;
    std::span<const std::uint8_t> splits = {};
};
struct LayerCounts {
    std::size_t paths = 0;         ///< pixels that were traced
    std::size_t split_pixels = 0;  ///< pixels whose path splits: branch 1 is worth tracing where this is > 0
    /// Pixels whose path splits again: branch + 2 is worth tracing where this is > 0.
    std::size_t split_again_pixels = 0;
    std::size_t dropped_splits = 0;  ///< later splits of which only one side is followed in any branch
    double dropped_weight = 0;  ///< sum of the shares of pixels' radiance so dropped (mean over channels)
    std::size_t longest_chain_hits = 0;
};

/// The result has the same bits on any number of threads. `counts` are those of this layer. `segments`, where
/// given, becomes the pieces of the paths that lie in media that scatter.
ReceiverLayer trace_layer(const scene::FrameScene& scene, const rays::RayScene& rays, LayerRequest request,
                          LayerCounts& counts, SegmentLayer* segments = nullptr);

}  // namespace dapple::view
