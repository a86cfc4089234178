#pragma once
#include <map>
#include <memory>
#include <string>

#include "scene/frame_scene.h"

namespace dapple::render {

/// Makes the geometry of a frame from its state. Keeps files and time-independent tables between frames; what
/// it keeps never changes the result. Errors: Error(input_unreadable).
class FrameSceneBuilder {
public:
    FrameSceneBuilder();
    ~FrameSceneBuilder();
    scene::FrameScene build(const scene::FrameState& state);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace dapple::render
