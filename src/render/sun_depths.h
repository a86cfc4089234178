#pragma once
#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "media/media.h"

namespace dapple::render {

/// Optical depth between points in the air and the sun: of a grid on a lattice along the light, half a voxel
/// apart, and trilinear between (a deep shadow map, Lokovic and Veach 2000, without their compression). One
/// walk through the grid finds it for all points on a ray. `media` outlives it.
class SunDepths {
public:
    /// `travel`: unit, of the light.
    SunDepths(const media::Media& media, const glm::dvec3& travel);

    /// Whether the grids are small enough; else it is not to be asked.
    bool fits() const { return fits_; }
    /// A channel; `at`: m, relative to FrameScene::origin. Thread-safe.
    glm::dvec3 depth(const glm::dvec3& at) const;

private:
    struct Lattice {
        glm::dvec3 extinction;  ///< /m where density is 1
        glm::dvec3 first;       ///< m, along the axes
        double spacing;         ///< m
        glm::ivec3 size;
        std::vector<float> column;  ///< integral of density to the sun, m; along the light fastest
    };
    void fill(const media::Body& body, Lattice& lattice) const;
    double column(const Lattice& lattice, const glm::dvec3& at) const;

    const media::Media& media_;
    glm::dmat3 axes_;  ///< rows: two across the light, and towards the sun
    glm::dvec3 to_sun_;
    std::vector<Lattice> lattices_;
    std::vector<const media::Part*> boxes_;
    bool fits_ = true;
};

}  // namespace dapple::render
