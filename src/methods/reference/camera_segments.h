#pragma once
#include <optional>

#include "methods/reference/camera_beams.h"
#include "methods/reference/eye_connection.h"
#include "rays/ray_scene.h"
#include "scene/frame_scene.h"
#include "view/segment_layer.h"

namespace dapple::reference {

/// The camera's side of S of one layer of segments. What a segment is to hold stands for its whole pixel: the
/// mean, over the camera paths of the pixel that have a segment of the same number in the same medium, of
/// what they receive from it, over the throughput of the layer's own. Segments from the eye of a perspective
/// camera are left to an EyeConnection, all others (and those of orthographic cameras) to CameraBeams around
/// a grid of sub-pixel paths.
struct CameraSegments {
    std::optional<EyeConnection> eye;
    std::vector<CameraBeams> beams;
    std::size_t segments = 0;
    std::vector<glm::dvec3> throughput;  ///< of the layer's own

    CameraSegments(const scene::FrameScene& scene, const rays::RayScene& rays,
                   const view::SegmentLayer& layer);

    /// Most sub-pixel paths along each side of the pixel; fewer in large pictures.
    static constexpr int kMostAcross = 8;
    static int paths_across(std::size_t pixels);
    /// For estimates of memory: one on each side of the water.
    static constexpr double kSegmentsAPixel = 2;
    /// While it is made and used, for a picture whose paths have a few segments each.
    static double bytes(std::size_t pixels);
};

}  // namespace dapple::reference
