#pragma once
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "light/beam_mesh.h"
#include "scene/frame_scene.h"

namespace dapple::light {

/// A sun that falls less steeply than this (3e-5 deg) is taken to have set: its shear would have no digits
/// left.
constexpr double kLowestSun = 5e-7;

/// A rectangle of texels.
struct TexelBox {
    int first_column = 0, first_row = 0;
    int columns = 0, rows = 0;
};

/// Where the texels of a caustic map lie and how the light projects the water onto them. The map is the rest
/// plane y = 0; a water point (x, h, z) lands at ((x, z) - shear h) / (1 - inverse_height h): a sun in
/// parallel (inverse_height 0), a point or spot light centrally from its position. Texels are anchored to the
/// water's extent, which they fill whole, so they stay in place while waves and light move; a border of whole
/// texels holds what waves within their bound displace. Of several cascades each has a plan.
struct MapPlan {
    bool lit = false;         ///< false: the light does not reach the surface (a sun below the horizon)
    bool from_below = false;  ///< a point or spot light under water
    bool capped = false;      ///< water lies outside: the border was cut, to keep the map within twice the
                              ///< resolution, or the outermost cascade ends before the water does
    int cascade = 0;          ///< the innermost is 0
    int columns = 0;          ///< texels along the first vector of `texel`: x, but in the light's frame
    int rows = 0;             ///< texels along the second: z
    glm::dmat2 texel{0};      ///< m, world (x, z): from a texel to the next along columns, along rows
    /// Whole texels from `anchor` to the outer corner of texel (0, 0): a texel's place is found from the
    /// anchor, which does not move with the box of a cascade.
    glm::i64vec2 first{0};
    glm::dvec2 anchor{0, 0};    ///< m, world (x, z)
    glm::dvec2 shear{0, 0};     ///< m a m of height, in world coordinates
    double inverse_height = 0;  ///< 1/m, signed: negative for a light under water
    double height_bound = 0;    ///< m, of the depth range
    /// The texels that have light to carry, and their neighbours: the whole map, or a ring of up to four.
    std::vector<TexelBox> parts;
    /// Share of the light, of a cascade: at (column, row) outer.x outer.y - inner.x inner.y. Empty: all of
    /// it.
    struct Shares {
        std::vector<double> outer_x, outer_z, inner_x, inner_z;
    } shares;

    glm::dvec2 corner() const { return anchor + texel * glm::dvec2(first); }  ///< m, of texel (0, 0)
    double texel_area() const { return std::abs(glm::determinant(texel)); }   ///< m^2
    /// Columns and rows, of which whole numbers are corners of texels, of a point of the rest plane.
    glm::dvec2 texel_of(glm::dvec2 point) const { return glm::inverse(texel) * (point - corner()); }
    bool weighted() const { return !shares.outer_x.empty(); }
    double share(int column, int row) const;
};

/// The plan without texels: how the light projects the water onto the rest plane.
MapPlan plan_projection(const scene::FrameScene& scene, int light);

/// How far the light throws points of the surface off their rest position, m, along x and z; 0 for flat
/// water, whatever the room above.
glm::dvec2 thrown_off(const MapPlan& plan, const scene::FrameScene& scene);

/// One map over all the water. `resolution`: texels along the longer side of the extent. Needs
/// FrameScene::water.
MapPlan plan_map(const scene::FrameScene& scene, int light, double resolution);

/// Throws Error(timeline_invalid) for maps larger than any device takes, before anything is made for them.
void check_map_size(std::int64_t columns, std::int64_t rows);

/// Texels of a border that holds `thrown` m, at most half of `inner`, else `capped`.
int border_texels(double thrown, double texel, double inner, bool& capped);

/// Unit axis of the beam mesh: the flat-water direction for a sun, straight down or up for others.
glm::dvec3 mesh_axis(const scene::Light& light, bool from_below, Event event, double refractive_index);

}  // namespace dapple::light
