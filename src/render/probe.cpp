#include "render/probe.h"

#include <algorithm>

#include "base/error.h"
#include "methods/reference/oracle.h"
#include "rays/ray_scene.h"
#include "render/frame_scene_builder.h"
#include "render/plan.h"
#include "view/camera_paths.h"

namespace dapple::render {
namespace {

/// The chains whose light travels in the receiver's medium.
std::vector<light::Chain> chains_to(const scene::FrameState& state, bool in_water) {
    std::vector<light::Chain> chains;
    for (std::size_t i = 0; state.water && i < state.lights.size(); ++i) {
        const bool arrives_in_water = !light_above_water(state.lights[i]);
        for (const light::Event event : {light::Event::transmission, light::Event::reflection}) {
            const bool leaves_in_water = arrives_in_water == (event == light::Event::reflection);
            if (leaves_in_water == in_water) chains.push_back({static_cast<int>(i), event});
        }
    }
    return chains;
}

/// Which part of an area light a light is: ", point 3 of 16".
std::string part_of(const scene::FrameState& state, int light) {
    const auto part = [&](int i) -> const scene::EmitterPart& {
        return state.lights[static_cast<std::size_t>(i)].part;
    };
    if (part(light).count < 2) return "";
    int first = 0;  // the parts of an emitter follow each other
    while (first + std::max(1, part(first).count) <= light) first += std::max(1, part(first).count);
    return ", point " + std::to_string(light - first + 1) + " of " + std::to_string(part(light).count);
}

/// The name of a chain, in which the parts of an area light have the same, with the part behind the light's.
std::string with_part(const scene::FrameState& state, int light, std::string chain) {
    return chain.insert(chain.rfind(" > "), part_of(state, light));
}

OracleCount ask_oracle(const scene::FrameState& state, light::Chain chain, const ProbedReceiver& receiver) {
    OracleCount count;
    count.chain = with_part(state, chain.light, light::chain_name(state, chain));
    const scene::Light& light = state.lights[static_cast<std::size_t>(chain.light)];
    try {
        const oracle::Oracle oracle(*state.water, light, state.time,
                                    chain.event == light::Event::transmission ? oracle::Event::transmission
                                                                              : oracle::Event::reflection);
        const oracle::Result result = oracle.paths(receiver.position, receiver.normal);
        for (const oracle::Path& path : result.paths) {
            if (!(path.sent > 0)) continue;
            if (path.blocked) {
                ++count.behind_waves;
            } else {
                ++count.paths;
                count.sign_sum += path.sign;
            }
        }
        count.proven = result.proven;
    } catch (const Error& error) {
        count.unavailable = error.what();
    }
    return count;
}

ProbedReceiver receiver_of(const scene::FrameScene& scene, const rays::RayScene& rays,
                           const view::ReceiverLayer& layer) {
    const scene::FrameState& state = scene.state;
    ProbedReceiver receiver;
    receiver.object = object_name(state, layer.object[0]);
    receiver.position = glm::dvec3(layer.position[0]) + scene.origin;
    receiver.normal = glm::dvec3(layer.geometric_normal[0]);
    receiver.in_water = (layer.flags[0] & view::kInWater) != 0;
    receiver.in_glass = (layer.flags[0] & view::kInGlass) != 0;
    receiver.behind_specular = (layer.flags[0] & view::kBehindSpecular) != 0;
    receiver.distance = glm::length(receiver.position - state.camera.position);

    const std::vector<light::Chain> chains = chains_to(state, receiver.in_water);
    receiver.paths = methods::sliced_beams::find_point_paths(scene, rays, chains, receiver.position,
                                                             receiver.normal, receiver.in_water);
    for (methods::sliced_beams::PointPath& path : receiver.paths.paths) {
        path.chain = with_part(state, path.light, path.chain);
        if (!path.blocker) receiver.irradiance += path.irradiance;
    }
    if (state.water && state.water->surface.type == scene::WaterSurfaceType::waves) {
        for (const light::Chain& chain : chains)
            receiver.oracle.push_back(ask_oracle(state, chain, receiver));
    }
    return receiver;
}

}  // namespace

std::string object_name(const scene::FrameState& state, std::uint32_t object) {
    const std::string& name = state.objects[object].name;
    return name.empty() ? "objects[" + std::to_string(object) + "]" : name;
}

std::vector<ProbedView> probe(const scene::FrameState& state, glm::dvec2 place) {
    FrameSceneBuilder builder;
    const scene::FrameScene scene = builder.build(state);
    const rays::RayScene rays(scene);
    const glm::dvec2 corner = glm::floor(place);
    view::LayerRequest request;
    request.offset = place - corner;
    request.window = {glm::ivec2(corner), {1, 1}};
    std::vector<ProbedView> views;
    const auto follow = [&](int branch) {
        request.branch = branch;
        view::LayerCounts counts;
        const view::ReceiverLayer layer = view::trace_layer(scene, rays, request, counts);
        ProbedView& found = views.emplace_back();
        found.branch = branch;
        found.throughput = glm::dvec3(layer.throughput[0]);
        if (layer.flags[0] & view::kReceiver) {
            found.sees = ProbedView::Sees::receiver;
            found.receiver = receiver_of(scene, rays, layer);
        } else if (layer.flags[0] & view::kEnvironment) {
            found.sees = ProbedView::Sees::sky;
        }
        return counts;
    };
    const view::LayerCounts refracted = follow(0);
    const bool splits = refracted.split_pixels > 0;
    const bool reflected_splits = splits && follow(1).split_again_pixels > 0;
    if (refracted.split_again_pixels > 0) follow(2);
    if (reflected_splits) follow(3);
    return views;
}

}  // namespace dapple::render
