#pragma once
#include <array>
#include <cstddef>
#include <glm/glm.hpp>
#include <span>

#include "light/beam_mesh.h"
#include "methods/photon_splatting/lane_vectors.h"
#include "scene/frame_scene.h"

namespace dapple::methods {

/// Directions of the grid of photons: to the next column, to the next row.
enum class GridAxis { columns, rows };

/// Rays of a beam mesh.
struct RayLanes {
    Vectors3 origin, slope;  ///< m; m a m of depth
    Floats start{};          ///< m
    Vectors3 surface;        ///< m, where the ray starts: on the water, or at the mirror that has sent it on
    Vectors3 water;          ///< m, where it left the water
};

/// Eight photons of a mesh and those beside them.
struct Photons {
    struct Beside {
        RayLanes ray;
        Flags present{};  ///< there is one on the grid, whatever it is
        Flags
            connected{};  ///< with a ray from the same sheet of the water: a crest may hide what lies between
    };
    std::array<std::size_t, kPhotons> vertex{};  ///< of the mesh; lanes that are not on repeat others
    Flags on{};
    RayLanes own;
    std::array<Beside, 4> beside;  ///< before and after along columns, before and after along rows
    const Beside& before(GridAxis axis) const { return beside[axis == GridAxis::columns ? 0 : 2]; }
    const Beside& after(GridAxis axis) const { return beside[axis == GridAxis::columns ? 1 : 3]; }

    Flags any_connected(GridAxis axis) const { return before(axis).connected | after(axis).connected; }
    /// Difference a step of the grid of what `of` says of a ray; no number where none beside is connected.
    template <class Of>
    Vectors3 step_of(GridAxis axis, const Of& of) const {
        const Beside &low = before(axis), &high = after(axis);
        const Floats steps = all(0.0f) - __builtin_convertvector(low.connected + high.connected, Floats);
        const Vectors3 here = of(own);
        return (1.0f / steps) *
               (choose(high.connected, of(high.ray), here) - choose(low.connected, of(low.ray), here));
    }
};

/// Where photons' rays meet the tangent planes that they are splatted on.
struct PhotonHits {
    Floats depth{};   ///< m along the mesh's axis
    Vectors3 point;   ///< m, relative to the frame's origin
    Vectors3 normal;  ///< unit, of the plane, against the ray
    Vectors3 beam;    ///< unit, direction of travel
    Floats way{};     ///< m from the water, or from the mirror that has sent it on
};

/// Steps along the grid.
struct GridSteps {
    Vectors3 on_plane;  ///< m
    Vectors3 on_water;  ///< m, between where the same rays start; 0 without neighbours
    Flags any{};        ///< a neighbour is near
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

    /// `count` photons from `first` on, one to eight of one row, of which `inner` is true.
    Photons in_row(std::size_t first, std::size_t count) const;
    /// One to eight of any.
    Photons of(std::span<const std::size_t> vertices) const;
    /// Whether what lies beside the eight photons from `first` on can be read as it lies in memory.
    bool inner(std::size_t first) const;

    /// Unit directions of travel of the light that meets the water there.
    Vectors3 incident(const RayLanes& rays) const;
    /// Unit normals of the water against it, which turned its direction into the photons'.
    Vectors3 normal(const RayLanes& rays) const;
    /// Unit directions in which the photons left the water.
    Vectors3 from_water(const RayLanes& rays) const;
    /// Unit normals of the mirrors that have sent the photons on, against them.
    Vectors3 mirror_normal(const RayLanes& rays) const;
    /// m from the water to the hits, by way of the mirror where there is one.
    Floats whole_way(const Photons& photons, const PhotonHits& hits) const;
    /// Differentials of photons where they leave the water: of their places, their unit directions and, of
    /// mirrored ones, the normals of the mirrors on their ways.
    struct Leaving {
        Vectors3 place, direction, mirror_turn;
    };
    /// Differentials of the places on the mirrors, of those where photons leave the water.
    Vectors3 moved_on_mirror(const Photons& photons, Vectors3 place, Vectors3 direction, Flags on) const;
    /// Differentials of the mirrors' normals where the places on them move: what the rays beside have met of
    /// their curvature, 0 for rays that stand alone and along directions in which those lie too close.
    Vectors3 mirror_turn(const Photons& photons, Vectors3 moved) const;
    /// Takes them to the hits' planes; what lanes that are not `on` hold means nothing.
    Vectors3 carried(const Photons& photons, const PhotonHits& hits, const Leaving& leaving, Flags on) const;
    /// Differentials of the directions in which the light leaves the water: that of the light's own direction
    /// being `turned` and that of the water's normal `dn`.
    Vectors3 spread(const Photons& photons, Vectors3 turned, Vectors3 dn, Flags on) const;
    /// The differential of the direction of the light at the water whose place on it moves by `dx`, against
    /// the light; of a sun 0.
    Vectors3 turned(const Photons& photons, Vectors3 dx, Flags on) const;
    /// m^2 of the photons' cells of the map, across the light.
    Floats cell_across_light(const RayLanes& rays) const;

    PhotonHits hits(const Photons& photons, Floats depth, Vectors3 normal) const;
    /// The step on the plane to a ray parallel to its own, a cell of the rest plane away.
    Vectors3 parallel_step(const Photons& photons, const PhotonHits& hits, GridAxis axis) const;
    /// The step on the plane to the next ray along the grid: half the way between both neighbours, or the way
    /// to the one there is; `forward`: to the next one where there is one. Without any neighbour whose ray
    /// meets the plane: the parallel step.
    GridSteps step(const Photons& photons, const PhotonHits& hits, GridAxis axis, bool forward) const;

private:
    RayLanes rays_from(std::size_t first) const;
    RayLanes rays_at(const std::array<std::size_t, kPhotons>& index) const;
    /// Whether two rays left the water so closely together that it is one sheet between them.
    Flags near(const RayLanes& own, const RayLanes& other) const;

    const light::BeamMesh& mesh_;
    std::size_t columns_, rows_;
    bool sun_;
    glm::vec3 sun_direction_, light_position_;
    float eta_;
    float cell_area_;  // m^2
    float farthest_;   // m
};

}  // namespace dapple::methods
