#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <vector>

#include "base/lane_vectors.h"
#include "base/parallel.h"
#include "methods/caustic_method.h"
#include "methods/draw_list.h"
#include "scene/frame_state.h"
#include "view/receiver_layer.h"

/// Draws parallelograms of the picture on the processor, eight pixels of a row at once: additively, in their
/// order, a band of rows a thread.
namespace dapple::methods {

/// Eight neighbours of a row.
struct ReceiverLanes {
    lanes::Vectors3 position;  ///< m, relative to the frame's origin
    lanes::Vectors3 normal;    ///< unit
    lanes::Floats medium;      ///< 1 in the water, 0 in the air, -1: no receiver
};

/// What primitives are evaluated at, and the sums of their light.
class HostLayer {
public:
    /// `answers(flags)`: whether view::ReceiverFlags are those of receivers of the method. `place(pixel)`: m.
    HostLayer(const view::ReceiverLayer& layer, bool (*answers)(std::uint32_t flags),
              const std::function<glm::vec3(std::size_t pixel)>& place);

    /// Adds irradiance to eight pixels from (x, y) on; those behind the picture are nobody's.
    void add(int x, int y, const lanes::Vectors3& irradiance) {
        float* sum = row(y) + kSum * stride_ + x;
        lanes::store(sum, lanes::load(sum) + irradiance.x);
        lanes::store(sum + stride_, lanes::load(sum + stride_) + irradiance.y);
        lanes::store(sum + 2 * stride_, lanes::load(sum + 2 * stride_) + irradiance.z);
    }
    ReceiverLanes receivers(int x, int y) const {
        const float* at = row(y) + x;
        const auto array = [&](std::size_t k) { return lanes::load(at + k * stride_); };
        return {{array(kPosition), array(kPosition + 1), array(kPosition + 2)},
                {array(kNormal), array(kNormal + 1), array(kNormal + 2)},
                array(kMedium)};
    }
    /// E, and which receivers were answered for.
    void read(const view::ReceiverLayer& layer, LayerResult& result) const;

    int width() const { return width_; }
    int height() const { return height_; }

private:
    static constexpr std::size_t kPosition = 0, kNormal = 3, kMedium = 6, kSum = 7, kArrays = 10;
    const float* row(int y) const {
        return numbers_.data() + static_cast<std::size_t>(y) * kArrays * stride_;
    }
    float* row(int y) { return numbers_.data() + static_cast<std::size_t>(y) * kArrays * stride_; }

    int width_, height_;
    std::size_t stride_;          // of the arrays of a row, one after another
    std::vector<float> numbers_;  // rows
};

/// Pixels whose centres lie in the parallelogram center +- edge_a +- edge_b of a primitive, pixels.
class Extent {
public:
    template <class Primitive>
    explicit Extent(const Primitive& of)
        : center_(of.center),
          half_(glm::abs(of.edge_a) + glm::abs(of.edge_b)),
          upright_(of.edge_a.y == 0 && of.edge_b.x == 0) {
        if (upright_) return;
        const float area = of.edge_a.x * of.edge_b.y - of.edge_a.y * of.edge_b.x;
        across_a_ = glm::vec2(of.edge_b.y, -of.edge_b.x) / area;
        across_b_ = glm::vec2(-of.edge_a.y, of.edge_a.x) / area;
    }
    /// Rows from `low` on and before `high` that may have some: the first, and the one behind the last.
    std::array<int, 2> rows(int low, int high) const { return range(center_.y, half_.y, low, high); }
    std::array<int, 2> columns(int width) const { return range(center_.x, half_.x, 0, width); }
    /// Of eight pixels from (x, y) on those before column `end` that it has.
    lanes::Flags holds(int x, int y, int end) const {
        const lanes::Flags before = lanes::first_of(static_cast<std::size_t>(end - x));
        if (upright_) return before;
        const lanes::Floats right =
            lanes::Floats{0, 1, 2, 3, 4, 5, 6, 7} + (static_cast<float>(x) + 0.5f - center_.x);
        const float down = static_cast<float>(y) + 0.5f - center_.y;
        return before & (lanes::magnitude(right * across_a_.x + down * across_a_.y) <= 1.0f) &
               (lanes::magnitude(right * across_b_.x + down * across_b_.y) <= 1.0f);
    }

private:
    static std::array<int, 2> range(float center, float half, int low, int high) {
        const auto least = static_cast<float>(low), most = static_cast<float>(high);
        const auto first_from = [&](float edge) {  // what is not a number has no pixels
            const float first = edge - 0.5f;
            return static_cast<int>(std::ceil(first > least ? std::min(first, most) : least));
        };
        return {first_from(center - half), first_from(center + half)};
    }

