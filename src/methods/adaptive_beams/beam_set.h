#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace dapple::methods::adaptive_beams {

/// Caustic beams of one light (a sun: one direction of its disc) on one straight leg of one chain of specular
/// events, about one axis. Mesh space has the orthonormal right-handed axes a, b and `axis` and its zero at
/// FrameScene::origin; `depth` runs along the axis. A vertex is a ray, which passes
/// (a + depth slope_a, b + depth slope_b, depth); a triangle is a beam. Beams share their vertices, so that
/// there is no crack between them.
struct BeamSet {
    struct Vertex {
        float a, b;              ///< m, where the ray passes (or would pass) the plane depth = 0
        float slope_a, slope_b;  ///< m a m of depth
        float start;             ///< m, depth at which the leg begins: the last specular surface
        float end;  ///< m, depth at which it ends: the next surface, or where it is cut; >= start
    };

    std::string name;               ///< for plans and stats: "sun > water:T", "sun > ball:TT > water:T"
    int light = 0;                  ///< index into FrameState::lights
    bool in_water = false;          ///< the medium that the leg is in
    glm::dmat3 world_from_mesh{1};  ///< columns: a, b, axis
    std::vector<Vertex> vertices;
    std::vector<glm::uvec3> triangles;  ///< into `vertices`; none without flux
    /// W a channel of each triangle where the leg begins: the light's colour, Fresnel, and what the way
    /// before absorbed are in it. Never negative.
    std::vector<glm::vec3> flux;
    /// Object that the three rays of each triangle end on, index into FrameState::objects; negative: none.
    std::vector<int> ends_on;
};

}  // namespace dapple::methods::adaptive_beams
