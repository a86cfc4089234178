#include "methods/caustic_mesh/cell_builder.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/parallel.h"
#include "light/grid_blocks.h"
#include "methods/caustic_mesh/cell_drawing.h"
#include "methods/caustic_mesh/cell_images.h"

namespace dapple::methods::caustic_mesh {
namespace {

// Cells at edges are cut until they are half a pixel wide, or so many parts along each side.
constexpr float kFinestPixels = 0.5f;
constexpr float kMostParts = 8;
// Share of the light by which the linear interpolation of cascades' shares may miss the bilinear one.
constexpr float kShareTolerance = 2e-4f;

/// Places of the corners of a cell, rows and columns.
constexpr std::array<std::array<std::size_t, 2>, 4> kPlaces{{{0, 0}, {0, 1}, {1, 1}, {1, 0}}};

class Builder {
public:
    Builder(const LandedMesh& mesh, const CellDrawing& drawing)
        : mesh_(mesh), drawing_(drawing), images_(mesh) {}

    struct Out {
        std::vector<layout::MeshCell> points, quads;
        std::size_t cut = 0, widened = 0, left_out = 0, overfull = 0;
        double lost = 0;
    };

    /// The cell whose last ray in row and column is (row, column); rays beyond the grid are missing.
    void build(std::size_t row, std::size_t column, Out& out) const {
        Corners corners;
        std::array<bool, 4> there{};
        bool lit = false, near_edge = false;
        float twist = 0;
        for (std::size_t k = 0; k < 4; ++k) {
            const std::size_t r = row + kPlaces[k][0], c = column + kPlaces[k][1];
            if (r == 0 || c == 0 || r > mesh_.rows() || c > mesh_.columns()) continue;
            const std::size_t i = (r - 1) * mesh_.columns() + c - 1;
            there[k] = mesh_.mesh().valid[i] != 0;
            corners[k] = mesh_.ray(i);
            lit = lit || corners[k].flux > 0;
            if (!mesh_.mesh().weight.empty()) twist += (k % 2 == 0 ? 1.0f : -1.0f) * mesh_.mesh().weight[i];
            near_edge = near_edge || mesh_.near_edge(i) || (mesh_.shadowed() && !(corners[k].flux > 0));
        }
        if (!lit) return;
        bool whole = true;
        for (std::size_t k = 0; k < 4; ++k)
            whole = whole && there[k] && mesh_.connected(corners[k], corners[(k + 1) % 4]);
        if (!whole) {
            for (std::size_t k = 0; k < 4; ++k)
                if (corners[k].landed()) lay_share_of(corners, k, 1, out);
        } else if (near_edge || std::abs(twist) > 4 * kShareTolerance) {
            // Where ramps of two directions cross, shares sum to one by bilinear interpolation.
            const float parts = std::ceil(std::sqrt(std::abs(twist) / (4 * kShareTolerance)));
            build_parts(corners, row - 1, column - 1, std::clamp(parts, 1.0f, kMostParts), out);
        } else {
            lay(corners, faces_of(corners), 1, out);
        }
    }

    /// As Ouyang & Yang 2020: two triangles, each where its corners land on one surface.
    void build_paper(std::size_t row, std::size_t column, Out& out) const {
        if (row + 1 >= mesh_.rows() || column + 1 >= mesh_.columns()) return;
        Corners corners;
        for (std::size_t k = 0; k < 4; ++k)
            corners[k] = mesh_.ray((row + kPlaces[k][0]) * mesh_.columns() + column + kPlaces[k][1]);
        for (const std::array<std::size_t, 3>& t : {std::array<std::size_t, 3>{0, 1, 2}, {0, 2, 3}}) {
            const Corners triangle{corners[t[0]], corners[t[1]], corners[t[2]], corners[t[2]]};
            if (std::none_of(triangle.begin(), triangle.end(),
                             [](const MeshRay& ray) { return ray.flux > 0; }))
                continue;
            bool valid = true;
            for (std::size_t k = 0; k < 3; ++k)
                valid = valid && triangle[k].landed() && triangle[(k + 1) % 3].landed() &&
                        mesh_.connected(triangle[k], triangle[(k + 1) % 3]) &&
                        same_face(triangle[k], triangle[(k + 1) % 3]);
            if (!valid) {
                ++out.left_out;
                continue;
            }
            CellImage image = images_.landed(triangle, 1);
            if (!drawing_.seen(image.cell)) continue;
            images_.carry(triangle, image);
            layout::MeshCell drawn;
            take(drawing_.draw_paper(image.cell, drawn), drawn, image.cell, true, out);
        }
    }

private:
    /// Where rays do not span a cell, at an edge of the water, where a crest hides what lies between, and on
    /// faces that not all of them meet: a ray's own share of a cell that rays parallel to it span.
    void lay_share_of(const Corners& corners, std::size_t k, float share, Out& out) const {
        Corners own;
        const float side = std::sqrt(share);
        for (std::size_t j = 0; j < 4; ++j)
            own[j] = mesh_.beside(
                corners[k], side * (static_cast<float>(kPlaces[j][1]) - static_cast<float>(kPlaces[k][1])),
                side * (static_cast<float>(kPlaces[j][0]) - static_cast<float>(kPlaces[k][0])));
        own[k] = corners[k];
        own[k].area = 0;
        CellImage image;
        if (images_.on_plane(own, own[k], share, image)) emit(own, image, out);
    }