    glm::vec2 center_, half_;
    bool upright_;                         // it is a box
    glm::vec2 across_a_{0}, across_b_{0};  // 1/pixel: coordinates along the edges
};

/// Memory of the host for a DrawList.
template <class Primitive>
struct HostPiece {
    LargeVector<Primitive> primitives;
    std::span<Primitive> room() { return primitives; }
};

/// Points and quads alike, in the order in which they come.
template <class Primitive>
class HostPrimitives {
public:
    using List = DrawList<Primitive, HostPiece<Primitive>>;

    void clear() {
        list_.clear();
        points_ = 0;
    }
    template <class Band>
    void add(const std::vector<Band>& points, const std::vector<Band>& quads) {
        const auto make = [](std::size_t room) { return HostPiece<Primitive>{LargeVector<Primitive>(room)}; };
        const std::size_t before = list_.size();
        list_.add(points, make);
        points_ += list_.size() - before;
        list_.add(quads, make);
    }
    std::size_t points() const { return points_; }
    std::size_t quads() const { return list_.size() - points_; }
    const List& list() const { return list_; }

private:
    static constexpr std::size_t kPieceBytes = std::size_t{6} << 20;
    List list_{kPieceBytes / sizeof(Primitive)};
    std::size_t points_ = 0;
};

/// Bytes of BandLists a primitive: its place, in lists that grow by doubling, in one band or a second one.
inline constexpr double kListedBytes = 10;

/// Bytes that drawing a clip's pictures takes beside the primitives: on a device so many a pixel, on the host
/// one layer and BandLists.
inline double drawing_bytes(bool on_device, const scene::Clip& clip, double device_pixel, double primitives) {
    constexpr double kHostPixel = 40;
    const double pixels = static_cast<double>(clip.width) * static_cast<double>(clip.height);
    return on_device ? pixels * device_pixel : pixels * kHostPixel + primitives * kListedBytes;
}

/// Which primitives of a list meet each band of rows of pictures of a height. The list must stay as it is.
template <class Primitive>
class BandLists {
public:
    BandLists(const typename HostPrimitives<Primitive>::List& list, int height)
        : chunks_(list.chunks()), lists_(chunks_.size()) {
        parallel_for(chunks_.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                lists_[i].resize(static_cast<std::size_t>((height + kRows - 1) / kRows));
                for (std::size_t k = 0; k < chunks_[i].count; ++k) {
                    const auto [top, bottom] = Extent(chunks_[i].memory.primitives[k]).rows(0, height);
                    if (top >= bottom) continue;
                    for (int band = top / kRows; band <= (bottom - 1) / kRows; ++band)
                        lists_[i][static_cast<std::size_t>(band)].push_back(static_cast<std::uint32_t>(k));
                }
            }
        });
    }

    /// `Brush(primitive, constants)` is asked for the light of eight receivers of which `inside` are in the
    /// primitive's extent: `bool light(receivers, inside, irradiance)`, false where there is none.
    template <class Brush, class Constants>
    void draw(HostLayer& layer, const Constants& constants) const {
        parallel_for(
            static_cast<std::size_t>(layer.height()), kRows, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = 0; i < lists_.size(); ++i)
                    for (const std::uint32_t k : lists_[i][begin / kRows]) {
                        const Primitive& primitive = chunks_[i].memory.primitives[k];
                        const Extent extent(primitive);
                        const Brush brush(primitive, constants);
                        const auto [top, bottom] =
                            extent.rows(static_cast<int>(begin), static_cast<int>(end));
                        const auto [left, right] = extent.columns(layer.width());
                        for (int y = top; y < bottom; ++y)
                            for (int x = left; x < right; x += lanes::kLanes<float>) {
                                lanes::Vectors3 irradiance;
                                if (brush.light(layer.receivers(x, y), extent.holds(x, y, right), irradiance))
                                    layer.add(x, y, irradiance);
                            }
                    }
            });
    }

private:
    static constexpr int kRows = 16;
    const std::vector<typename HostPrimitives<Primitive>::List::Chunk>& chunks_;
    /// Of a chunk, of a band: places in the chunk.
    std::vector<std::vector<std::vector<std::uint32_t>>> lists_;
};

}  // namespace dapple::methods
