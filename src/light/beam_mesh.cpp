#include "light/beam_mesh.h"

namespace dapple::light {

std::string chain_name(const scene::FrameState& state, Chain chain) {
    const std::string& name = state.lights[static_cast<std::size_t>(chain.light)].name;
    return (name.empty() ? "lights[" + std::to_string(chain.light) + "]" : name) +
           (chain.event == Event::transmission ? " > water:T" : " > water:R");
}

}  // namespace dapple::light
