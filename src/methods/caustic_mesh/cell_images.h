#pragma once
#include <array>
#include <glm/glm.hpp>

#include "methods/caustic_mesh/cell_drawing.h"
#include "methods/caustic_mesh/landed_mesh.h"

namespace dapple::methods::caustic_mesh {

/// Rays at the corners of a cell: (0, 0), (0, 1), (1, 1) and (1, 0) in rows and columns.
using Corners = std::array<MeshRay, 4>;

/// Different faces that a cell may be laid onto, each by a ray that landed there; eight at most.
class Faces {
public:
    void add(const MeshRay& ray);
    std::size_t count() const { return count_; }
    /// Whether there were more, which the cell does not light.
    bool overfull() const { return overfull_; }
    const MeshRay* begin() const { return rays_.data(); }
    const MeshRay* end() const { return rays_.data() + count_; }

private:
    std::array<MeshRay, 8> rays_;
    std::size_t count_ = 0;
    bool overfull_ = false;
};

/// A cell on a plane, and where on its rays that is.
struct CellImage {
    LandedCell cell;
    std::array<float, 4> depth;
};

/// Images of cells on what their rays, or others, landed on. `share`: of a cell of the map.
class CellImages {
public:
    explicit CellImages(const LandedMesh& mesh) : mesh_(mesh) {}

    /// Where the corners landed.
    CellImage landed(const Corners& corners, float share) const;
    /// On the plane that a ray landed on; false where one of the corners does not meet it. Those that
    /// something stopped before leave no light there, but for those at a concave corner: the plane goes on
    /// behind what they met, where nothing sees it.
    bool on_plane(const Corners& corners, const MeshRay& on, float share, CellImage& image) const;
    /// Fills in what the light carries to the corners.
    void carry(const Corners& corners, CellImage& image) const;

private:
    CellImage about(const Corners& corners, float share) const;

    const LandedMesh& mesh_;
};

}  // namespace dapple::methods::caustic_mesh
