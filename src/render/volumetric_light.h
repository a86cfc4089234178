#pragma once
#include <glm/glm.hpp>
#include <span>

#include "media/media.h"
#include "rays/ray_scene.h"
#include "scene/frame_scene.h"
#include "view/segment_layer.h"

namespace dapple::render {

/// Points of a segment that are tested for shadow of one light; samples of a pixel take points that lie
/// between each other's.
constexpr int kShadowPoints = 8;

/// Adds to `radiance`, an entry a segment, what it scatters once towards its near end of light that reaches
/// it without a specular event [W/m^2/sr]: the integral over the segment of sigma_s p L V T_light T_camera,
/// from the lights on its side of the water. A sun is sampled in one direction a layer, as for surfaces.
///
/// All but shadow V is integrated by Gauss' rule between the places of the density profile, for lamps in the
/// angle seen from them (Kulla and Fajardo 2012), in which the peak of 1/r^2 is flat; so too T_light, where
/// no medium is a grid; else its optical depth is the sun's by SunDepths, or by WayDepths of lamps and
/// where grids are too large for that. Shadow is tested at kShadowPoints points of equal shares of the light.
/// A spot's picture is the mean over each node's stretch of the segment. They are shifted from pixel to
/// pixel, the same in all frames. A lamp that a segment passes nearer than the pixel is wide shines as its
/// mean over the pixel.
void add_volumetric_direct_light(const scene::FrameScene& scene, const media::Media& media,
                                 const rays::RayScene& rays, const view::SegmentLayer& segments,
                                 std::span<glm::vec3> radiance);

}  // namespace dapple::render
