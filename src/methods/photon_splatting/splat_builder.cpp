#include "methods/photon_splatting/splat_builder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/parallel.h"
#include "light/grid_blocks.h"
#include "light/way_transmittance.h"
#include "methods/photon_splatting/kernel.h"
#include "methods/photon_splatting/lattice.h"
#include "methods/photon_splatting/picture_box.h"

namespace dapple::methods {
namespace {

// A neighbour's ray that meets the tangent plane so much more steeply or levelly spans no footprint with this
// one.
constexpr float kLeastRelativeCosine = 0.1f;
// A plane seen more edge-on than this covers no pixel.
constexpr float kLeastViewCosine = 1e-4f;
// Receivers within this share of the kernel's half-extent of the tangent plane are on the same surface: the
// sagitta of a kernel as large as half the radius of curvature.
constexpr float kPlaneTolerance = 0.25f;

// Neighbours further apart on the water, in cells, are on different sheets of it: a crest hides what lies
// between.
constexpr float kFarthestNeighbor = 4;

// Pixels whose shading costs as much as what a quad costs more than a point before it is shaded (measured on
// lavapipe, pool and sea: any value from 30 to 200 does).
constexpr float kQuadSetup = 64;

// As in splat_fragment.glsl.
constexpr float kSmallestNormalCosine = 0.7f;
// Steps between neighbours by which a plane may lie behind what a ray hit and still form a corner with it.
constexpr float kCornerReach = 2;

class Builder {
public:
    Builder(const scene::FrameScene& scene, const media::Media& media, const light::BeamMesh& mesh,
            const light::Landings& landings, float largest_point)
        : mesh_(mesh),
          landings_(landings),
          ways_(scene, media, mesh),
          picture_(scene),
          largest_point_(largest_point),
          columns_(static_cast<std::size_t>(mesh.columns)),
          rows_(static_cast<std::size_t>(mesh.rows)) {
        const scene::Light& light = scene.state.lights[static_cast<std::size_t>(mesh.light)];
        const scene::Water& water = *scene.state.water;
        const bool sun = light.type == scene::LightType::sun;
        color_ = glm::vec3(sun ? light.irradiance : light.intensity);
        farthest_ = kFarthestNeighbor * std::max(mesh.cell.x, mesh.cell.y);
        // Refraction into the water narrows the disc by 1/n across the plane of incidence and by more, cos(i)
        // / (n cos(t)), in it; the wider one stands for both.
        if (sun)
            disc_ =
                static_cast<float>(0.5 * light.angular_diameter /
                                   (mesh.event == light::Event::transmission ? water.refractive_index : 1.0));
    }

    /// The splat of photon i where it lands, and on the planes of neighbours that landed on other faces.
    void build(std::size_t i, std::vector<layout::Splat>& points, std::vector<layout::Splat>& quads,
               std::size_t& without_neighbors) const {
        if (!(mesh_.flux[i] > 0)) return;
        const bool landed = std::isfinite(landings_.depth[i]);
        std::array<std::size_t, 5> faces{};
        std::size_t count = 0;
        if (landed) {
            faces[count++] = i;
            if (!emit(i, landings_.depth[i], landings_.normal[i], points, quads)) ++without_neighbors;
        }
        const std::size_t row = i / columns_, column = i % columns_;
        const std::array<std::pair<bool, std::size_t>, 4> neighbors = {{{column > 0, i - 1},
                                                                        {column + 1 < columns_, i + 1},
                                                                        {row > 0, i - columns_},
                                                                        {row + 1 < rows_, i + columns_}}};
        for (const auto& [present, j] : neighbors) {
            if (!present || !std::isfinite(landings_.depth[j])) continue;
            const bool known = std::any_of(faces.begin(), faces.begin() + static_cast<std::ptrdiff_t>(count),
                                           [&, face = j](std::size_t k) { return same_face(face, k); });
            float depth;
            if (known || !reaches(i, j, depth)) continue;
            faces[count++] = j;
            emit(i, depth, landings_.normal[j], points, quads);
        }
    }

private:
    glm::vec3 landing(std::size_t i) const { return mesh_.origin[i] + landings_.depth[i] * mesh_.slope[i]; }

    /// Whether a splat of one lights receivers about the other: what the fragment shader asks of a receiver.
    bool same_face(std::size_t j, std::size_t k) const {
        if (j == k) return true;
        if (glm::dot(landings_.normal[j], landings_.normal[k]) < kSmallestNormalCosine) return false;
        const glm::vec3 step = landing(k) - landing(j);
        return std::abs(glm::dot(landings_.normal[j], step)) <= kPlaneTolerance * glm::length(step);
    }

