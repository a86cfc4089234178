#include "base/lane_vectors.h"
#include "methods/caustic_mesh/cell_renderer.h"
#include "methods/caustic_mesh/lane_coverage.h"
#include "methods/host_raster.h"

// Evaluates cells as shaders/caustic_mesh/cell_fragment.glsl does.
namespace dapple::methods::caustic_mesh {
namespace {

using lanes::all;
using lanes::choose;
using lanes::Flags;
using lanes::Floats;
using lanes::greater;
using lanes::lesser;
using lanes::Vectors2;
using lanes::Vectors3;
using layout::MeshCell;
using layout::MeshPush;

/// See BandLists::draw().
class CellBrush {
public:
    CellBrush(const MeshCell& cell, const MeshPush& push) : cell_(cell), push_(push) {}

    bool light(const ReceiverLanes& receivers, Flags inside, Vectors3& irradiance) const {
        const auto way = [&](const glm::vec3& corner) { return all(corner) - receivers.position; };
        const Vectors3 way_0 = way(cell_.corner_0), way_1 = way(cell_.corner_1), way_2 = way(cell_.corner_2),
                       way_3 = way(cell_.corner_3);
        const Floats off = 0.25f * dot(cell_.normal, way_0 + way_1 + way_2 + way_3);
        inside &= (receivers.medium == cell_.in_water) & (lanes::magnitude(off) <= cell_.tolerance) &
                  (dot(cell_.normal, receivers.normal) >= layout::kSmallestNormalCosine);
        if (!lanes::any(inside)) return false;

        // Derivatives of the picture's coordinates by the place, at the receiver, over the filter's size.
        const auto along = [&](const glm::vec4& row) {
            return dot(glm::vec3(row), receivers.position) + row.w;
        };
        const Floats w = along(push_.row_w);
        const auto derivatives = [&](const glm::vec4& row) {
            const Floats coordinate = along(row) / w;
            return (1.0f / w) * (all(glm::vec3(row)) - coordinate * all(glm::vec3(push_.row_w)));
        };
        Vectors3 to_x = derivatives(push_.row_x), to_y = derivatives(push_.row_y);
        // By rays that are moved across the beam, and with it along the plane.
        const auto filter_size = [&](const Vectors3& to, float own) {
            const Vectors3 by_rays = to - dot(cell_.facing, to) * all(cell_.normal);
            return lanes::square_root<float>(own * own + cell_.disc * dot(by_rays, by_rays));
        };
        const Floats size_x = filter_size(to_x, push_.filter_0.z),
                     size_y = filter_size(to_y, push_.filter_0.w);
        to_x = (1.0f / size_x) * to_x;
        to_y = (1.0f / size_y) * to_y;
        const Vectors2 shift{0.5f - push_.filter_0.x / size_x, 0.5f - push_.filter_0.y / size_y};
        const auto in_filter = [&](const Vectors3& to) {
            return Vectors2{dot(to_x, to), dot(to_y, to)} + shift;
        };
        const Vectors2 p_0 = in_filter(way_0), p_1 = in_filter(way_1), p_2 = in_filter(way_2),
                       p_3 = in_filter(way_3);
        const auto meets = [](Floats a, Floats b, Floats c, Floats d) {
            return (lesser(lesser(a, b), lesser(c, d)) < 1.0f) &
                   (greater(greater(a, b), greater(c, d)) > 0.0f);
        };
        inside &= meets(p_0.x, p_1.x, p_2.x, p_3.x) & meets(p_0.y, p_1.y, p_2.y, p_3.y);
        if (!lanes::any(inside)) return false;

        const Vectors3 diagonal = edge_moments(p_2, p_0);
        const Vectors3 first =
            barycentric_integrals(p_0, p_1, p_2, edge_moments(p_0, p_1) + edge_moments(p_1, p_2) + diagonal);
        const Vectors3 second =
            barycentric_integrals(p_0, p_2, p_3, edge_moments(p_2, p_3) + edge_moments(p_3, p_0) - diagonal);
        const Vectors3 sum =
            (first.x + second.x) * all(cell_.irradiance_0) + first.y * all(cell_.irradiance_1) +
            (first.z + second.y) * all(cell_.irradiance_2) + second.z * all(cell_.irradiance_3);
        const Floats cosine = greater(all(0.0f), dot(cell_.facing, receivers.normal));
        irradiance = choose(inside, cosine * sum, all(glm::vec3(0)));
        return true;
    }

private:
    const MeshCell& cell_;
    const MeshPush& push_;
};

/// See host_cell_renderer().
class HostCellRenderer final : public CellRenderer {
public:
    void clear() override { cells_.clear(); }
    void add(const Cells& cells) override { cells_.add(cells.points, cells.quads); }
    std::size_t points() const override { return cells_.points(); }
    std::size_t quads() const override { return cells_.quads(); }

    void render(const scene::FrameScene& scene, bool at_point, std::span<const view::ReceiverLayer> layers,
                std::span<LayerResult> results, FrameStats& stats) override {
        const ScopedPass pass(stats, "mesh raster");
        if (layers.empty()) return;
        MeshPush push = mesh_push(scene);
        const BandLists<MeshCell> lists(cells_.list(), layers[0].height);
        for (std::size_t i = 0; i < layers.size(); ++i) {
            push.filter_0 = filter_of(layers[i].sample, scene.state.clip.samples, at_point);
            HostLayer layer(layers[i], is_lit_by_cells,
                            [&](std::size_t pixel) { return layers[i].position[pixel]; });
            lists.draw<CellBrush>(layer, push);
            layer.read(layers[i], results[i]);
        }
    }

private:
    HostPrimitives<MeshCell> cells_;
};

}  // namespace

std::unique_ptr<CellRenderer> host_cell_renderer() {
    return std::make_unique<HostCellRenderer>();
}

}  // namespace dapple::methods::caustic_mesh
