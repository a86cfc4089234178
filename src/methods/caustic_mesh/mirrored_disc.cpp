#include "methods/caustic_mesh/mirrored_disc.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "optics/optics.h"

namespace dapple::methods::caustic_mesh {
namespace {

constexpr std::size_t kTile = 1 << 12;
// Of the squared length of the longer step on a mirror, at least, that the other has across it, to tell how
// the mirror bends there.
constexpr float kLeastAcross = 1e-3f;

/// A ray about its mirror.
struct Reflection {
    glm::vec3 place;          // m
    glm::vec3 before, after;  // unit, directions of travel
    float way;                // m from the water
    glm::vec3 normal() const { return glm::normalize(after - before); }
};

class Mirror {
public:
    Mirror(const light::BeamMesh& mesh, float radius, float farthest)
        : mesh_(mesh),
          columns_(static_cast<std::size_t>(mesh.columns)),
          radius_(radius),
          farthest_(farthest) {}

    DiscImage image(std::size_t i) const {
        const Reflection own = reflection(i);
        const glm::vec3 normal = own.normal();
        const glm::vec3 helper = std::abs(own.before.y) < 0.7f ? glm::vec3(0, 1, 0) : glm::vec3(1, 0, 0);
        const glm::vec3 right = glm::normalize(glm::cross(helper, own.before));
        DiscImage image;
        for (const glm::vec3& across : {right, glm::cross(own.before, right)}) {
            const glm::vec3 turned = radius_ * across;
            const glm::vec3 moved =
                optics::f32::transferred_differential(glm::vec3(0), turned, own.before, own.way, normal);
            const glm::vec3 spread =
                optics::f32::reflected_differential(own.before, normal, turned, turn(i, own, moved));
            const glm::vec3 aside = moved - glm::dot(moved, own.after) * own.after;
            image.constant += 0.5f * glm::dot(aside, aside);
            image.linear += 0.5f * glm::dot(aside, spread);
            image.quadratic += 0.5f * glm::dot(spread, spread);
        }
        return image;
    }

private:
    Reflection reflection(std::size_t i) const {
        const glm::vec3 place = mesh_.origin[i] + mesh_.start[i] * mesh_.slope[i];
        const glm::vec3 way = place - mesh_.water_point[i];
        const float length = glm::length(way);
        return {place, way / length, glm::normalize(mesh_.slope[i]), length};
    }

    /// Differences of places and normals to the next ray along the grid; false where none is near.
    bool step(std::size_t i, const Reflection& own, std::size_t stride, bool has_before, bool has_after,
              glm::vec3& place, glm::vec3& normal) const {
        Reflection before = own, after = own;
        const auto take = [&](bool has, std::size_t j, Reflection& beside) {
            if (!has || !mesh_.valid[j]) return 0;
            const Reflection other = reflection(j);
            if (glm::distance(other.place, own.place) > farthest_) return 0;
            beside = other;
            return 1;
        };
        const int steps = take(has_before, i - stride, before) + take(has_after, i + stride, after);
        if (steps == 0) return false;
        const float share = 1 / static_cast<float>(steps);
        place = share * (after.place - before.place);
        normal = share * (after.normal() - before.normal());
        return true;
    }

    /// The differential of the mirror's normal where the place on it moves.
    glm::vec3 turn(std::size_t i, const Reflection& own, glm::vec3 moved) const {
        const std::size_t row = i / columns_, column = i % columns_;
        glm::vec3 a, b, turn_a, turn_b;
        if (!step(i, own, 1, column > 0, column + 1 < columns_, a, turn_a) ||
            !step(i, own, columns_, row > 0, row + 1 < mesh_.vertices() / columns_, b, turn_b))
            return glm::vec3(0);
        // moved = s a + t b in the least squares, of the two by two equations of which the diagonal is
        // raised.
        const float least = kLeastAcross * std::max(glm::dot(a, a), glm::dot(b, b));
        const float aa = glm::dot(a, a) + least, bb = glm::dot(b, b) + least, ab = glm::dot(a, b);
        const float to_a = glm::dot(moved, a), to_b = glm::dot(moved, b), scale = 1 / (aa * bb - ab * ab);
        const glm::vec3 result =
            (scale * (to_a * bb - to_b * ab)) * turn_a + (scale * (to_b * aa - to_a * ab)) * turn_b;
        return std::isfinite(glm::dot(result, result)) ? result : glm::vec3(0);
    }

    const light::BeamMesh& mesh_;
    std::size_t columns_;
    float radius_;
    float farthest_;  // m
};

}  // namespace

float DiscImage::radius(float way) const {
    return std::sqrt(std::max(0.0f, constant + way * (2 * linear + way * quadratic)));
}

void DiscImage::add(float weight, const DiscImage& other) {
    constant += weight * other.constant;
    linear += weight * other.linear;
    quadratic += weight * other.quadratic;
}

std::vector<DiscImage> mirrored_discs(const light::BeamMesh& mesh, float radius, float farthest) {
    std::vector<DiscImage> discs(mesh.vertices());
    const Mirror mirror(mesh, radius, farthest);
    parallel_for(discs.size(), kTile, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            if (mesh.valid[i]) discs[i] = mirror.image(i);
    });
    return discs;
}

}  // namespace dapple::methods::caustic_mesh
