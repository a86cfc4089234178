#pragma once
#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "methods/sliced_beams/layer_tiles.h"
#include "methods/sliced_beams/sheet_coverage.h"
#include "scene/frame_scene.h"

namespace dapple::methods::sliced_beams {

/// E of receivers that lie much closer together than the sun's disc blurs the light on them: found at the
/// nodes of a lattice and interpolated by bicubic convolution (Keys 1981), since hundreds of beams may reach
/// each. Nodes are receivers like others, about a quarter of the blur apart, on planes that the scene alone
/// gives: the faces of planes and boxes, and tangent planes of patches of a sphere. So a node's light does
/// not depend on who asks for it. Meshes, and receivers whose own footprint is not small against the
/// lattice, are left out.
class LightLattice {
public:
    using Sheets = std::span<const std::unique_ptr<SheetCoverage<float>>>;

    /// Eight by eight nodes.
    struct BlockKey {
        std::uint32_t sheet, object, patch;
        std::int32_t level;  ///< of the spacing
        std::int32_t row, column;
        // clang-tidy 14 takes the 0 that the default compares with for a pointer.
        auto operator<=>(const BlockKey&) const = default;  // NOLINT(modernize-use-nullptr)
    };
    struct Request {
        BlockKey key;
        std::uint64_t nodes;  ///< bit 8 * row + column
    };
    /// Which receivers of a group a sheet is asked for one by one, and which are interpolated; indices. The
    /// edge of a shadow lies between nodes: where an object hides light from any of a receiver's, the
    /// receiver is asked for itself.
    struct Split {
        std::vector<std::size_t> alone, shared;
    };

    /// The sheets, of one frame, must outlive this.
    LightLattice(const scene::FrameScene& scene, Sheets sheets);

    /// Whether the sheet's disc is wide enough for any receiver.
    bool blurs(std::size_t sheet) const { return sheets_[sheet]->blurs(); }
    /// Adds the nodes that the group's shared receivers need.
    void ask(std::size_t sheet, const ReceiverGroup& group, std::vector<Request>& requests) const;
    /// Finds the light of all nodes asked for. The same bits in whatever parts and order they are asked for.
    void find(std::vector<Request> requests, QueryCounts& counts);
    std::size_t nodes() const { return nodes_; }
    /// Adds the sheet's irradiance [W/m^2] of the shared receivers among the group's.
    void add(std::size_t sheet, const ReceiverGroup& group, std::span<const std::size_t> shared,
             std::span<glm::vec3> irradiance) const;

    /// Adds the sheet's irradiance [W/m^2] of all the group's receivers: what the lattice shares, and by
    /// `alone(group, irradiance)` that of the others.
    template <class Alone>
    void add_with(std::size_t sheet, const ReceiverGroup& group, std::span<glm::vec3> irradiance,
                  Alone&& alone) const {
        const Split parts = split(sheet, group);
        if (parts.shared.empty()) return alone(group, irradiance);
        add(sheet, group, parts.shared, irradiance);
        if (parts.alone.empty()) return;
        std::vector<glm::vec3> others(parts.alone.size(), glm::vec3(0));
        alone(group.only(parts.alone), std::span<glm::vec3>(others));
        for (std::size_t k = 0; k < others.size(); ++k) irradiance[parts.alone[k]] += others[k];
    }

private:
    /// A plane that receivers lie on, relative to FrameScene::origin.
    struct Patch {
        std::uint32_t index;
        glm::dvec3 point, normal;
    };
    /// A lattice on a patch: nodes at point + column * u + row * v.
    struct Axes {
        glm::dvec3 u, v;        ///< m a step
        glm::dvec3 to_u, to_v;  ///< 1/m: steps of an offset
    };
    struct Place {
        BlockKey plane;  ///< of the block at 0, 0
        double column, row;
        double facing;  ///< of the receiver's normal against the light, over the patch's
    };
    struct Block {
        BlockKey key;
        std::array<glm::vec3, 64> irradiance;
        std::uint64_t hidden;  ///< nodes from which an object keeps some of the light; bits as in Request
    };
    struct Shape {
        scene::Shape shape;
        glm::dvec3 half;
        glm::dmat4 world_from_object, object_from_world;
        glm::dmat3 normals_from_object;
    };

    std::optional<Patch> patch_of(std::uint32_t object, const Receiver<float>& receiver) const;
    Patch patch(std::uint32_t object, std::uint32_t index) const;
    std::optional<Axes> axes(std::size_t sheet, const Patch& patch, int level) const;
    std::optional<Place> place(std::size_t sheet, std::uint32_t object,
                               const Receiver<float>& receiver) const;
    const Block& block(const BlockKey& key) const;
    /// Of receivers whose nodes have been found.
    Split split(std::size_t sheet, const ReceiverGroup& group) const;
    bool near_shadow(const Place& place) const;
    void fill(const Request& request, Block& block, QueryCounts& counts) const;

    Sheets sheets_;
    std::vector<Shape> shapes_;
    std::vector<Block> blocks_;  ///< by key
    std::size_t nodes_ = 0;
};

}  // namespace dapple::methods::sliced_beams
