#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

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
                    0};    ///< unit, the mesh's mean direction of travel; dot(direction, axis) > 0.1 for all
    int rows = 0;          ///< along z
    int columns = 0;       ///< along x
    glm::vec2 cell{0, 0};  ///< m along x and z: the rays' spacing where the light crosses the rest plane
    std::vector<glm::vec3> origin;  ///< m, relative to FrameScene::origin
    std::vector<glm::vec3> slope;   ///< m a m of depth
    std::vector<float> start;       ///< m, depth along the axis where the ray leaves the water surface
    /// Flux of the vertex's cell of the caustic map, after Fresnel, of a light of unit irradiance (sun: m^2)
    /// or unit intensity (point, spot: sr); times the light's colour it is W.
    std::vector<float> flux;
    /// Share of the light at the vertex that this mesh carries, in [0, 1], the others of its cascades the
    /// rest: over cascades the tents of `weight` on their lattices sum to one. `flux` has it already; what
    /// needs the density of rays alone does not look at it. Empty: 1 everywhere.
    std::vector<float> weight;
    /// Mean of a spot's picture over the vertex's cell, a channel, which times `flux` is what the vertex
    /// carries; empty without a picture.
    std::vector<glm::vec3> tint;
    /// 1 where there is a ray; differences between neighbours mean something only between two such. Elsewhere
    /// origin and slope are finite and flux is 0. A shadowed ray is one, of flux 0.
    std::vector<std::uint8_t> valid;
    /// Flux that met the water but fits no mesh (directions outside the cone about the axis), same unit as
    /// `flux`, of the light's own mean colour where it has a picture.
    double lost_flux = 0;
    std::size_t vertices() const { return origin.size(); }
};

}  // namespace dapple::light
