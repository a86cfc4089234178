#include <algorithm>
#include <array>
#include <cmath>

#include "base/parallel.h"
#include "methods/photon_splatting/lane_vectors.h"
#include "methods/photon_splatting/sample_place.h"
#include "methods/photon_splatting/splat_list.h"
#include "methods/photon_splatting/splat_renderer.h"

// Evaluates kernels as shaders/photon_splatting/splat_fragment.glsl does, eight pixels of a row at once. A
// band of rows is one thread's, which draws the splats that meet it in their order.
namespace dapple::methods {
namespace {

using lanes::greater;
using lanes::lesser;
using lanes::magnitude;
using layout::Splat;

constexpr std::size_t kChunkSplats = 1 << 16;
constexpr int kBandRows = 16;

struct HostSplats {
    LargeVector<Splat> all;
    std::span<Splat> splats() { return all; }
};

/// What the kernels are evaluated at, and their sums: rows of `stride` pixels, the last ones behind the
/// picture.
class HostLayer {
public:
    HostLayer(const view::ReceiverLayer& layer, const SamplePlace& place)
        : width_(static_cast<std::size_t>(layer.width)),
          stride_((width_ / kPhotons + 2) * kPhotons),
          numbers_(kArrays * stride_ * static_cast<std::size_t>(layer.height), 0.0f) {
        parallel_for(
            static_cast<std::size_t>(layer.height), kBandRows, [&](std::size_t begin, std::size_t end) {
                for (std::size_t row = begin; row < end; ++row) {
                    float* to = this->row(static_cast<int>(row));
                    for (std::size_t x = 0; x < stride_; ++x) to[kMedium * stride_ + x] = kNone;
                    for (std::size_t x = 0; x < width_; ++x) {
                        const std::size_t i = row * width_ + x;
                        if (!is_splatted(layer.flags[i])) continue;
                        const glm::vec3 at = place.of(layer, i), normal = layer.shading_normal[i];
                        for (int k = 0; k < 3; ++k) {
                            to[(kPosition + static_cast<std::size_t>(k)) * stride_ + x] = at[k];
                            to[(kNormal + static_cast<std::size_t>(k)) * stride_ + x] = normal[k];
                        }
                        to[kMedium * stride_ + x] = (layer.flags[i] & view::kInWater) != 0 ? 1.0f : 0.0f;
                    }
                }
            });
    }
    void read(const view::ReceiverLayer& layer, LayerResult& result) {
        result.irradiance.resize(layer.pixels());
        result.covered.resize(layer.pixels());
        parallel_for(static_cast<std::size_t>(layer.height), kBandRows,
                     [&](std::size_t begin, std::size_t end) {
                         for (std::size_t row = begin; row < end; ++row) {
                             const float* from = this->row(static_cast<int>(row)) + kSum * stride_;
                             for (std::size_t x = 0; x < width_; ++x) {
                                 const std::size_t i = row * width_ + x;
                                 result.covered[i] = is_splatted(layer.flags[i]) ? 1 : 0;
                                 result.irradiance[i] = {from[x], from[stride_ + x], from[2 * stride_ + x]};
                             }
                         }
                     });
    }