    /// Near edges of objects a cell is laid onto all faces that it lies beside in the picture, so that pixels
    /// at an edge have the light of all their part, and is cut into parts where it lands on several.
    /// `least`: parts along each side.
    void build_parts(const Corners& corners, std::size_t row, std::size_t column, float least,
                     Out& out) const {
        Faces faces = faces_of(corners);
        Corners lit = corners;
        const bool in_shadow = light_up(lit);
        const bool even = faces.count() == 1 && all_land(corners) && !in_shadow;
        const std::size_t rings = rings_about(corners, faces);
        for (std::size_t r = row - std::min(row, rings); r <= std::min(mesh_.rows() - 1, row + 1 + rings);
             ++r)
            for (std::size_t c = column - std::min(column, rings);
                 c <= std::min(mesh_.columns() - 1, column + 1 + rings); ++c)
                faces.add(mesh_.ray(r * mesh_.columns() + c));
        if (faces.overfull()) ++out.overfull;
        const auto parts = static_cast<std::size_t>(even ? least : std::max(least, parts_of(corners, faces)));
        if (parts == 1) {
            lay(corners, faces, 1, out);
            return;
        }
        ++out.cut;
        // Rays between those of the corners, bilinear as what the map holds nearly is, traced anew.
        const std::size_t side = parts + 1;
        std::vector<MeshRay> rays(side * side);
        for (std::size_t r = 0; r < side; ++r)
            for (std::size_t c = 0; c < side; ++c)
                rays[r * side + c] = between(lit, static_cast<float>(c) / static_cast<float>(parts),
                                             static_cast<float>(r) / static_cast<float>(parts));
        if (in_shadow) {
            const std::vector<std::uint8_t> hidden = mesh_.in_shadow(rays);
            for (std::size_t i = 0; i < rays.size(); ++i)
                if (hidden[i] != 0) rays[i].flux = 0;
        }
        mesh_.land(rays);
        for (const MeshRay& ray : rays) faces.add(ray);
        const float share = 1 / static_cast<float>(parts * parts);
        for (std::size_t r = 0; r < parts; ++r)
            for (std::size_t c = 0; c < parts; ++c)
                lay({rays[r * side + c], rays[r * side + c + 1], rays[(r + 1) * side + c + 1],
                     rays[(r + 1) * side + c]},
                    faces, share, out);
    }

    /// Gives corners in the shadow of objects the mean flux of the others; false where there are none.
    bool light_up(Corners& corners) const {
        float flux = 0;
        int lit = 0;
        for (const MeshRay& ray : corners) {
            flux += ray.flux;
            lit += ray.flux > 0 ? 1 : 0;
        }
        if (!mesh_.shadowed() || lit == 4) return false;
        const std::vector<std::uint8_t> hidden = mesh_.in_shadow(corners);
        bool any = false;
        for (std::size_t k = 0; k < 4; ++k) {
            if (corners[k].flux > 0 || hidden[k] == 0) continue;
            corners[k].flux = flux / static_cast<float>(lit);
            any = true;
        }
        return any;
    }

