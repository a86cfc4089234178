#include <algorithm>
#include <cmath>

#include "methods/host_raster.h"
#include "methods/photon_splatting/lane_vectors.h"
#include "methods/photon_splatting/sample_place.h"
#include "methods/photon_splatting/splat_renderer.h"

// Evaluates kernels as shaders/photon_splatting/splat_fragment.glsl does.
namespace dapple::methods {
namespace {

using lanes::greater;
using lanes::lesser;
using lanes::magnitude;
using layout::Splat;

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

/// See BandLists::draw().
template <KernelShape shape, bool paper>
class SplatBrush {
public:
    SplatBrush(const Splat& splat, const layout::SplatPush& push)
        : splat_(splat), push_(push), a_(splat.box_a), b_(splat.box_b) {
        // Both axes are perpendicular to the beam; the sign of their product cancels.
        const glm::vec3 beam = glm::cross(splat.axis_a, splat.axis_b);
        facing_ = beam / glm::dot(beam, splat.normal);
    }

    bool light(const ReceiverLanes& receivers, Flags inside, Vectors3& irradiance) const {
        Vectors3 offset = receivers.position - all(splat_.position);
        if constexpr (paper) {
            const Vectors3 away = push_.perspective != 0 ? normalized(receivers.position - all(push_.camera))
                                                         : all(-push_.camera);
            const Floats facing_camera = dot(splat_.normal, away);
            const Floats behind = -dot(splat_.normal, offset) / facing_camera;
            offset = offset + behind * away;
            inside &= (receivers.medium >= 0.0f) & (facing_camera <= -layout::kEdgeOn) &
                      (behind <= layout::kDepthBias);
        } else {
            inside &= (receivers.medium == (splat_.tolerance < 0 ? 0.0f : 1.0f)) &
                      (magnitude(dot(splat_.normal, offset)) <= std::abs(splat_.tolerance)) &
                      (dot(splat_.normal, receivers.normal) >= layout::kSmallestNormalCosine);
        }
        const Floats a = dot(splat_.axis_a, offset), b = dot(splat_.axis_b, offset);
        inside &= (magnitude(a) < 1.0f) & (magnitude(b) < 1.0f);
        if (!lanes::any(inside)) return false;
        Floats weight = a_(a) * b_(b) * greater(all(0.0f), dot(facing_, receivers.normal));
        weight = inside ? weight : all(0.0f);
        irradiance = weight * all(splat_.irradiance);
        return true;
    }

private:
    const Splat& splat_;
    const layout::SplatPush& push_;
    Profile<shape> a_, b_;
    glm::vec3 facing_{0};
};

/// See host_splat_renderer().
class HostSplatRenderer final : public SplatRenderer {
public:
    void clear() override { splats_.clear(); }
    void add(const Splats& splats) override { splats_.add(splats.points, splats.quads); }
    std::size_t points() const override { return splats_.points(); }
    std::size_t quads() const override { return splats_.quads(); }

    void render(const scene::FrameScene& scene, const SplatStyle& style,
                std::span<const view::ReceiverLayer> layers, std::span<LayerResult> results,
                FrameStats& stats) override {
        const ScopedPass pass(stats, "splatting");
        if (layers.empty()) return;
        const layout::SplatPush push = splat_push(scene);
        const BandLists<Splat> lists(splats_.list(), layers[0].height);
        for (std::size_t i = 0; i < layers.size(); ++i) {
            const SamplePlace place(layers[i].sample, scene.state.clip.samples, style.kernel.widened);
            HostLayer layer(layers[i], is_splatted,
                            [&](std::size_t pixel) { return place.of(layers[i], pixel); });
            if (style.paper_receivers)
                lists.draw<SplatBrush<KernelShape::box, true>>(layer, push);
            else if (style.kernel.shape == KernelShape::box)
                lists.draw<SplatBrush<KernelShape::box, false>>(layer, push);
            else
                lists.draw<SplatBrush<KernelShape::tent, false>>(layer, push);
            layer.read(layers[i], results[i]);
        }
    }

private:
    HostPrimitives<Splat> splats_;
};

}  // namespace

std::unique_ptr<SplatRenderer> host_splat_renderer() {
    return std::make_unique<HostSplatRenderer>();
}

}  // namespace dapple::methods
