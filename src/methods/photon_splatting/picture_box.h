#pragma once
#include <glm/glm.hpp>

#include "methods/photon_splatting/lane_vectors.h"
#include "scene/frame_scene.h"

namespace dapple::methods {

/// Parallelograms of the picture, middle +- edge_a +- edge_b, pixels.
struct PictureCovers {
    Vectors2 middle, edge_a, edge_b;
};

/// Tangent planes as the camera sees them: homogeneous pixel coordinates (x, y, weight) of a point and of two
/// unit vectors of each.
struct PlaneViews {
    Vectors3 point, right, up;
    Flags in_front{};                            ///< the point is
    Vectors2 cell_from_right{}, cell_from_up{};  ///< derivatives at the point, samples' cells a m
};

/// The four corners point +- first +- second of parallelograms of such planes.
struct PictureCorners {
    Vectors2 nn, np, pn, pp;  ///< pixels; held before the near plane
    Flags in_front{};         ///< all four are
};

/// The camera in float, relative to the frame's origin: what splats need of it.
class PictureMap {
public:
    /// `at_cells`: as SamplePlace's.
    PictureMap(const scene::FrameScene& scene, bool at_cells);

    /// `right` and `up`: unit vectors of the planes.
    PlaneViews look_at(Vectors3 point, Vectors3 right, Vectors3 up) const;
    /// Whether the planes' points lie in the picture.
    Flags holds(const PlaneViews& planes) const;
    /// Towards the camera, any length.
    Vectors3 to_camera(Vectors3 point) const;
    /// `first` and `second` in the planes' own vectors, m.
    PictureCorners corners(const PlaneViews& planes, Vectors2 first, Vectors2 second) const;
    /// Boxes of the picture, cut to it, that hold the samples in the parallelograms, and which of them meet
    /// the picture.
    Flags box(const PictureCorners& corners, PictureCovers& covers) const;
    /// Parallelograms that lie along them where those are much smaller than `boxes`, elsewhere `boxes`.
    PictureCovers fitted(const PictureCorners& corners, const PictureCovers& boxes) const;

private:
    Vectors3 pixels_of(Vectors3 vector) const;

    glm::vec3 row_x_, row_y_, row_w_;  // of pixel_from_world, relative to the origin
    glm::vec3 offset_;
    glm::vec3 position_, backward_;
    bool perspective_;
    glm::vec2 picture_;
    // How far E's places lie from pixel centres: a box grows by this so that it covers the centres of all
    // pixels in which it holds one.
    glm::vec2 grow_low_, grow_high_;
    glm::vec2 cells_;  // a pixel
};

}  // namespace dapple::methods
