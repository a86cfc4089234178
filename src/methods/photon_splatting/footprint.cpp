#include "methods/photon_splatting/footprint.h"

namespace dapple::methods {

SplatStyle splat_style(const scene::Caustics& caustics) {
    using Name = scene::PhotonFootprint;
    const bool paper = caustics.map.paper_faithful;
    SplatStyle style;
    style.kernel.scale = static_cast<float>(caustics.photon_splatting.footprint_scale);
    const Name name = caustics.photon_splatting.footprint;
    if (name == Name::tent) return style;  // is of no paper
    style.kernel.shape = KernelShape::box;
    if (paper) {
        style.kernel.widened = name == Name::point;
        style.reduced = style.disc = style.every_face = false;
        style.paper_receivers = true;
    }
    switch (name) {
        case Name::fixed:
            style.footprint = paper ? paper_fixed_footprint : fixed_footprint;
            style.reduced = false;
            style.paper_power = paper;
            break;
        case Name::photon_differential:
            style.footprint = paper ? paper_differential_footprint : differential_footprint;
            style.paper_power = paper;
            break;
        case Name::photon_difference:
            style.footprint = paper ? paper_difference_footprint : difference_footprint;
            break;
        case Name::point:
            style.footprint = paper ? paper_point_footprint : point_footprint;
            style.reduced = style.disc = style.every_face = false;
            break;
        case Name::tent:
            break;
    }
    return style;
}

}  // namespace dapple::methods