    static MeshRay between(const Corners& corners, float x, float y) {
        const std::array<float, 4> weight{(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y};
        MeshRay ray;
        ray.tint = glm::vec3(0);
        for (std::size_t k = 0; k < 4; ++k) {
            ray.origin += weight[k] * corners[k].origin;
            ray.slope += weight[k] * corners[k].slope;
            ray.start += weight[k] * corners[k].start;
            ray.flux += weight[k] * corners[k].flux;
            ray.tint += weight[k] * corners[k].tint;
            ray.disc.add(weight[k], corners[k].disc);
        }
        return ray;
    }

    static Faces faces_of(const Corners& corners) {
        Faces faces;
        for (const MeshRay& ray : corners) faces.add(ray);
        return faces;
    }

    static bool all_land(const Corners& corners) {
        return std::all_of(corners.begin(), corners.end(),
                           [](const MeshRay& ray) { return !(ray.flux > 0) || ray.landed(); });
    }

    static bool on_one_face(const Corners& corners) {
        for (std::size_t k = 0; k < 4; ++k)
            if (!corners[k].landed() || !same_face(corners[k], corners[(k + 1) % 4])) return false;
        return same_face(corners[0], corners[2]);
    }

    /// Cells about this one that the filter of a pixel may reach from it.
    std::size_t rings_about(const Corners& corners, const Faces& faces) const {
        CellImage image;
        float rings = 1;
        for (const MeshRay& on : faces)
            if (images_.on_plane(corners, on, 1, image))
                rings = std::max(rings, drawing_.filter(image.cell) / drawing_.width(image.cell));
        return static_cast<std::size_t>(
            std::ceil(std::min(rings, static_cast<float>(LandedMesh::kMostRings))));
    }

    /// Into how many parts along each side a cell that lands on several faces is cut.
    float parts_of(const Corners& corners, const Faces& faces) const {
        float widest = 0;
        CellImage image;
        for (const MeshRay& on : faces)
            if (images_.on_plane(corners, on, 1, image) && drawing_.seen(image.cell))
                widest = std::max(widest, drawing_.width(image.cell));
        return std::clamp(std::ceil(widest / kFinestPixels), 1.0f, kMostParts);
    }

    /// Where the corners landed, if that is one face, and on the planes of all others.
    void lay(const Corners& corners, const Faces& faces, float share, Out& out) const {
        const bool even = on_one_face(corners);
        if (even) {
            CellImage image = images_.landed(corners, share);
            emit(corners, image, out);
        }
        for (const MeshRay& on : faces) {
            if (even && std::any_of(corners.begin(), corners.end(),
                                    [&](const MeshRay& ray) { return same_face(ray, on); }))
                continue;
            CellImage image;
            if (images_.on_plane(corners, on, share, image)) {
                emit(corners, image, out);
                continue;
            }
            for (std::size_t k = 0; k < 4; ++k)
                if (corners[k].landed() && same_face(corners[k], on)) lay_share_of(corners, k, share, out);
        }
    }

    void emit(const Corners& corners, CellImage& image, Out& out) const {
        if (!drawing_.seen(image.cell)) return;
        images_.carry(corners, image);
        layout::MeshCell drawn;
        bool widened;
        const Drawn how = drawing_.draw(image.cell, drawn, widened);
        if (how != Drawn::not_seen && widened) ++out.widened;
        take(how, drawn, image.cell, false, out);
    }

    static void take(Drawn how, const layout::MeshCell& drawn, const LandedCell& cell, bool paper, Out& out) {
        if (how == Drawn::as_point) out.points.push_back(drawn);
        if (how == Drawn::as_quad) out.quads.push_back(drawn);
        if (how == Drawn::lost) out.lost += static_cast<double>(CellDrawing::carried(cell, paper));
    }

    const LandedMesh& mesh_;
    const CellDrawing& drawing_;
    CellImages images_;
};

}  // namespace

void build_cells(const scene::FrameScene& scene, const media::Media& media, const light::BeamMesh& mesh,
                 const light::Landings& landings, const rays::RayScene& rays, float largest_point, bool paper,
                 const std::function<void(const Cells&)>& take) {
    if (mesh.vertices() == 0) return;
    const LandedMesh landed(scene, media, mesh, landings, rays);
    const CellDrawing drawing(scene, mesh.in_water(), largest_point);
    const Builder builder(landed, drawing);
    const light::GridBlocks blocks(mesh.rows + 1, mesh.columns + 1);
    const std::size_t columns = landed.columns() + 1;
    const std::size_t stretch = std::max<std::size_t>(1, kStretch / blocks.band_size());
    for (std::size_t first = 0; first < blocks.bands(); first += stretch) {
        std::vector<Builder::Out> bands(std::min(stretch, blocks.bands() - first));
        parallel_for(bands.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t band = begin; band < end; ++band)
                blocks.visit_band(first + band, [&](std::size_t i) {
                    if (paper) {
                        builder.build_paper(i / columns, i % columns, bands[band]);
                    } else {
                        builder.build(i / columns, i % columns, bands[band]);
                    }
                });
        });
        Cells cells;
        for (Builder::Out& band : bands) {
            cells.points.push_back(std::move(band.points));
            cells.quads.push_back(std::move(band.quads));
            cells.cut += band.cut;
            cells.widened += band.widened;
            cells.left_out += band.left_out;
            cells.overfull += band.overfull;
            cells.lost += band.lost;
        }
        take(cells);
    }
}

}  // namespace dapple::methods::caustic_mesh
