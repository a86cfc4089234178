#pragma once
#include "scene/frame_state.h"
#include "scene/mesh.h"

namespace dapple::ocean {

/// The mesh at a time: read, turned y up ((x, y, z) -> (x, z, -y)), scaled, offset, triangles turned to face
/// up, normals area-weighted over the triangles of a vertex. Where the file is missing and the policy is
/// `hold`, the last one before it. Error(input_unreadable) for missing or broken files and surfaces that face
/// nowhere, Error(timeline_invalid) for the pattern.
scene::WaterMesh sequence_mesh(const scene::MeshSequence& sequence, double time);

/// Makes triangles face up on the whole and gives area-weighted normals. False where the surface faces
/// neither up nor down (no area, or a closed body).
bool orient_upwards(scene::TriangleMesh& mesh);

}  // namespace dapple::ocean
