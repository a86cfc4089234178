#include "light/beam_mesh.h"

namespace dapple::light {

std::string chain_name(const scene::FrameState& state, Chain chain) {
    const auto name_of = [](const std::string& name, const char* list, int index) {
        return name.empty() ? list + ("[" + std::to_string(index) + "]") : name;
    };
    const std::string surface =
        chain.object == kWater
            ? "water"
            : name_of(state.objects[static_cast<std::size_t>(chain.object)].name, "objects", chain.object);
    return name_of(state.lights[static_cast<std::size_t>(chain.light)].name, "lights", chain.light) + " > " +
           surface + (chain.event == Event::transmission ? ":T" : ":R");
}

}  // namespace dapple::light
