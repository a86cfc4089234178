#pragma once
#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "light/spot_picture.h"
#include "media/media.h"
#include "scene/frame_scene.h"

namespace dapple::render {

/// A camera segment in double, positions relative to FrameScene::origin.
struct Segment {
    glm::dvec3 origin, direction;
    double length;
    bool in_water;
    glm::dvec3 at(double place) const { return origin + place * direction; }
};

/// A part of a segment within which densities are taken as even.
struct Cell {
    double begin, end;          ///< m
    glm::dvec3 depth;           ///< optical depth from the near end to `begin`
    glm::dvec3 depth_step;      ///< from `begin` to `end`
    std::size_t first_density;  ///< of the components, in SegmentCells::densities
};

struct SegmentCells {
    std::vector<Cell> cells;
    std::vector<double> densities;  ///< mean density of each component, cell by cell

    /// Replaces what was found before; up to where the segment is black.
    void find(const media::Media& media, const Segment& segment);
};

/// A light as one segment sees it. All that it is made from outlives it.
class LightOnSegment {
public:
    /// `sun_direction`: of travel, of suns; `pixel_radius`: of lamps, m, of the disc that stands for the
    /// pixel (and the part of an area light) where the segment passes the lamp.
    LightOnSegment(const scene::FrameScene& scene, const media::Media& media, const scene::Light& light,
                   const glm::dvec3& sun_direction, const Segment& segment, double pixel_radius);

    /// Whether the segment meets a lamp and the pixel has no size.
    bool singular() const { return lamp() && distance_ == 0; }

    /// Way of the light to a place of the segment.
    struct Way {
        glm::dvec3 direction;  ///< unit, of travel
        double length;         ///< m
    };
    Way way(double place) const;
    /// Optical depth of that way.
    glm::dvec3 depth(double place, const Way& way) const;

    /// The variable of integration at a place: the angle at the lamp (Kulla and Fajardo 2012), or the place.
    double variable(double place) const;
    double place(double variable) const;
    double angle(double begin, double end) const { return lamp() ? variable(end) - variable(begin) : 0; }
    /// In how many parts the distance from a lamp at most doubles, where the lamp is seen so nearly along the
    /// segment that its angle hardly changes.
    double doublings(double begin, double end) const;
    /// Cuts the way between two such places into equal ratios of that distance.
    double between(double begin, double end, double share) const;
    /// Light that is scattered towards the near end, a unit of the variable of integration, if nothing is
    /// lost on the ways.
    glm::dvec3 scattered(const double* densities, const Way& way);

private:
    bool lamp() const { return light_.type != scene::LightType::sun; }
    void set_phases(double cosine);

    const media::Media& media_;
    const scene::Light& light_;
    const Segment& segment_;
    glm::dvec3 sun_direction_;
    glm::dvec3 strength_{0};
    glm::dvec3 lamp_{0};
    double foot_ = 0;      ///< m along the segment: nearest to the lamp
    double distance_ = 0;  ///< m from there
    std::vector<double> phases_;
};

/// What one node of the quadrature stands for.
struct LightShare {
    double begin, end;  ///< m
    glm::dvec3 value;   ///< W/m^2/sr
};

/// Appends the light that a cell scatters towards the segment's near end, shadow left out, by Gauss' rule in
/// steps. `with_way`: what media take of the light on its way to the segment is integrated too.
void add_light_of_cell(LightOnSegment& light, const Cell& cell, const double* densities, bool with_way,
                       std::vector<LightShare>& shares);

/// Multiplies shares of a lamp's light by the mean of its picture over their stretches of the segment, looked
/// at in steps of half a texel of equal angle at the lamp; of stretches longer than that kMostPictureSteps
/// times by steps as wide.
void add_picture(const light::SpotPicture& picture, const LightOnSegment& light,
                 std::vector<LightShare>& shares);
constexpr double kMostPictureSteps = 64;

}  // namespace dapple::render