    /// Depth at which ray i meets the plane that its neighbour j landed on. False where i was stopped well
    /// before: there it lies in shadow. A plane shortly behind what i hit is the other side of a concave
    /// corner. Neighbours past the edge of a face so take part in the lattice on it, and the sum of kernels
    /// is one up to the edge.
    bool reaches(std::size_t i, std::size_t j, float& depth) const {
        const glm::vec3 normal = landings_.normal[j];
        const float own = glm::dot(normal, mesh_.slope[i]), other = glm::dot(normal, mesh_.slope[j]);
        if (!(own < kLeastRelativeCosine * other)) return false;  // both are negative
        const glm::vec3 level =
            (mesh_.origin[i] - mesh_.origin[j]) + landings_.depth[j] * (mesh_.slope[i] - mesh_.slope[j]);
        depth = landings_.depth[j] - glm::dot(normal, level) / own;
        if (depth < mesh_.start[i]) return false;
        const float behind = (depth - landings_.depth[i]) * glm::length(mesh_.slope[i]);
        return !(behind > kCornerReach * glm::length(level));
    }

    /// Adds the splats of ray i on the plane at `depth`; false where a direction of the grid has no
    /// neighbour.
    bool emit(std::size_t i, float depth, glm::vec3 normal, std::vector<layout::Splat>& points,
              std::vector<layout::Splat>& quads) const {
        const glm::vec3 slope = mesh_.slope[i];
        const glm::vec3 point = mesh_.origin[i] + depth * slope;
        glm::vec2 pixel;
        glm::vec3 gradient_x, gradient_y;
        if (!picture_.at(point, pixel, gradient_x, gradient_y)) return true;
        const glm::vec3 to_camera = picture_.to_camera(point);
        if (glm::dot(normal, to_camera) < kLeastViewCosine * glm::length(to_camera)) return true;

        glm::vec3 along_columns, along_rows;
        const std::size_t row = i / columns_, column = i % columns_;
        const bool has_row =
            difference(i, column > 0, column + 1 < columns_, 1, depth, normal, along_columns);
        const bool has_column = difference(i, row > 0, row + 1 < rows_, columns_, depth, normal, along_rows);
        if (!has_row) along_columns = parallel_step(i, {mesh_.cell.x, 0, 0}, normal);
        if (!has_column) along_rows = parallel_step(i, {0, 0, mesh_.cell.y}, normal);

        const glm::vec3 right =
            glm::normalize(std::abs(normal.x) < 0.7f ? glm::cross(normal, glm::vec3(1, 0, 0))
                                                     : glm::cross(normal, glm::vec3(0, 1, 0)));
        const glm::vec3 up = glm::cross(normal, right);
        const float steepness = glm::length(slope), way = steepness * (depth - mesh_.start[i]);
        const glm::vec3 beam = slope / steepness;
        KernelMetric metric;
        metric.pixel_from_plane = {{glm::dot(gradient_x, right), glm::dot(gradient_y, right)},
                                   {glm::dot(gradient_x, up), glm::dot(gradient_y, up)}};
        const glm::vec2 lean(glm::dot(beam, right), glm::dot(beam, up));
        metric.beam_gram = glm::mat2(1) - glm::outerProduct(lean, lean);
        metric.disc_radius = disc_ * way;
        const auto on_plane = [&](glm::vec3 v) { return glm::vec2(glm::dot(v, right), glm::dot(v, up)); };
        const ReducedLattice lattice =
            reduce_lattice(on_plane(along_columns), on_plane(along_rows), reduction_metric(metric));

        layout::Splat splat;
        splat.position = point;
        splat.normal = normal;
        splat.in_water = mesh_.in_water() ? 1.0f : 0.0f;
        glm::vec3 power = mesh_.flux[i] * color_ * ways_.of(surface_point(i), point, way);
        if (!mesh_.tint.empty()) power *= mesh_.tint[i];
        const float facing = glm::dot(beam, normal);
        for (int b = 0; b < lattice.count; ++b) {
            const LatticeBasis& basis = lattice.bases[static_cast<std::size_t>(b)];
            const PlaneKernel kernel = widened_kernel(basis, metric);
            const glm::vec3 first = kernel.first.x * right + kernel.first.y * up;
            const glm::vec3 second = kernel.second.x * right + kernel.second.y * up;
            PictureCover cover;
            if (!picture_.box(point, first, second, cover)) continue;
            // Dual vectors of (first, second, beam): perpendicular to the beam, so that a receiver off the
            // plane is taken along the beam.
            const glm::vec3 a = glm::cross(second, beam), c = glm::cross(beam, first);
            splat.axis_a = a / glm::dot(first, a);
            splat.axis_b = c / glm::dot(second, c);
            const float area = std::abs(glm::dot(glm::cross(first, second), normal));
            splat.box_a = kernel.box_first;
            splat.box_b = kernel.box_second;
            splat.irradiance = power * (basis.weight / area);
            splat.tolerance =
                kPlaneTolerance * std::max(glm::length(first), glm::length(second)) * std::abs(facing);
            if (!finite(splat)) continue;
            const bool point_sprite = fits_point(point, first, second, cover);
            splat.center = cover.middle;
            splat.edge_a = cover.edge_a;
            splat.edge_b = cover.edge_b;
            (point_sprite ? points : quads).push_back(splat);
        }
        return has_row && has_column;
    }

