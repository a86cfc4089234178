#include "methods/caustic_mesh/cell_images.h"

#include <algorithm>
#include <cmath>

namespace dapple::methods::caustic_mesh {
namespace {

// A ray that meets a plane so much more steeply or levelly than the one that landed there has no image on it.
constexpr float kLeastRelativeCosine = 0.1f;

}  // namespace

void Faces::add(const MeshRay& ray) {
    if (!ray.landed() ||
        std::any_of(begin(), end(), [&](const MeshRay& known) { return same_face(known, ray); }))
        return;
    if (count_ == rays_.size()) {
        overfull_ = true;
        return;
    }
    rays_[count_++] = ray;
}

CellImage CellImages::about(const Corners& corners, float share) const {
    CellImage image;
    image.cell.share = share;
    glm::vec3 beam(0);
    for (const MeshRay& ray : corners) beam += ray.slope;
    image.cell.beam = glm::normalize(beam);
    const glm::mat2 texel = mesh_.mesh().texel;
    image.cell.spacing = std::sqrt(share) * std::min(glm::length(texel[0]), glm::length(texel[1]));
    return image;
}

CellImage CellImages::landed(const Corners& corners, float share) const {
    CellImage image = about(corners, share);
    glm::vec3 normal(0);
    float way = 0;
    DiscImage disc;
    for (std::size_t k = 0; k < 4; ++k) {
        disc.add(0.25f, corners[k].disc);
        image.depth[k] = corners[k].depth;
        image.cell.corner[k] = corners[k].landing();
        image.cell.flux[k] = corners[k].flux;
        image.cell.area[k] = corners[k].area;
        normal += corners[k].normal;
        way += 0.25f * (corners[k].depth - corners[k].start) * glm::length(corners[k].slope);
    }
    image.cell.normal = glm::normalize(normal);
    image.cell.disc = disc.radius(way);
    return image;
}

bool CellImages::on_plane(const Corners& corners, const MeshRay& on, float share, CellImage& image) const {
    const glm::vec3 point = on.landing();
    image = about(corners, share);
    image.cell.normal = on.normal;
    image.cell.disc = on.disc.radius((on.depth - on.start) * glm::length(on.slope));
    const float cosine = glm::dot(on.normal, on.slope);
    for (std::size_t k = 0; k < 4; ++k) {
        const MeshRay& ray = corners[k];
        const float own = glm::dot(on.normal, ray.slope);
        if (!(own < kLeastRelativeCosine * cosine)) return false;  // both are negative
        // Differences of the rays come first: the points themselves have lost the digits.
        const glm::vec3 level = (ray.origin - on.origin) + on.depth * (ray.slope - on.slope);
        const float further = -glm::dot(on.normal, level) / own;
        image.depth[k] = on.depth + further;
        image.cell.corner[k] = point + level + further * ray.slope;
        const bool stopped = ray.landed() && ray.depth < image.depth[k] && !same_face(on, ray) &&
                             glm::dot(ray.normal, point - ray.landing()) < 0;
        image.cell.flux[k] = stopped ? 0 : ray.flux;
    }
    return true;
}

void CellImages::carry(const Corners& corners, CellImage& image) const {
    for (std::size_t k = 0; k < 4; ++k) image.cell.power[k] = mesh_.power(corners[k], image.depth[k]);
}

}  // namespace dapple::methods::caustic_mesh