    static constexpr float kNone = -1;  ///< medium where there is no receiver
    static constexpr std::size_t kPosition = 0, kNormal = 3, kMedium = 6, kSum = 7, kArrays = 10;
    /// The arrays of a row, one after another.
    float* row(int y) { return numbers_.data() + static_cast<std::size_t>(y) * kArrays * stride_; }
    std::size_t stride() const { return stride_; }

private:
    std::size_t width_, stride_;
    std::vector<float> numbers_;
};

/// Integral from -infinity of the tent max(0, 1 - |x|).
Floats tent_integral(Floats x) {
    x = lesser(greater(x, all(-1.0f)), all(1.0f));
    return 0.5f + x - 0.5f * x * magnitude(x);
}

/// One side of a kernel: a tent or a box of half-width 1 - box, convolved with a box of half-width `box`.
template <KernelShape shape>
class Profile {
public:
    explicit Profile(float box) : box_(box), core_(1 - box) {
        if constexpr (shape == KernelShape::tent) {
            core_ = 1 / core_;
            gain_ = box > 0 ? 1 / (2 * box) : 0;
        } else {
            most_ = 2 * std::min(core_, box);
            gain_ = 1 / (4 * core_ * box);
        }
    }
    Floats operator()(Floats x) const {
        if constexpr (shape == KernelShape::tent) {
            if (box_ == 0) return greater(all(0.0f), 1.0f - magnitude(x));
            return (tent_integral((x + box_) * core_) - tent_integral((x - box_) * core_)) * gain_;
        } else {
            return lesser(1.0f - magnitude(x), all(most_)) * gain_;
        }
    }

private:
    float box_, core_, gain_ = 1, most_ = 0;
};

/// Pixels whose centres lie in a splat's parallelogram.
struct Extent {
    explicit Extent(const Splat& splat)
        : half(glm::abs(splat.edge_a) + glm::abs(splat.edge_b)),
          upright(splat.edge_a.y == 0 && splat.edge_b.x == 0) {}
    /// First pixel from `low` on and the first behind, of an axis.
    static std::array<int, 2> pixels(float center, float half, int low, int high) {
        const auto held = [&](float x) {
            return static_cast<int>(
                std::ceil(std::clamp(x - 0.5f, static_cast<float>(low), static_cast<float>(high))));
        };
        return {held(center - half), held(center + half)};
    }
    glm::vec2 half;
    bool upright;  ///< the parallelogram is its box
};

template <KernelShape shape, bool paper>
class Brush {
public:
    Brush(const Splat& splat, const layout::SplatPush& push)
        : splat_(splat), extent_(splat), push_(push), a_(splat.box_a), b_(splat.box_b) {
        // Both axes are perpendicular to the beam; the sign of their product cancels.
        const glm::vec3 beam = glm::cross(splat.axis_a, splat.axis_b);
        facing_ = beam / glm::dot(beam, splat.normal);
        const float area = splat.edge_a.x * splat.edge_b.y - splat.edge_a.y * splat.edge_b.x;
        across_a_ = glm::vec2(splat.edge_b.y, -splat.edge_b.x) / area;
        across_b_ = glm::vec2(-splat.edge_a.y, splat.edge_a.x) / area;
    }

    void draw(HostLayer& layer, int first_row, int end_row, int width) const {
        const auto [top, bottom] = Extent::pixels(splat_.center.y, extent_.half.y, first_row, end_row);
        const auto [left, right] = Extent::pixels(splat_.center.x, extent_.half.x, 0, width);
        for (int y = top; y < bottom; ++y) {
            float* row = layer.row(y);
            for (int x = left; x < right; x += static_cast<int>(kPhotons))
                draw(row + x, layer.stride(), x, y, right);
        }
    }

private:
    void draw(float* at, std::size_t stride, int x, int y, int right) const {
        const auto array = [&](std::size_t k) { return load(at + k * stride); };
        const Floats medium = array(HostLayer::kMedium);
        const Vectors3 receiver{array(HostLayer::kPosition), array(HostLayer::kPosition + 1),
                                array(HostLayer::kPosition + 2)};
        const Vectors3 receiver_normal{array(HostLayer::kNormal), array(HostLayer::kNormal + 1),
                                       array(HostLayer::kNormal + 2)};
        Flags lit = first_of(static_cast<std::size_t>(right - x));
        if (!extent_.upright) lit &= in_parallelogram(x, y);
        Vectors3 offset = receiver - all(splat_.position);
        if constexpr (paper) {
            const Vectors3 away =
                push_.perspective != 0 ? normalized(receiver - all(push_.camera)) : all(-push_.camera);
            const Floats facing_camera = dot(splat_.normal, away);
            const Floats behind = -dot(splat_.normal, offset) / facing_camera;
            offset = offset + behind * away;
            lit &= (medium != HostLayer::kNone) & (facing_camera <= -layout::kEdgeOn) &
                   (behind <= layout::kDepthBias);
        } else {
            lit &= (medium == (splat_.tolerance < 0 ? 0.0f : 1.0f)) &
                   (magnitude(dot(splat_.normal, offset)) <= std::abs(splat_.tolerance)) &
                   (dot(splat_.normal, receiver_normal) >= layout::kSmallestNormalCosine);
        }
        const Floats a = dot(splat_.axis_a, offset), b = dot(splat_.axis_b, offset);
        lit &= (magnitude(a) < 1.0f) & (magnitude(b) < 1.0f);
        if (!lanes::any(lit)) return;
        Floats weight = a_(a) * b_(b) * greater(all(0.0f), dot(facing_, receiver_normal));
        weight = lit ? weight : all(0.0f);
        for (int k = 0; k < 3; ++k) {
            float* sum = at + (HostLayer::kSum + static_cast<std::size_t>(k)) * stride;
            store(sum, load(sum) + weight * splat_.irradiance[k]);
        }
    }

