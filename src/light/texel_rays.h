#pragma once
#include <array>
#include <cstddef>
#include <glm/glm.hpp>
#include <span>

#include "light/beam_mesh.h"
#include "light/map_plan.h"
#include "scene/frame_scene.h"

namespace dapple::light {

/// Rays of texels that follow one another in a row of a caustic map: an array a number, of which the compiler
/// makes eight at once.
struct TexelRays {
    static constexpr std::size_t kMost = 64;  ///< so few that all of them stay in the fastest cache
    using Row = std::array<float, kMost>;
    struct Vectors {
        Row x, y, z;
        glm::vec3 at(std::size_t k) const { return {x[k], y[k], z[k]}; }
    };
    Vectors origin, slope;  ///< as of BeamMesh
    Row start;              ///< m, as of BeamMesh
    Row flux;               ///< m^2 (sun) or sr, after Fresnel; negative: no ray
    Row lost;               ///< what it would carry, had the mesh room for its direction
};

/// Refracts or reflects the light at the texels of a caustic map.
class TexelTracer {
public:
    /// For the rays of `mesh`, of which light, event and axis stand.
    TexelTracer(const scene::FrameScene& scene, const MapPlan& plan, const BeamMesh& mesh);

    /// `texels`: up to TexelRays::kMost, height above the rest plane (m) and normal, which is 0 where there
    /// is no water; the first lies at (column, row). Rays beyond them mean nothing.
    void trace(std::span<const glm::vec4> texels, int column, int row, TexelRays& rays) const;

private:
    using Row = TexelRays::Row;
    using Vectors = TexelRays::Vectors;
    /// What the map shows at its texels and the light that meets them.
    struct Met {
        Vectors point, incident, normal;  // m, relative to the frame's origin; unit, unit
        Row power;                        // m^2 or sr, of the light through the texel
        std::array<int, TexelRays::kMost> water;
    };
    void find_points(std::span<const glm::vec4> texels, int column, int row, Met& met) const;
    void find_light(int column, int row, Met& met) const;
    template <bool kReflection>
    void leave(const Met& met, TexelRays& rays) const;
    /// m, map coordinates.
    glm::vec2 center(int column, int row) const {
        return anchor_ + column_step_ * (static_cast<float>(column + first_column_) + 0.5f) +
               row_step_ * (static_cast<float>(row + first_row_) + 0.5f);
    }

    glm::vec2 anchor_;                  // m, map coordinates that texels are counted from
    glm::vec2 column_step_, row_step_;  // m
    int first_column_, first_row_;      // of the map, from the anchor
    glm::vec2 shear_;                   // as in layout::CausticMapPush
    float inverse_height_;
    float rest_height_;     // m, of the rest plane, relative to the frame's origin
    glm::vec3 light_;       // sun: unit direction of travel; else position, m, relative to the frame's origin
    glm::vec3 light_axis_;  // unit; of an area light its normal
    float cos_outer_, cos_inner_;  // of a spot: where its light has fallen to nothing, and where it is full
    glm::vec3 axis_;               // of the mesh
    float eta_;                    // index of the medium that the light comes through over that of the other
    bool sun_, spot_, emitter_, reflection_;
};

}  // namespace dapple::light
