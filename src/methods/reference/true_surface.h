#pragma once
#include <cstddef>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "methods/reference/sine_sum.h"
#include "scene/frame_scene.h"

namespace dapple::reference {

/// A sea known by height, slopes and mixed second derivative at the points of a grid over one period, in
/// between by cubic Hermite patches: exact to fourth order in the cell (1e-5 of a wave's height at 25 cells a
/// wave), with slopes that are those of the very surface.
struct PatchedSea {
    int columns = 0, rows = 0;  ///< points along x and z
    bool repeats = false;       ///< beyond the grid; else its edge patches go on there
    glm::dvec2 corner{0}, cell{1};
    std::vector<double> height, slope_x, slope_z, mixed;

    void evaluate(std::span<const double> x, std::span<const double> z, std::span<double> out_height,
                  std::span<double> out_slope_x, std::span<double> out_slope_z) const;
};

/// The water of a frame as the reference sees it, in world space. `waves` are the analytic sum; an unchoppy
/// spectrum is a PatchedSea; choppy spectra (on a finer grid than the frame's, but for rings, which are the
/// frame's) and mesh sequences are their triangles, with interpolated normals.
class TrueSurface {
public:
    explicit TrueSurface(const scene::FrameScene& scene);

    bool is_height_field() const { return sines_.has_value() || sea_.has_value(); }
    /// For height fields: height and slopes at world (x, z).
    void evaluate(std::span<const double> x, std::span<const double> z, std::span<double> height,
                  std::span<double> slope_x, std::span<double> slope_z) const;
    /// No two points of a height field lie on a steeper line than this (spectrum: slopes of the grid, and a
    /// tenth more); infinite for triangles.
    double steepest() const { return steepest_; }
    double highest() const { return highest_; }  ///< m; |y| of the surface is at most this

    /// Triangles for rays that may meet the water; made anew for height fields, finer than the frame's.
    std::shared_ptr<const scene::WaterMesh> mesh() const;
    /// How far the triangles of `mesh` are off a height field, m: twice the most in the middle of a cell.
    double chord_error(const scene::WaterMesh& mesh) const;

private:
    scene::Water water_;
    double time_ = 0;
    std::optional<SineSum> sines_;
    std::optional<PatchedSea> sea_;
    std::shared_ptr<const scene::WaterMesh> triangles_;
    double steepest_ = 0;
    double highest_ = 0;
};

/// Memory that a TrueSurface and the ray scene of its mesh may take, in bytes.
double surface_bytes(const scene::Water& water);

}  // namespace dapple::reference
