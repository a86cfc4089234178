#pragma once
#include <embree3/rtcore.h>

#include <algorithm>
#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "base/parallel.h"
#include "rays/ray_scene.h"
#include "rays/shape_mesh.h"
#include "scene/frame_scene.h"

namespace dapple::test {

/// The scene's planes and boxes in an Embree scene of the settings of src/rays, and rays in packets.
class BareEmbree {
public:
    explicit BareEmbree(const scene::FrameScene& frame)
        : device_(rtcNewDevice("isa=avx2")), scene_(rtcNewScene(device_)) {
        rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
        for (const scene::Object& object : frame.state.objects) {
            const scene::TriangleMesh mesh = object.shape == scene::Shape::box
                                                 ? rays::box_mesh(object.size)
                                                 : rays::plane_mesh(object.size);
            RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
            auto* positions = static_cast<glm::vec3*>(
                rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                        sizeof(glm::vec3), mesh.positions.size()));
            auto* triangles = static_cast<glm::uvec3*>(
                rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                        sizeof(glm::uvec3), mesh.triangles.size()));
            for (std::size_t i = 0; i < mesh.positions.size(); ++i)
                positions[i] = glm::vec3(mesh.positions[i] + object.transform.position - frame.origin);
            std::copy(mesh.triangles.begin(), mesh.triangles.end(), triangles);
            rtcCommitGeometry(geometry);
            rtcAttachGeometry(scene_, geometry);
            rtcReleaseGeometry(geometry);
        }
        rtcCommitScene(scene_);
    }
    ~BareEmbree() {
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
    }
    BareEmbree(const BareEmbree&) = delete;
    BareEmbree& operator=(const BareEmbree&) = delete;

    /// Whole packets; rays that would fill only part of one are left out.
    static std::vector<RTCRay8> packets(const std::vector<rays::Ray>& rays) {
        std::vector<RTCRay8> result(rays.size() / 8);
        for (std::size_t i = 0; i < 8 * result.size(); ++i) {
            RTCRay8& ray = result[i / 8];
            const std::size_t lane = i % 8;
            ray.org_x[lane] = rays[i].origin.x;
            ray.org_y[lane] = rays[i].origin.y;
            ray.org_z[lane] = rays[i].origin.z;
            ray.dir_x[lane] = rays[i].direction.x;
            ray.dir_y[lane] = rays[i].direction.y;
            ray.dir_z[lane] = rays[i].direction.z;
            ray.tnear[lane] = rays[i].near;
            ray.tfar[lane] = rays[i].far;
            ray.mask[lane] = ~0u;
            ray.time[lane] = 0;
            ray.flags[lane] = 0;
            ray.id[lane] = 0;
        }
        return result;
    }

    void intersect(const std::vector<RTCRay8>& packets) const {
        each(packets, [this](const int* valid, RTCIntersectContext& context, const RTCRay8& ray) {
            RTCRayHit8 packet;
            packet.ray = ray;
            std::fill_n(packet.hit.geomID, 8, RTC_INVALID_GEOMETRY_ID);
            rtcIntersect8(valid, scene_, &context, &packet);
            return packet.ray.tfar[0];
        });
    }
    void occluded(const std::vector<RTCRay8>& packets) const {
        each(packets, [this](const int* valid, RTCIntersectContext& context, RTCRay8 ray) {
            rtcOccluded8(valid, scene_, &context, &ray);
            return ray.tfar[0];
        });
    }

private:
    template <class Query>
    static void each(const std::vector<RTCRay8>& packets, const Query& query) {
        std::vector<float> sums(packets.size() / kTile + 1);  // so that nothing is optimised away
        parallel_for(packets.size(), kTile, [&](std::size_t begin, std::size_t end) {
            alignas(32) const int valid[8] = {-1, -1, -1, -1, -1, -1, -1, -1};
            RTCIntersectContext context;
            rtcInitIntersectContext(&context);
            context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
            for (std::size_t i = begin; i < end; ++i)
                sums[begin / kTile] += query(valid, context, packets[i]);
        });
        volatile float sum = 0;
        for (const float tile : sums) sum = sum + tile;
    }

    static constexpr std::size_t kTile = 512;
    RTCDevice device_;
    RTCScene scene_;
};

}  // namespace dapple::test
