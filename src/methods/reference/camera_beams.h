#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "methods/reference/light_tracer.h"
#include "methods/reference/own_media.h"
#include "methods/reference/scattering_event.h"

namespace dapple::reference {

/// What a small part of a pixel, around one camera path, sees of a medium: to first order in the place
/// (u, v) within the pixel, P(u, v, s) = origin + u u_origin + v v_origin
/// + s (direction + u u_direction + v v_direction).
struct CameraBeam {
    glm::vec3 origin, direction;  ///< m, relative to the origin; unit
    glm::vec3 u_origin, u_direction, v_origin, v_direction;
    float length = 0;     ///< m, of the middle path
    glm::vec3 factor{0};  ///< from what crosses it to S of the segment, /pixel^2
    std::uint32_t segment = 0;
    std::uint8_t in_water = 0;
};

/// The beams of a picture and a grid of voxels to find those around a place. Power W on a way of dt m through
/// a beam adds W dt scattering p / |J| to the integral of S over (u, v), J = det(dP/du, dP/dv, dP/ds): what a
/// pixel sees of a volume is exact to first order in the beam's width, so that the error falls with the
/// square of it. Where the camera's own paths cross, J passes through 0 and variance would grow without
/// bound: where beams are thinner than kThin of their breadth they are widened by up to kWidest, for the same
/// sum. (A place that a beam covers twice counts once.)
class CameraBeams {
public:
    /// Beams of one layer, those of about one width together: the few that a surface fans out over
    /// kilometres, near total reflection, would make the voxels of all others too large to tell them apart.
    /// `half` is half the beams' width and height, pixels.
    static std::vector<CameraBeams> by_width(std::vector<CameraBeam> beams, glm::dvec2 half);

    /// Limits of the voxels; larger ones are used where these do not suffice.
    static constexpr double kMostVoxels = 0x1p24, kMostEntries = 0x1.8p25;
    /// At most, beside the beams themselves.
    static constexpr double kMostBytes = (3 * kMostVoxels + kMostEntries) * sizeof(std::uint32_t);

    static constexpr double kThin = 0.02, kWidest = 4;

    /// Adds what a way of light scatters into the picture. True where places were found at which a medium had
    /// dimmed the light to 0, so that shallower ones may have been missed.
    bool add_events(const LightWay& way, MediaProbe& light_probe, MediaProbe& eye_probe, RandomStream& random,
                    std::vector<ScatteringEvent>& events) const;

private:
    struct Place {
        double u, v, s;
        double jacobian;  ///< m^2 / pixel^2, absolute
        double widening;  ///< of the beam in u and in v
    };
    bool find(const CameraBeam& beam, const glm::dvec3& position, Place& place) const;
    /// `share`: of the voxels and entries that are allowed.
    CameraBeams(std::vector<CameraBeam> beams, glm::dvec2 half, double share);
    void choose_voxels(double share);
    template <class Visit>
    void visit_voxels(const CameraBeam& beam, const Visit& visit) const;
    bool voxel(const glm::dvec3& position, std::size_t& index) const;

    std::vector<CameraBeam> beams_;
    glm::dvec2 half_{0};
    glm::dvec3 low_{0}, high_{0};  ///< m, bounds of the beams
    double voxel_ = 1;             ///< m
    glm::ivec3 count_{0};
    double spacing_ = 1;                ///< m between events along a way
    std::vector<std::uint32_t> first_;  ///< a voxel, and one more
    std::vector<std::uint32_t> found_;  ///< beams, voxel by voxel
};

}  // namespace dapple::reference
