#include "methods/photon_splatting/splat_builder.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "light/grid_blocks.h"
#include "methods/photon_splatting/emitter_blur.h"
#include "methods/photon_splatting/kernel.h"
#include "methods/photon_splatting/landed_faces.h"
#include "methods/photon_splatting/lattice.h"
#include "methods/photon_splatting/photon_power.h"
#include "methods/photon_splatting/picture_box.h"

namespace dapple::methods {
namespace {

// A plane seen more edge-on than this covers no pixel.
constexpr float kLeastViewCosine = 1e-4f;
// Pixels whose shading costs as much as what a quad costs more than a point before it is shaded (measured on
// lavapipe, pool and sea: any value from 30 to 200 does).
constexpr float kQuadSetup = 64;

class Builder {
public:
    Builder(const scene::FrameScene& scene, const media::Media& media, const light::BeamMesh& mesh,
            const light::Landings& landings, const SplatStyle& style, float largest_point)
        : mesh_(mesh),
          landings_(landings),
          style_(style),
          grid_(scene, mesh),
          power_(scene, media, grid_, style.paper_power),
          emitter_(scene, grid_),
          picture_(scene),
          largest_point_(largest_point) {
        const scene::Light& light = scene.state.lights[static_cast<std::size_t>(mesh.light)];
        // Refraction into the water narrows the disc by 1/n across the plane of incidence and by more, cos(i)
        // / (n cos(t)), in it; the wider one stands for both.
        if (grid_.sun() && style.disc)
            disc_ = static_cast<float>(
                0.5 * light.angular_diameter /
                (mesh.event == light::Event::transmission ? scene.state.water->refractive_index : 1.0));
    }

    /// The splats of photon i on each face that it lights.
    void build(std::size_t i, std::vector<layout::Splat>& points, std::vector<layout::Splat>& quads,
               std::size_t& without_neighbors) const {
        if (!(mesh_.flux[i] > 0)) return;
        const LandedFaces faces = landed_faces(mesh_, landings_, i, style_.every_face);
        const bool landed = std::isfinite(landings_.depth[i]);
        for (std::size_t k = 0; k < faces.count; ++k) {
            const PhotonHit hit = grid_.hit(i, faces.faces[k].depth, faces.faces[k].normal);
            if (!emit(hit, points, quads) && landed && k == 0) ++without_neighbors;
        }
    }

private:
    /// False where the photon has too few neighbours for its footprint.
    bool emit(const PhotonHit& hit, std::vector<layout::Splat>& points,
              std::vector<layout::Splat>& quads) const {
        const glm::vec3 point = hit.point, normal = hit.normal, beam = hit.beam;
        glm::vec2 pixel;
        glm::vec3 gradient_x, gradient_y;
        if (!picture_.at(point, pixel, gradient_x, gradient_y)) return true;
        const glm::vec3 to_camera = picture_.to_camera(point);
        if (glm::dot(normal, to_camera) < kLeastViewCosine * glm::length(to_camera)) return true;

        const Footprint footprint = style_.footprint(grid_, hit);
        const glm::vec3 right =
            glm::normalize(std::abs(normal.x) < 0.7f ? glm::cross(normal, glm::vec3(1, 0, 0))
                                                     : glm::cross(normal, glm::vec3(0, 1, 0)));
        const glm::vec3 up = glm::cross(normal, right);
        KernelMetric metric;
        metric.pixel_from_plane = {{glm::dot(gradient_x, right), glm::dot(gradient_y, right)},
                                   {glm::dot(gradient_x, up), glm::dot(gradient_y, up)}};
        const auto on_plane = [&](glm::vec3 v) { return glm::vec2(glm::dot(v, right), glm::dot(v, up)); };
        const glm::vec2 lean = on_plane(beam);
        metric.beam_gram = glm::mat2(1) - glm::outerProduct(lean, lean);
        metric.disc_radius = disc_ * hit.way;
        if (style_.disc && emitter_.any()) {
            // An ellipse of that covariance in place of the disc: its radius is two deviations.
            metric.disc_radius = 2;
            metric.beam_gram = glm::inverse(emitter_.covariance(hit, right, up));
        }
        ReducedLattice lattice;
        lattice.bases[0] = {on_plane(footprint.first), on_plane(footprint.second), 1};
        if (style_.reduced)
            lattice =
                reduce_lattice(lattice.bases[0].first, lattice.bases[0].second, reduction_metric(metric));

        layout::Splat splat;
        splat.position = point;
        splat.normal = normal;
        splat.in_water = mesh_.in_water() ? 1.0f : 0.0f;
        const glm::vec3 power = footprint.gain * power_.at(hit);
        const float facing = glm::dot(beam, normal);
        for (int b = 0; b < lattice.count; ++b) {
            const LatticeBasis& basis = lattice.bases[static_cast<std::size_t>(b)];
            const PlaneKernel kernel = widened_kernel(basis, metric, style_.kernel);
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
        return !footprint.without_neighbors;
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

    static bool finite(const layout::Splat& splat) {
        const glm::vec3 sum = splat.axis_a + splat.axis_b + splat.irradiance;
        return std::isfinite(sum.x + sum.y + sum.z) && std::isfinite(splat.tolerance);
    }

    const light::BeamMesh& mesh_;
    const light::Landings& landings_;
    const SplatStyle& style_;
    PhotonGrid grid_;
    PhotonPower power_;
    EmitterBlur emitter_;
    PictureMap picture_;
    float largest_point_;
    float disc_ = 0;  // radius a m of way, across the beam
};

}  // namespace

Splats build_splats(const scene::FrameScene& scene, const media::Media& media, const light::BeamMesh& mesh,
                    const light::Landings& landings, const SplatStyle& style, float largest_point) {
    const Builder builder(scene, media, mesh, landings, style, largest_point);
    const light::GridBlocks blocks(mesh.rows, mesh.columns);
    Splats splats;
    splats.points.resize(blocks.bands());
    splats.quads.resize(blocks.bands());
    std::vector<std::size_t> without_neighbors(blocks.bands(), 0);
    parallel_for(blocks.bands(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t band = begin; band < end; ++band) {
            // Room for a splat a photon: memory that is not touched costs nothing, growing costs copies.
            splats.points[band].reserve(blocks.band_size());
            splats.quads[band].reserve(blocks.band_size());
            blocks.visit_band(band, [&](std::size_t i) {
                builder.build(i, splats.points[band], splats.quads[band], without_neighbors[band]);
            });
        }
    });
    for (const std::size_t count : without_neighbors) splats.without_neighbors += count;
    return splats;
}

}  // namespace dapple::methods
