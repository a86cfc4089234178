#pragma once
#include "scene/frame_state.h"

namespace dapple::render {

/// Beams that a spot's picture is wide on the water, where nothing but the timeline's mesh_cells says
/// otherwise: what is finer than a beam is its mean.
constexpr double kBeamsAcrossPicture = 256;

/// The state with as fine a mesh of the water as pictures of spots call for: kBeamsAcrossPicture cells in the
/// cone where a spot that shines straight at the rest plane would meet it; as many in all as are a power of
/// two along x, so that spots may move, but at most ocean::kDefaultTriangleCap triangles. Unchanged without
/// pictures, where mesh_cells is given, the mesh is as fine already, or is read from files.
scene::FrameState with_mesh_for_pictures(scene::FrameState state);

}  // namespace dapple::render
