#pragma once
#include <glm/glm.hpp>
#include <vector>

#include "light/beam_mesh.h"

namespace dapple::methods::caustic_mesh {

/// The image of the sun's disc about a ray: its radius across the ray, so many m behind where the ray starts.
/// Its square is a polynomial of that way.
struct DiscImage {
    float constant = 0;   ///< m^2
    float linear = 0;     ///< m, half the factor of the way
    float quadratic = 0;  ///< 1
    float radius(float way) const;
    void add(float weight, const DiscImage& other);
};

/// Of each valid ray of a mesh that a mirror has sent on. `radius`: of the disc where it left the water, rad;
/// `farthest`: m between neighbours on one sheet. The disc is an ellipse behind a mirror, which stands here
/// with the mean of the squares of its semi-axes. How the mirror bends the rays beside a ray tell, by ray
/// differentials (Igehy 1999); rays that stand alone count as on a level one.
std::vector<DiscImage> mirrored_discs(const light::BeamMesh& mesh, float radius, float farthest);

}  // namespace dapple::methods::caustic_mesh
