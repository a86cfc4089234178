#pragma once
#include <cstddef>
#include <glm/glm.hpp>

#include "light/beam_mesh.h"
#include "scene/frame_scene.h"

namespace dapple::methods {

/// Where a photon's ray meets the tangent plane that it is splatted on.
struct PhotonHit {
    std::size_t photon = 0;  ///< vertex of the beam mesh
    float depth = 0;         ///< m along the mesh's axis
    glm::vec3 point{0};      ///< m, relative to the frame's origin
    glm::vec3 normal{0};     ///< unit, of the plane, against the ray
    glm::vec3 beam{0};       ///< unit, direction of travel
    float way = 0;           ///< m from the water
};

/// Directions of the grid of photons: to the next column, to the next row.
enum class GridAxis { columns, rows };

/// Neighbours along one of them, on the same sheet of the water: a crest may hide what lies between.
struct Neighbors {
    bool has_before = false, has_after = false;
    std::size_t before = 0, after = 0;
    bool any() const { return has_before || has_after; }
};

/// The photons of a beam mesh, their neighbours, and the light and the water that they come from.
class PhotonGrid {
public:
    PhotonGrid(const scene::FrameScene& scene, const light::BeamMesh& mesh);

    const light::BeamMesh& mesh() const { return mesh_; }
    std::size_t columns() const { return columns_; }
    std::size_t rows() const { return rows_; }
    bool sun() const { return sun_; }
    glm::vec3 light_position() const { return light_position_; }  ///< m; point and spot
    /// Index of the medium that the light comes through over that of the other.
    float eta() const { return eta_; }

    glm::vec3 surface_point(std::size_t i) const { return mesh_.origin[i] + mesh_.start[i] * mesh_.slope[i]; }
    /// Unit direction of travel of the light that meets the water there.
    glm::vec3 incident(std::size_t i) const;
    /// Unit normal of the water against it, which turned its direction into the photon's.
    glm::vec3 normal(std::size_t i) const;
    /// m^2 of the photon's cell of the map, across the light.
    float cell_across_light(std::size_t i) const;

    PhotonHit hit(std::size_t i, float depth, glm::vec3 normal) const;
    Neighbors neighbors(std::size_t i, GridAxis axis) const;
    /// From the point to where ray j meets the same plane; false where that ray runs along the plane
    /// or away from it.
    bool step_to(const PhotonHit& hit, std::size_t j, glm::vec3& step) const;
    /// The step on the plane to a ray parallel to its own, a cell of the rest plane away.
    glm::vec3 parallel_step(const PhotonHit& hit, GridAxis axis) const;
    /// The step on the plane to the next ray along the grid: half the way between both neighbours, or the way
    /// to the one there is; `forward`: to the next one where there is one. False without any neighbour: the
    /// parallel step.
    bool step(const PhotonHit& hit, GridAxis axis, bool forward, glm::vec3& step) const;

private:
    const light::BeamMesh& mesh_;
    std::size_t columns_, rows_;
    bool sun_;
    glm::vec3 sun_direction_, light_position_;
    float eta_;
    float farthest_;  // m
};

}  // namespace dapple::methods
