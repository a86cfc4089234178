#include "methods/photon_splatting/splat_builder.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/parallel.h"
#include "base/transpose.h"
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
constexpr std::size_t kBandRows = 8;  // a tile of the parallel loop
constexpr std::size_t kSplatFloats = sizeof(layout::Splat) / sizeof(float);
static_assert(kSplatFloats == 3 * kPhotons);

/// What one band gives.
struct Band {
    LargeVector<layout::Splat>& points;
    LargeVector<layout::Splat>& quads;
    std::size_t without_neighbors = 0;
    double lost = 0;
};

/// Photons that wait until there are eight: those that light faces on which they did not land.
struct Waiting {
    std::array<std::size_t, kPhotons> vertex{};
    Floats depth{};
    Vectors3 normal;
    Flags landed{};  ///< on this face
    std::size_t count = 0;
};

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
          picture_(scene, style.kernel.widened),
          largest_point_(largest_point) {
        const scene::Light& light = scene.state.lights[static_cast<std::size_t>(mesh.light)];
        // Refraction into the water narrows the disc by 1/n across the plane of incidence and by more, cos(i)
        // / (n cos(t)), in it; the wider one stands for both.
        if (grid_.sun() && style.disc)
            disc_ = static_cast<float>(
                0.5 * light.angular_diameter /
                (mesh.event == light::Event::transmission ? scene.state.water->refractive_index : 1.0));
    }

    std::size_t bands() const { return (grid_.rows() + kBandRows - 1) / kBandRows; }

    /// The splats of the photons of some rows on each face that they light, by blocks of 8 x 8.
    void build(std::size_t band, Band& out) const {
        const std::size_t columns = grid_.columns(), top = band * kBandRows,
                          bottom = std::min(grid_.rows(), top + kBandRows);
        Waiting waiting;
        for (std::size_t left = 0; left < columns; left += kPhotons)
            for (std::size_t row = top; row < bottom; ++row)
                build_eight(row * columns + left, std::min(kPhotons, columns - left), waiting, out);
        flush(waiting, out);
    }

