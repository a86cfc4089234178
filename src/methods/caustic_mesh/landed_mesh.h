#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <span>
#include <vector>

#include "light/beam_mesh.h"
#include "light/landing.h"
#include "light/way_transmittance.h"
#include "media/media.h"
#include "methods/caustic_mesh/mirrored_disc.h"
#include "rays/ray_scene.h"
#include "scene/frame_scene.h"

namespace dapple::methods::caustic_mesh {

/// A ray at a corner of a cell, and where it lands.
struct MeshRay {
    glm::vec3 origin{0}, slope{0};  ///< as in light::BeamMesh
    float start = 0;                ///< m
    float flux = 0;                 ///< of a whole cell of the map, in the mesh's unit
    glm::vec3 tint{1};
    /// m along the mesh's axis; infinite where nothing is hit. Means something where there is flux.
    float depth = std::numeric_limits<float>::infinity();
    glm::vec3 normal{0, 1, 0};  ///< unit, against the ray
    /// Area on the plane that it landed on of a cell with it as its middle, m^2; 0: not known.
    float area = 0;
    DiscImage disc;  ///< of the sun, by the way from where the ray starts

    bool landed() const { return flux > 0 && depth < std::numeric_limits<float>::infinity(); }
    glm::vec3 surface_point() const { return origin + start * slope; }
    glm::vec3 landing() const { return origin + depth * slope; }
    /// Depth at which it meets the plane; below the surface that it leaves or not.
    float depth_on(glm::vec3 point, glm::vec3 plane_normal) const {
        return glm::dot(plane_normal, point - origin) / glm::dot(plane_normal, slope);
    }
};

/// Whether what lights receivers about one of two landing points lights those about the other.
bool same_face(const MeshRay& a, const MeshRay& b);

/// The rays of a beam mesh with what their cells need to know of them.
class LandedMesh {
public:
    LandedMesh(const scene::FrameScene& scene, const media::Media& media, const light::BeamMesh& mesh,
               const light::Landings& landings, const rays::RayScene& rays);

    const light::BeamMesh& mesh() const { return mesh_; }
    std::size_t rows() const { return rows_; }
    std::size_t columns() const { return columns_; }
    MeshRay ray(std::size_t i) const;
    /// Whether a ray lies within kMostRings of where neighbours land on different faces.
    bool near_edge(std::size_t i) const { return near_edge_[i] != 0; }
    static constexpr std::size_t kMostRings = 4;
    /// Whether two rays leave one sheet of the water, with nothing between them that a crest hides.
    bool connected(const MeshRay& a, const MeshRay& b) const;
    /// A ray beside another, parallel to it, so many columns and rows of the map away; without flux.
    MeshRay beside(const MeshRay& ray, float columns, float rows) const;
    /// What a unit of a ray's flux is where the ray is at `depth`, W, a channel.
    glm::vec3 power(const MeshRay& ray, float depth) const;
    /// Traces rays of its own to where they land.
    void land(std::span<MeshRay> rays) const;
    /// Whether objects may stand between the light and the water.
    bool shadowed() const { return shadowed_; }
    /// 1 for those of the rays whose points on the water an object hides from the light.
    std::vector<std::uint8_t> in_shadow(std::span<const MeshRay> rays) const;

private:
    bool step_to(const MeshRay& ray, std::size_t j, glm::vec3& step) const;
    bool step(const MeshRay& ray, std::size_t i, std::size_t stride, bool has_before, bool has_after,
              glm::vec3& step) const;
    float area_about(std::size_t i) const;
    void find_edges();

    const scene::FrameScene& scene_;
    const light::BeamMesh& mesh_;
    const light::Landings& landings_;
    const rays::RayScene& rays_scene_;
    light::WayTransmittance ways_;
    std::size_t rows_, columns_;
    std::vector<float> areas_;
    std::vector<std::uint8_t> near_edge_;
    glm::vec3 color_;
    float farthest_;  // m
    bool shadowed_;
    float disc_ = 0;                // radius a m of way
    std::vector<DiscImage> discs_;  // behind a mirror
};

}  // namespace dapple::methods::caustic_mesh