    Flags in_parallelogram(int x, int y) const {
        const Floats right =
            Floats{0, 1, 2, 3, 4, 5, 6, 7} + (static_cast<float>(x) + 0.5f - splat_.center.x);
        const float down = static_cast<float>(y) + 0.5f - splat_.center.y;
        return (magnitude(right * across_a_.x + down * across_a_.y) <= 1.0f) &
               (magnitude(right * across_b_.x + down * across_b_.y) <= 1.0f);
    }

    const Splat& splat_;
    Extent extent_;
    const layout::SplatPush& push_;
    Profile<shape> a_, b_;
    glm::vec3 facing_{0};
    glm::vec2 across_a_{0}, across_b_{0};  ///< 1/pixel: coordinates in the parallelogram
};

/// See host_splat_renderer().
class HostSplatRenderer final : public SplatRenderer {
public:
    void clear() override {
        splats_.clear();
        points_ = quads_ = 0;
    }
    void add(const Splats& splats) override {
        const auto make = [](std::size_t) { return HostSplats{LargeVector<Splat>(kChunkSplats)}; };
        const std::size_t before = splats_.size();
        splats_.add(splats.points, make);
        points_ += splats_.size() - before;
        splats_.add(splats.quads, make);
        quads_ = splats_.size() - points_;
    }
    std::size_t points() const override { return points_; }
    std::size_t quads() const override { return quads_; }

    void render(const scene::FrameScene& scene, const SplatStyle& style,
                std::span<const view::ReceiverLayer> layers, std::span<LayerResult> results,
                FrameStats& stats) override {
        const ScopedPass pass(stats, "splatting");
        if (layers.empty()) return;
        const layout::SplatPush push = splat_push(scene);
        const auto lists = bands(layers[0].height);
        for (std::size_t i = 0; i < layers.size(); ++i) {
            const SamplePlace place(layers[i].sample, scene.state.clip.samples, style.kernel.widened);
            HostLayer layer(layers[i], place);
            const auto draw = [&]<class Shaped>(const std::type_identity<Shaped>&) {
                draw_bands<Shaped>(layer, layers[i], lists, push);
            };
            if (style.paper_receivers)
                draw(std::type_identity<Brush<KernelShape::box, true>>());
            else if (style.kernel.shape == KernelShape::box)
                draw(std::type_identity<Brush<KernelShape::box, false>>());
            else
                draw(std::type_identity<Brush<KernelShape::tent, false>>());
            layer.read(layers[i], results[i]);
        }
    }

private:
    using Lists = std::vector<std::vector<std::vector<const Splat*>>>;  ///< of a chunk, of a band of rows

    /// Which splats meet each band of rows of a picture.
    Lists bands(int height) const {
        const auto& chunks = splats_.chunks();
        Lists lists(chunks.size());
        parallel_for(chunks.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                auto& of_chunk = lists[i];
                of_chunk.resize(static_cast<std::size_t>((height + kBandRows - 1) / kBandRows));
                for (std::size_t k = 0; k < chunks[i].count; ++k) {
                    const Splat& splat = chunks[i].memory.all[k];
                    const auto [top, bottom] =
                        Extent::pixels(splat.center.y, Extent(splat).half.y, 0, height);
                    if (top >= bottom) continue;
                    for (int band = top / kBandRows; band <= (bottom - 1) / kBandRows; ++band)
                        of_chunk[static_cast<std::size_t>(band)].push_back(&splat);
                }
            }
        });
        return lists;
    }

    template <class Shaped>
    static void draw_bands(HostLayer& to, const view::ReceiverLayer& layer, const Lists& lists,
                           const layout::SplatPush& push) {
        parallel_for(static_cast<std::size_t>(layer.height), kBandRows,
                     [&](std::size_t begin, std::size_t end) {
                         for (const auto& of_chunk : lists)
                             for (const Splat* splat : of_chunk[begin / kBandRows])
                                 Shaped(*splat, push)
                                     .draw(to, static_cast<int>(begin), static_cast<int>(end), layer.width);
                     });
    }

    SplatList<HostSplats> splats_{kChunkSplats};
    std::size_t points_ = 0, quads_ = 0;
};

}  // namespace

std::unique_ptr<SplatRenderer> host_splat_renderer() {
    return std::make_unique<HostSplatRenderer>();
}

}  // namespace dapple::methods