    /// A point sprite is a square about the box, cheap to set up; a quad fits closely. Leaves in `cover` what
    /// is to be drawn.
    bool fits_point(glm::vec3 point, glm::vec3 first, glm::vec3 second, PictureCover& cover) const {
        const float side = 2 * std::max(cover.edge_a.x, cover.edge_b.y);
        if (side * side < kQuadSetup) return true;
        const PictureCover box = cover;
        picture_.fit(point, first, second, cover);
        const float area = 4 * std::abs(cover.edge_a.x * cover.edge_b.y - cover.edge_a.y * cover.edge_b.x);
        if (side > largest_point_ || side * side - area > kQuadSetup) return false;
        cover = box;
        return true;
    }

    /// The step to the next ray along the grid on the tangent plane: half the way between both neighbours, or
    /// the way to the one there is.
    bool difference(std::size_t i, bool has_before, bool has_after, std::size_t stride, float depth,
                    glm::vec3 normal, glm::vec3& step) const {
        glm::vec3 before(0), after(0);
        has_before = has_before && step_to(i, i - stride, depth, normal, before);
        has_after = has_after && step_to(i, i + stride, depth, normal, after);
        if (has_before && has_after) {
            step = 0.5f * (after - before);
        } else if (has_after) {
            step = after;
        } else {
            step = -before;
        }
        return has_before || has_after;
    }

    /// The step to a ray parallel to i, `across` away on the rest plane: for a ray without neighbours.
    glm::vec3 parallel_step(std::size_t i, glm::vec3 across, glm::vec3 normal) const {
        return across - (glm::dot(normal, across) / glm::dot(normal, mesh_.slope[i])) * mesh_.slope[i];
    }

    glm::vec3 surface_point(std::size_t i) const { return mesh_.origin[i] + mesh_.start[i] * mesh_.slope[i]; }

    /// From where ray i lands to where ray j meets the same plane. Differences of the rays come first: the
    /// points themselves have lost the digits.
    bool step_to(std::size_t i, std::size_t j, float depth, glm::vec3 normal, glm::vec3& step) const {
        step = glm::vec3(0);
        if (!mesh_.valid[j]) return false;
        const glm::vec3 apart = surface_point(j) - surface_point(i);
        if (glm::dot(apart, apart) > farthest_ * farthest_) return false;
        const glm::vec3 level =
            (mesh_.origin[j] - mesh_.origin[i]) + depth * (mesh_.slope[j] - mesh_.slope[i]);
        const float own = glm::dot(normal, mesh_.slope[i]), other = glm::dot(normal, mesh_.slope[j]);
        if (!(other < kLeastRelativeCosine * own)) return false;  // both are negative
        step = level - (glm::dot(normal, level) / other) * mesh_.slope[j];
        return true;
    }

    static bool finite(const layout::Splat& splat) {
        const glm::vec3 sum = splat.axis_a + splat.axis_b + splat.irradiance;
        return std::isfinite(sum.x + sum.y + sum.z) && std::isfinite(splat.tolerance);
    }

    const light::BeamMesh& mesh_;
    const light::Landings& landings_;
    light::WayTransmittance ways_;
    PictureMap picture_;
    float largest_point_;
    std::size_t columns_, rows_;
    glm::vec3 color_;
    float farthest_ = 0;  // m
    float disc_ = 0;      // radius a m of way, across the beam
};

}  // namespace

Splats build_splats(const scene::FrameScene& scene, const media::Media& media, const light::BeamMesh& mesh,
                    const light::Landings& landings, float largest_point) {
    const Builder builder(scene, media, mesh, landings, largest_point);
    const light::GridBlocks blocks(mesh.rows, mesh.columns);
    Splats splats;
    splats.points.resize(blocks.bands());
    splats.quads.resize(blocks.bands());
    std::vector<std::size_t> without_neighbors(blocks.bands(), 0);
    parallel_for(blocks.bands(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t band = begin; band < end; ++band) {
            blocks.visit_band(band, [&](std::size_t i) {
                builder.build(i, splats.points[band], splats.quads[band], without_neighbors[band]);
            });
        }
    });
    for (const std::size_t count : without_neighbors) splats.without_neighbors += count;
    return splats;
}

}  // namespace dapple::methods