private:
    void build_eight(std::size_t first, std::size_t count, Waiting& waiting, Band& out) const {
        Flags lit{};
        if (grid_.inner(first)) {
            lit = first_of(count) & (load(&mesh_.flux[first]) > 0.0f);
            if (!lanes::any(lit)) return;
            const Photons photons = grid_.in_row(first, count);
            const PhotonHits hits =
                grid_.hits(photons, load(&landings_.depth[first]), load(&landings_.normal[first]));
            const Flags even = style_.every_face ? on_one_face(photons, hits, landings_, grid_.columns())
                                                 : finite(hits.depth);
            if (lanes::any(lit & even)) emit(photons, hits, lit & even, lit & even, out);
            lit &= ~even;
        } else {
            for (std::size_t k = 0; k < count; ++k) lit[k] = mesh_.flux[first + k] > 0 ? -1 : 0;
        }
        for (unsigned left = lanes::bits(lit); left != 0; left &= left - 1)
            wait(first + static_cast<std::size_t>(__builtin_ctz(left)), waiting, out);
    }

    /// All faces that a photon lights.
    void wait(std::size_t i, Waiting& waiting, Band& out) const {
        const LandedFaces faces = landed_faces(mesh_, landings_, i, style_.every_face);
        for (std::size_t k = 0; k < faces.count; ++k) {
            waiting.vertex[waiting.count] = i;
            waiting.depth[waiting.count] = faces.faces[k].depth;
            set_lane(waiting.normal, waiting.count, faces.faces[k].normal);
            waiting.landed[waiting.count] = k == 0 && std::isfinite(landings_.depth[i]) ? -1 : 0;
            if (++waiting.count == kPhotons) flush(waiting, out);
        }
    }

    void flush(Waiting& waiting, Band& out) const {
        if (waiting.count == 0) return;
        const Photons photons = grid_.of(std::span(waiting.vertex).first(waiting.count));
        emit(photons, grid_.hits(photons, waiting.depth, waiting.normal), photons.on,
             photons.on & waiting.landed, out);
        waiting.count = 0;
    }

    /// `landed`: on these faces, of all that they light.
    void emit(const Photons& photons, const PhotonHits& hits, Flags on, Flags landed, Band& out) const {
        const Vectors3 normal = hits.normal;
        const Vectors3 to_camera = picture_.to_camera(hits.point);
        const Floats facing_camera = dot(normal, to_camera);
        on &= (facing_camera > 0.0f) & (facing_camera * facing_camera >=
                                        kLeastViewCosine * kLeastViewCosine * dot(to_camera, to_camera));
        const Vectors3 right =
            normalized(cross(normal, choose(lanes::magnitude(normal.x) < 0.7f, all(glm::vec3(1, 0, 0)),
                                            all(glm::vec3(0, 1, 0)))));
        const Vectors3 up = cross(normal, right);
        const PlaneViews planes = picture_.look_at(hits.point, right, up);
        on &= planes.in_front;
        if (!lanes::any(on)) return;

        const Footprints footprints = style_.footprint(grid_, photons, hits);
        out.without_neighbors += static_cast<std::size_t>(
            __builtin_popcount(lanes::bits(on & landed & footprints.without_neighbors)));
        KernelMetric metric;
        metric.cell_from_first = planes.cell_from_right;
        metric.cell_from_second = planes.cell_from_up;
        const auto on_plane = [&](Vectors3 v) { return Vectors2{dot(v, right), dot(v, up)}; };
        const Vectors2 lean = on_plane(hits.beam);
        metric.beam = {1.0f - lean.x * lean.x, -lean.x * lean.y, 1.0f - lean.y * lean.y};
        metric.disc_radius = disc_ * grid_.whole_way(photons, hits);
        if (style_.disc && emitter_.any()) {
            // An ellipse of that covariance in place of the disc: its radius is two deviations.
            metric.disc_radius = all(2.0f);
            metric.beam = emitter_.inverse_covariance(photons, hits, right, up);
        }
        const Vectors2 first = on_plane(footprints.first), second = on_plane(footprints.second);
        const std::size_t bases = style_.reduced ? 3 : 1;
        const ReducedLattice lattice = style_.reduced
                                           ? reduce_lattice(first, second, reduction_metric(metric))
                                           : ReducedLattice{{{first, second, all(1.0f)}, {}, {}}};
        const Plane plane{hits, cross(right, hits.beam), cross(up, hits.beam), dot(hits.beam, normal),
                          footprints.gain * power_.at(photons, hits)};
        for (std::size_t b = 0; b < bases; ++b) {
            const Flags has = on & ~(lattice[b].weight == 0.0f);
            if (lanes::any(has)) emit(plane, planes, metric, lattice[b], has, out);
        }
    }

    struct Plane {
        const PhotonHits& hits;
        Vectors3 right_by_beam, up_by_beam;  ///< cross products of the plane's vectors with the beam
        Floats facing;                       ///< cosine of beam and normal, negative
        Vectors3 power;                      ///< W
    };

    void emit(const Plane& plane, const PlaneViews& planes, const KernelMetric& metric,
              const LatticeBasis& basis, Flags on, Band& out) const {
        const PlaneKernel kernel = widened_kernel(basis, metric, style_.kernel);
        const PictureCorners corners = picture_.corners(planes, kernel.first, kernel.second);
        PictureCovers covers;
        const Flags seen = picture_.box(corners, covers);
        const Floats area = cross(kernel.first, kernel.second);
        const Floats inverse = 1.0f / area, scale = inverse / plane.facing;
        // Dual vectors of (first, second, beam): perpendicular to the beam, so that a receiver off the plane
        // is taken along the beam.
        const auto by_beam = [&](Vectors2 v) { return v.x * plane.right_by_beam + v.y * plane.up_by_beam; };
        const Vectors3 axis_a = scale * by_beam(kernel.second), axis_b = -scale * by_beam(kernel.first);
        const Vectors3 irradiance = (basis.weight * lanes::magnitude(inverse)) * plane.power;
        const Floats longest_square =
            lanes::greater(dot(kernel.first, kernel.first), dot(kernel.second, kernel.second));
        const Floats tolerance =
            kPlaneTolerance * lanes::square_root<float>(longest_square) * lanes::magnitude(plane.facing);
        const Flags drawable = finite(axis_a.x + axis_a.y + axis_a.z + axis_b.x + axis_b.y + axis_b.z) &
                               finite(irradiance.x + irradiance.y + irradiance.z) & finite(tolerance);
        if (const Flags flat = on & ~drawable; lanes::any(flat))
            out.lost += power_of(plane.power, basis.weight, flat & picture_.holds(planes));
        on &= seen & drawable;
        const Flags quads = on & ~fit_points(corners, on, covers);

        const PhotonHits& hits = plane.hits;
        // Its sign is the medium's, so that it must not be 0.
        const Floats above_zero = lanes::greater(tolerance, lanes::splat(std::numeric_limits<float>::min()));
        const Floats signed_tolerance = mesh_.in_water() ? above_zero : -above_zero;
        std::array<std::array<Floats, kPhotons>, 3> rows = {
            {{hits.point.x, hits.point.y, hits.point.z, signed_tolerance, axis_a.x, axis_a.y, axis_a.z,
              kernel.box_first},
             {axis_b.x, axis_b.y, axis_b.z, kernel.box_second, irradiance.x, irradiance.y, irradiance.z,
              hits.normal.x},
             {hits.normal.y, hits.normal.z, covers.middle.x, covers.middle.y, covers.edge_a.x,
              covers.edge_a.y, covers.edge_b.x, covers.edge_b.y}}};
        for (std::array<Floats, kPhotons>& part : rows) lanes::transpose(part);
        const unsigned as_quads = lanes::bits(quads);
        for (unsigned left = lanes::bits(on); left != 0; left &= left - 1) {
            const auto k = static_cast<std::size_t>(__builtin_ctz(left));
            layout::Splat& splat = ((as_quads >> k & 1) != 0 ? out.quads : out.points).emplace_back();
            auto* floats = reinterpret_cast<float*>(&splat);
            for (std::size_t part = 0; part < rows.size(); ++part)
                store(floats + kPhotons * part, rows[part][k]);
        }
    }

    /// A point sprite is a square about the box, cheap to set up; a quad fits closely. Leaves in `covers`
    /// what is to be drawn.
    Flags fit_points(const PictureCorners& corners, Flags on, PictureCovers& covers) const {
        const Floats side = 2.0f * lanes::greater(covers.edge_a.x, covers.edge_b.y);
        const Flags small = side * side < kQuadSetup;
        if (!lanes::any(on & ~small)) return small;
        const PictureCovers fitted = picture_.fitted(corners, covers);
        const Floats area = 4.0f * lanes::magnitude(cross(fitted.edge_a, fitted.edge_b));
        const Flags points = small | ~((side > largest_point_) | (side * side - area > kQuadSetup));
        covers = {choose(points, covers.middle, fitted.middle), choose(points, covers.edge_a, fitted.edge_a),
                  choose(points, covers.edge_b, fitted.edge_b)};
        return points;
    }

    /// W, mean of the channels.
    static double power_of(Vectors3 power, Floats weight, Flags on) {
        double sum = 0;
        for (std::size_t k = 0; k < kPhotons; ++k) {
            const glm::vec3 own = lane(power, k);
            const float share = std::isfinite(weight[k]) ? weight[k] : 1.0f;
            if (on[k] != 0) sum += static_cast<double>(share * (own.r + own.g + own.b) / 3);
        }
        return sum;
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

void build_splats(const scene::FrameScene& scene, const media::Media& media, const light::BeamMesh& mesh,
                  const light::Landings& landings, const SplatStyle& style, float largest_point,
                  const std::function<void(const Splats&)>& take) {
    if (mesh.vertices() == 0) return;
    const Builder builder(scene, media, mesh, landings, style, largest_point);
    const std::size_t bands = builder.bands();
    const std::size_t most =
        std::max<std::size_t>(1, kStretchPhotons / (kBandRows * static_cast<std::size_t>(mesh.columns)));
    Splats splats;
    splats.points.resize(std::min(most, bands));
    splats.quads.resize(splats.points.size());
    std::vector<std::size_t> without_neighbors(splats.points.size());
    std::vector<double> lost(splats.points.size());
    for (std::size_t first = 0; first < bands; first += most) {
        const std::size_t count = std::min(most, bands - first);
        splats.points.resize(count);
        splats.quads.resize(count);
        parallel_for(count, 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                splats.points[i].clear();
                splats.points[i].reserve(kBandRows * static_cast<std::size_t>(mesh.columns));
                splats.quads[i].clear();
                Band band{splats.points[i], splats.quads[i]};
                builder.build(first + i, band);
                without_neighbors[i] = band.without_neighbors;
                lost[i] = band.lost;
            }
        });
        splats.without_neighbors = 0;
        splats.lost = 0;
        for (std::size_t i = 0; i < count; ++i) {
            splats.without_neighbors += without_neighbors[i];
            splats.lost += lost[i];
        }
        take(splats);
    }
}

}  // namespace dapple::methods
