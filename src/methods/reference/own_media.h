#pragma once
#include <cstddef>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "grids/density_grid.h"
#include "methods/reference/own_phase.h"
#include "methods/reference/random_stream.h"
#include "scene/frame_scene.h"

namespace dapple::reference {

/// A stretch of a ray, m from its origin.
struct Stretch {
    double begin = 0, end = 0;
};

/// The largest densities in blocks of a grid.
struct GridBounds {
    int edge = 8;  ///< index units of a block
    glm::ivec3 first{0};
    glm::ivec3 count{0};
    std::vector<float> most;  ///< x fastest

    explicit GridBounds(const grids::DensityGrid& grid);
    float at(glm::ivec3 block) const;
};

/// The water and the bounded media of a frame as the reference sees them: it asks grids/ for densities and
/// shares nothing else. Positions are m, relative to the frame's origin; directions are unit.
class OwnMedia {
public:
    struct Bounded {
        bool in_air = true, in_water = true;
        glm::dvec3 extinction{0}, scattering{0};  ///< /m where density is 1
        OwnPhase phase;
        glm::dmat4 local_from_relative{1.0};  ///< box: into the cube of +-1/2; grid: index positions
        glm::dvec3 low{-0.5}, high{0.5};      ///< in that space; nothing lies outside
        std::shared_ptr<const grids::DensityGrid> grid = {};  ///< null: homogeneous, density 1
        std::optional<GridBounds> bounds = {};

        bool on(bool water) const { return water ? in_water : in_air; }
        std::optional<Stretch> inside(const glm::dvec3& origin, const glm::dvec3& direction,
                                      double length) const;
    };

    explicit OwnMedia(const scene::FrameScene& scene);

    const std::vector<Bounded>& bounded() const { return bounded_; }
    bool any_bounded(bool in_water) const;
    bool scatters(bool in_water) const;
    const glm::dvec3& water_extinction() const { return water_extinction_; }
    const glm::dvec3& water_scattering() const { return water_scattering_; }
    const OwnPhase& water_phase() const { return *water_phase_; }
    /// Of the homogeneous water alone; `distance` may be infinite.
    glm::dvec3 through_water(double distance) const;
    /// Where light on a ray of `length` m (may be infinite) may be scattered; what is
    /// homogeneous counts until less than 1e-26 of the light is left.
    std::optional<Stretch> scattering_stretch(const glm::dvec3& origin, const glm::dvec3& direction,
                                              double length, bool in_water) const;

private:
    glm::dvec3 water_extinction_{0}, water_scattering_{0};
    std::optional<OwnPhase> water_phase_;
    std::vector<Bounded> bounded_;
};

/// Asks the media, remembering where it was: one a thread.
class MediaProbe {
public:
    explicit MediaProbe(const OwnMedia& media);

    const OwnMedia& media() const { return media_; }
    /// Sum of scattering times phase function at a point, /m/sr, by the cosine between light and view.
    glm::dvec3 scattering(const glm::dvec3& position, double cosine, bool in_water);
    /// Extinction at a point, /m.
    glm::dvec3 extinction(const glm::dvec3& position, bool in_water);
    /// Estimate without bias of the transmittance of a way; exact where no grid lies on it.
    glm::dvec3 transmittance(const glm::dvec3& origin, const glm::dvec3& direction, double distance,
                             bool in_water, RandomStream& random);

    /// The same to places along one way: start, then ask at places that do not descend.
    void start(const glm::dvec3& origin, const glm::dvec3& direction, bool in_water);
    glm::dvec3 transmittance_to(double distance, RandomStream& random);

private:
    /// Ratio tracking (Novak, Selle & Jarosz 2014) through the blocks of a grid; through dense blocks, where
    /// it would take many steps, and where a ray may pass between what is dense with all its light, the
    /// integral of the density. No block takes much longer than another, whatever its density.
    struct Walk {
        const OwnMedia::Bounded* medium = nullptr;
        grids::DensityGrid::Reader* reader = nullptr;
        glm::dvec3 origin{0}, direction{0};  ///< index units; direction a m
        double at = 0, end = 0;              ///< m
        glm::ivec3 block{0}, step{0};
        glm::dvec3 next{0};   ///< m at which the ray leaves the block, an axis
        glm::dvec3 width{0};  ///< m between the sides of a block
        glm::dvec3 weight{1};
        void advance(double to, RandomStream& random);
        void track(double leave, double majorant, RandomStream& random);
        void cross_cells(double leave);
        double density() { return static_cast<double>(reader->density(origin + at * direction)); }
    };
    struct Slab {
        Stretch stretch;
        glm::dvec3 extinction;
    };
    double density(std::size_t medium, const glm::dvec3& position);
    void start_walk(std::size_t medium, const glm::dvec3& origin, const glm::dvec3& direction,
                    const Stretch& stretch);

    const OwnMedia& media_;
    std::vector<std::unique_ptr<grids::DensityGrid::Reader>> readers_;  ///< a bounded medium; null: a box
    bool in_water_ = false;
    std::vector<Slab> slabs_;
    std::vector<Walk> walks_;
};

}  // namespace dapple::reference
