#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "base/large_vector.h"
#include "scene/frame_state.h"

namespace dapple::light {

enum class Event { transmission, reflection };

constexpr int kWater = -1;  ///< of a chain: its event happens at the water

/// One kind of light path: from a light (index into FrameState::lights) through a first specular event, at
/// the water or at an object of glass (index into FrameState::objects).
struct Chain {
    int light = 0;
    Event event = Event::transmission;
    int object = kWater;
};

/// "sun > water:T", "sun > ball:R": light and object by name, or as "lights[2]" where they have none.
std::string chain_name(const scene::FrameState& state, Chain chain);

/// Light rays just after one chain of events from one light: a grid whose vertices are rays ("photons") and
/// whose cells are caustic beams. A ray is a point on the plane through the frame's origin perpendicular to
/// `axis`, and a slope: point(depth) = origin + depth * slope, with dot(slope, axis) = 1, so that landing
/// points are linear in depth. Row-major grids; a vertex that carries nothing has flux 0 and stays in its
/// place.
struct BeamMesh {
    std::string name;  ///< for plans and stats: "sun > water:T"
    int light = 0;     ///< index into FrameState::lights
    Event event = Event::transmission;
    int cascade = 0;          ///< of the caustic map's, the innermost is 0
    bool from_below = false;  ///< the light is under water: T lands in the air, R in the water
    /// Whether the rays travel through the water after the event.
    bool in_water() const { return from_below == (event == Event::reflection); }
    glm::dvec3 axis{0, -1,
                    0};  ///< unit, the mesh's mean direction of travel; dot(direction, axis) > 0.1 for all
    int rows = 0;        ///< along z, but in the light's frame
    int columns = 0;     ///< along x, but there
    /// m along x and z, where the light crosses the rest plane: from a ray to the next along columns, along
    /// rows.
    glm::mat2 texel{0};
    LargeVector<glm::vec3> origin;  ///< m, relative to FrameScene::origin
    LargeVector<glm::vec3> slope;   ///< m a m of depth
    LargeVector<float> start;       ///< m, depth along the axis where the ray leaves the water surface
    /// Flux of the vertex's cell of the caustic map, after Fresnel, of a light of unit irradiance (sun: m^2)
    /// or unit intensity (point, spot: sr); times the light's colour it is W.
    LargeVector<float> flux;
    /// Share of the light at the vertex that this mesh carries, in [0, 1], the others of its cascades the
    /// rest: over cascades the tents of `weight` on their lattices sum to one. `flux` has it already; what
    /// needs the density of rays alone does not look at it. Empty: 1 everywhere.
    LargeVector<float> weight;
    /// Mean of a spot's picture over the vertex's cell, a channel, which times `flux` is what the vertex
    /// carries; empty without a picture.
    LargeVector<glm::vec3> tint;
    /// 1 where there is a ray, kShadowed where an object keeps the light off it, flux being 0; differences
    /// between neighbours mean something between any two such. 0 elsewhere: origin and slope are finite and
    /// flux is 0.
    LargeVector<std::uint8_t> valid;
    /// m, relative to FrameScene::origin: where rays that a mirror has sent on left the water. Theirs start
    /// at the mirror, and `tint` has what is left of the light there. Empty: the rays start on the water.
    std::vector<glm::vec3> water_point;
    bool mirrored() const { return !water_point.empty(); }
    /// Flux that met the water but fits no mesh (directions outside the cone about the axis), same unit as
    /// `flux`, of the light's own mean colour where it has a picture.
    double lost_flux = 0;
    static constexpr std::uint8_t kShadowed = 2;
    std::size_t vertices() const { return origin.size(); }
    /// Whether the light is on the ray, though this mesh may carry none of it there: another one of the
    /// cascades does.
    bool lit(std::size_t i) const {
        return flux[i] > 0 || (!weight.empty() && weight[i] == 0 && valid[i] == 1);
    }
    /// m, from a ray to its farther neighbour on the rest plane.
    float longest_step() const { return glm::max(glm::length(texel[0]), glm::length(texel[1])); }
};

}  // namespace dapple::light
