#pragma once
#include <glm/glm.hpp>

#include "light/beam_mesh.h"
#include "scene/frame_scene.h"

namespace dapple::light {

/// A sun that falls less steeply than this (3e-5 deg) is taken to have set: its shear would have no digits
/// left.
constexpr double kLowestSun = 5e-7;

/// Where the texels of a caustic map lie and how the light projects the water onto them. The map is the rest
/// plane y = 0; a water point (x, h, z) lands at ((x, z) - shear h) / (1 - inverse_height h): a sun in
/// parallel (inverse_height 0), a point or spot light centrally from its position. Texels are anchored to the
/// water's extent, which they fill whole, so they stay in place while waves and light move; a border of whole
/// texels holds what waves within their bound displace.
struct MapPlan {
    bool lit = false;           ///< false: the light does not reach the surface (a sun below the horizon)
    bool from_below = false;    ///< a point or spot light under water
    bool capped = false;        ///< the border was cut, to keep the map within twice the resolution
    int columns = 0;            ///< texels along x
    int rows = 0;               ///< texels along z
    glm::dvec2 corner{0, 0};    ///< m, world (x, z) of the outer corner of texel (0, 0)
    glm::dvec2 texel{0, 0};     ///< m
    glm::dvec2 shear{0, 0};     ///< m a m of height, in world coordinates
    double inverse_height = 0;  ///< 1/m, signed: negative for a light under water
    double height_bound = 0;    ///< m, of the depth range
};

/// `resolution`: texels along the longer side of the extent. Needs FrameScene::water.
MapPlan plan_map(const scene::FrameScene& scene, int light, int resolution);

/// Unit axis of the beam mesh: the flat-water direction for a sun, straight down or up for others.
glm::dvec3 mesh_axis(const scene::Light& light, bool from_below, Event event, double refractive_index);

}  // namespace dapple::light
