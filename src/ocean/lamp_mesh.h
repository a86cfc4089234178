#pragma once
#include "scene/frame_state.h"

namespace dapple::ocean {

/// Beams that a spot's picture is wide on the water: what is finer than a beam is its mean.
constexpr double kBeamsAcrossPicture = 256;
/// The same of a spot without a picture, whose soft edge is laid down in beams: E pixel by pixel is right to
/// 0.2 to 0.9 % (L1, cones of 10 to 60 degrees).
constexpr double kBeamsAcrossSpot = 96;
/// Beams along the least distance of any lamp from the water: E below a point light is right to 0.5 %.
constexpr double kBeamsAlongDistance = 25;
/// Lamps nearer than this share of the water's shorter side count as so far: what follows the distance has no
/// bound, and is nothing but cost when a lamp passes through the surface.
constexpr double kLeastDistance = 1.0 / 20;

/// The state with as fine a mesh of the water as its lamps call for, where nothing but the timeline's
/// mesh_cells says otherwise: each beam carries one irradiance, whatever its size, so that flat water's two
/// by two cells serve a sun, but no lamp near them. Distances are those to the rest plane, within the water's
/// extent and the spot's cone, or before an area light: how wide a spot is there is taken where it is
/// nearest. At most ocean::kDefaultTriangleCap triangles, but for the rounding of a spectrum's sizes. Cells
/// follow the distance without steps, so that no frame of a lamp that moves is sharper than its neighbours by
/// more than they differ in distance (a spectrum's sizes step by some per cent): waves and spectra are the
/// same surface on any mesh, but for the second order of its cells. Unchanged where mesh_cells or rings are
/// given, the mesh is as fine already, or is read from files; lamps without intensity, and spots and area
/// lights that do not reach the rest plane within the extent, count for nothing.
scene::FrameState with_mesh_for_lamps(scene::FrameState state);

}  // namespace dapple::ocean
