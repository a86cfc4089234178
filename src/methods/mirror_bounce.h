#pragma once
#include <vector>

#include "base/stats.h"
#include "light/beam_mesh.h"
#include "light/landing.h"
#include "media/media.h"
#include "rays/ray_scene.h"
#include "scene/frame_scene.h"

namespace dapple::methods {

/// Light of a beam mesh that mirrors send on, and where it lands.
struct MirroredMesh {
    light::BeamMesh mesh;
    light::Landings landings;
};

/// The second bounce, which Kougianos and Moustakas 2021, section 6, name as missing: the rays of a mesh
/// whose first object is a mirror, reflected at its exact surface, as a mesh for each mirror (each face of a
/// box), so that neighbours have met the same smooth surface. What the media on the way and the mirror leave
/// of the light is in the tints. Light that meets the water or another mirror next is dropped and counted, in
/// W.
std::vector<MirroredMesh> mirror_bounce(const scene::FrameScene& scene, const media::Media& media,
                                        const rays::RayScene& rays, const light::BeamMesh& mesh,
                                        FrameStats& stats);

/// Bytes a vertex of a map that all its meshes and the rays between take, foreseen for mirrors that all are
/// met: each face of a box, but for the one that looks away, is a mesh of the map's size.
double mirrored_vertex_bytes(const scene::FrameState& state);

}  // namespace dapple::methods
