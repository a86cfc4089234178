#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "scene/frame_scene.h"

namespace dapple::reference {

/// A point of an object's surface in its chart.
struct ChartPlace {
    /// Chart, then kDigits base-4 digits: the place in a tree of quarters of equal measure, coarsest first.
    std::uint64_t key = 0;
    double density = 0;  ///< m^2 of surface a unit of the chart's measure, at this place; 0: no place
};

/// Every face of the objects as a chart of measure 1: planes and faces of boxes are (u, v) squares; a mesh
/// has a chart a triangle, cut into quarters at the middles of its edges; a sphere's is (longitude, height),
/// equal in area on a true sphere. Each has two sides with a chart each. Positions are m, relative to
/// FrameScene::origin.
class ReceiverCharts {
public:
    explicit ReceiverCharts(const scene::FrameScene& scene);

    /// `object` and `primitive` as in rays::Hit. `towards` points from the surface to the side that is meant:
    /// against the travel of what arrives.
    ChartPlace place(std::uint32_t object, std::uint32_t primitive, const glm::dvec3& position,
                     const glm::dvec3& towards) const;
    std::size_t charts() const { return charts_; }
    /// Base-4 digits that a key has below the chart's number: 30, fewer where there are many charts.
    int digits() const { return digits_; }
    std::size_t bytes() const { return faces_.size() * sizeof(Face); }

private:
    /// A parallelogram or triangle, u and v in [0, 1].
    struct Face {
        glm::dvec3 corner{0};
        glm::dvec3 u{0}, v{0};  ///< gradients of the coordinates, 1/m
        glm::dvec3 normal{0};
        double area = 0;  ///< m^2
    };
    struct Placed {
        std::size_t first_chart = 0;
        std::size_t first_face = 0;
        std::uint32_t triangles_a_face = 1;  ///< 2: parallelograms
        bool sphere = false;
        glm::dvec3 center{0};
        glm::dmat3 unit_from_offset{1.0};
        double stretch = 0;  ///< |det| of the sphere's transform, m^3
    };
    void add_face(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, double share);
    std::uint64_t key(std::size_t chart, std::uint64_t digits) const;

    std::vector<Placed> objects_;
    std::vector<Face> faces_;
    std::size_t charts_ = 0;
    int digits_ = 30;
};

}  // namespace dapple::reference
