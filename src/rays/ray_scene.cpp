#include "rays/ray_scene.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <mutex>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"
#include "base/transpose.h"
#include "rays/ray_lanes.h"
#include "rays/shape_mesh.h"
#include "rays/sphere.h"
#include "rays/water_grid.h"
#include "scene/transform.h"

namespace dapple::rays {
namespace {

/// Frees what Embree counts references of.
struct Release {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
    void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
};
template <typename Handle>
using Owned = std::unique_ptr<std::remove_pointer_t<Handle>, Release>;

/// Collects the first error that Embree reports; it may do so from the threads that build.
struct ErrorLog {
    std::mutex mutex;
    std::string first;

    static void report(void* user, RTCError, const char* message) {
        auto& log = *static_cast<ErrorLog*>(user);
        const std::lock_guard lock(log.mutex);
        if (log.first.empty()) log.first = message != nullptr ? message : "no message";
    }
    void throw_if_any(const std::string& what) {
        const std::lock_guard lock(mutex);
        if (!first.empty()) throw Error(ExitCode::failure, "Embree, " + what + ": " + clipped(first));
    }
};

/// How Embree compares: a triangle's first vertex and its edges in float, on both sides of a shared edge
/// alike.
constexpr RTCSceneFlags kRobust = RTC_SCENE_FLAG_ROBUST;

bool traceable(const Ray& ray) {
    const glm::vec3 sum = ray.origin * 0.0f + ray.direction * 0.0f;  // 0, or NaN by infinity or NaN
    return sum.x + sum.y + sum.z == 0 && ray.near <= ray.far && std::isfinite(ray.near) &&
           ray.direction != glm::vec3(0);
}

using lanes::Lanes;
using lanes::Mask;

constexpr std::size_t kPacket = lanes::kLanes<float>;
static_assert(sizeof(Ray) == kPacket * sizeof(float) && sizeof(Hit) == kPacket * sizeof(float));
static_assert(offsetof(Ray, origin) == 0 && offsetof(Ray, near) == 12 && offsetof(Ray, direction) == 16 &&
              offsetof(Ray, far) == 28);
static_assert(offsetof(Hit, distance) == 0 && offsetof(Hit, object) == 4 && offsetof(Hit, primitive) == 8 &&
              offsetof(Hit, barycentric) == 12 && offsetof(Hit, normal) == 20);

/// Embree takes components of a direction nearer to 0 than 1e-18 for +1e-18, but in packets of coherent rays
/// goes by the sign that they had: negative ones would miss what they hit.
Lanes<float> not_tiny(Lanes<float> component) {
    return lanes::magnitude(component) < 1e-17f ? Lanes<float>{} : component;
}

/// Up to eight rays as lanes; those past the end of the rays are off.
RayLanes lanes_of(std::span<const Ray> rays) {
    std::array<Lanes<float>, kPacket> rows;
    static const Ray kNone{glm::vec3(0), 0, glm::vec3(0), 0};
    for (std::size_t i = 0; i < kPacket; ++i)
        rows[i] = std::bit_cast<Lanes<float>>(i < rays.size() ? rays[i] : kNone);
    lanes::transpose(rows);
    const auto& [x, y, z, near, dx, dy, dz, far] = rows;
    return {{x, y, z}, {dx, dy, dz}, near, far, lanes::first_of(rays.size())};
}

/// One packet; rays that mean nothing are switched off too.
struct Packet {
    alignas(32) int valid[kPacket];

    Packet(const RayLanes& rays, RTCRay8& packet) {
        const auto& [origin, direction, near, far, wanted] = rays;
        // As `traceable`.
        const Lanes<float> zero = origin.x * 0.0f + origin.y * 0.0f + origin.z * 0.0f + direction.x * 0.0f +
                                  direction.y * 0.0f + direction.z * 0.0f + near * 0.0f;
        const Mask<float> on = wanted & (zero == 0.0f) & (near <= far) &
                               ((direction.x != 0.0f) | (direction.y != 0.0f) | (direction.z != 0.0f));
        std::memcpy(valid, &on, sizeof valid);
        const auto store = [&on](float* to, Lanes<float> value, float off) {
            const Lanes<float> kept = on ? value : lanes::splat(off);
            std::memcpy(to, &kept, sizeof kept);
        };
        store(packet.org_x, origin.x, 0);
        store(packet.org_y, origin.y, 0);
        store(packet.org_z, origin.z, 0);
        store(packet.dir_x, not_tiny(direction.x), 0);
        store(packet.dir_y, not_tiny(direction.y), 1);
        store(packet.dir_z, not_tiny(direction.z), 0);
        store(packet.tnear, near, 0);
        store(packet.tfar, far, 0);
        for (std::size_t i = 0; i < kPacket; ++i) {
            packet.time[i] = 0;
            packet.mask[i] = ~0u;
            packet.id[i] = static_cast<unsigned>(i);
            packet.flags[i] = 0;
        }
    }
};

template <class Number>
Lanes<float> load(const Number* eight) {
    static_assert(sizeof(Number) == sizeof(float));
    Lanes<float> value;
    std::memcpy(&value, eight, sizeof value);
    return value;
}

RTCIntersectContext coherent_context() {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    return context;
}

void take(const RTCRayHit8& packet, std::span<Hit> hits) {
    const Lanes<float> object = load(packet.hit.geomID);
    const Mask<float> hit = reinterpret_cast<Mask<float>>(object) != -1;          // RTC_INVALID_GEOMETRY_ID
    const Lanes<float> none = reinterpret_cast<Lanes<float>>(Mask<float>{} - 1);  // kNoHit
    // In the order of the members of Hit.
    std::array<Lanes<float>, kPacket> rows = {
        hit ? load(packet.ray.tfar) : lanes::splat(std::numeric_limits<float>::infinity()),
        object,
        hit ? load(packet.hit.primID) : none,
        hit ? load(packet.hit.u) : Lanes<float>{},
        hit ? load(packet.hit.v) : Lanes<float>{},
        hit ? load(packet.hit.Ng_x) : Lanes<float>{},
        hit ? load(packet.hit.Ng_y) : lanes::splat(1.0f),
        hit ? load(packet.hit.Ng_z) : Lanes<float>{}};
    lanes::transpose(rows);
    for (std::size_t i = 0; i < hits.size(); ++i) hits[i] = std::bit_cast<Hit>(rows[i]);
}

/// As Embree leaves them.
RTCRayHit8 intersect(RTCScene scene, const RayLanes& rays) {
    RTCIntersectContext context = coherent_context();
    RTCRayHit8 packet;
    const Packet lanes(rays, packet.ray);
    std::fill_n(packet.hit.geomID, kPacket, RTC_INVALID_GEOMETRY_ID);
    std::fill_n(packet.hit.instID[0], kPacket, RTC_INVALID_GEOMETRY_ID);
    rtcIntersect8(lanes.valid, scene, &context, &packet);
    return packet;
}

void intersect(RTCScene scene, std::span<const Ray> rays, std::span<Hit> hits) {
    for (std::size_t first = 0; first < rays.size(); first += kPacket) {
        const std::size_t count = std::min(kPacket, rays.size() - first);
        take(intersect(scene, lanes_of(rays.subspan(first, count))), hits.subspan(first, count));
    }
}

}  // namespace

std::string embree_version() {
    RTCDevice device = rtcNewDevice("isa=avx2");
    const auto number = rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION);  // 31305 is 3.13.5
    rtcReleaseDevice(device);
    return std::to_string(number / 10000) + "." + std::to_string(number / 100 % 100) + "." +
           std::to_string(number % 100);
}

struct RayScene::State {
    ErrorLog log;  // outlives the device, which reports to it
    Owned<RTCDevice> device;
    std::vector<Sphere> spheres;  // one an object, so that their addresses stay
    std::vector<bool> mirrored;   // objects whose transform turns their triangles inside out
    Owned<RTCScene> objects;
    Owned<RTCScene> water;
    std::optional<WaterGrid> grid;  // where the water's geometry is one
    bool any_mirrored = false;
    bool has_objects = false;
    bool has_water = false;
    struct Bounds {
        glm::vec3 lower;
        glm::vec3 upper;
    };
    Bounds water_bounds{};

    static Bounds bounds(RTCScene scene) {
        RTCBounds b;
        rtcGetSceneBounds(scene, &b);
        return {{b.lower_x, b.lower_y, b.lower_z}, {b.upper_x, b.upper_y, b.upper_z}};
    }

    void attach(RTCScene scene, RTCGeometry geometry, unsigned id, RTCBuildQuality quality) {
        rtcSetGeometryBuildQuality(geometry, quality);
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(scene, geometry, id);
        rtcReleaseGeometry(geometry);
    }

    /// An indexed mesh, placed in double and only then rounded.
    void attach_triangles(RTCScene scene, const scene::TriangleMesh& mesh,
                          const glm::dmat4& relative_from_mesh, unsigned id) {
        if (mesh.triangles.empty()) return;
        RTCGeometry geometry = rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* positions = static_cast<glm::vec3*>(
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(glm::vec3),
                                    mesh.positions.size()));
        auto* triangles = static_cast<glm::uvec3*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(glm::uvec3), mesh.triangles.size()));
        log.throw_if_any("buffers of a mesh");
        parallel_for(mesh.positions.size(), 1 << 15, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                positions[i] = glm::vec3(glm::dvec3(relative_from_mesh * glm::dvec4(mesh.positions[i], 1)));
            }
        });
        std::copy(mesh.triangles.begin(), mesh.triangles.end(), triangles);
        attach(scene, geometry, id, RTC_BUILD_QUALITY_MEDIUM);
    }

    void attach_water(const scene::WaterMesh& mesh, const glm::dvec3& origin) {
        grid = WaterGrid::make(mesh);
        if (!grid) {
            attach_triangles(water.get(), mesh.mesh, glm::translate(glm::dmat4(1), -origin), 0);
            return;
        }
        glm::vec3* vertices = nullptr;
        RTCGeometry geometry = grid->make_geometry(device.get(), vertices);
        log.throw_if_any("buffers of the water");
        parallel_for(grid->vertices(), 1 << 15, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                vertices[i] = glm::vec3(mesh.mesh.positions[grid->vertex(i)] - origin);
            }
        });
        attach(water.get(), geometry, 0, RTC_BUILD_QUALITY_MEDIUM);
    }

    void attach_object(const scene::Object& object, const scene::TriangleMesh* mesh, const glm::dvec3& origin,
                       unsigned id) {
        const glm::dmat4 matrix = scene::relative_from_object(object.transform, origin);
        mirrored[id] = object.shape != scene::Shape::sphere && determinant(glm::dmat3(matrix)) < 0;
        any_mirrored = any_mirrored || mirrored[id];
        switch (object.shape) {
            case scene::Shape::plane:
                attach_triangles(objects.get(), plane_mesh(object.size), matrix, id);
                break;
            case scene::Shape::box:
                attach_triangles(objects.get(), box_mesh(object.size), matrix, id);
                break;
            case scene::Shape::mesh:
                if (mesh != nullptr) attach_triangles(objects.get(), *mesh, matrix, id);
                break;
            case scene::Shape::sphere: {
                const glm::dmat3 offset_from_unit = glm::dmat3(matrix) * object.radius;
                if (!(std::abs(determinant(offset_from_unit)) > 0)) break;
                spheres[id] = {glm::dvec3(matrix[3]), inverse(offset_from_unit), offset_from_unit};
                attach(objects.get(), make_sphere_geometry(device.get(), spheres[id]), id,
                       RTC_BUILD_QUALITY_MEDIUM);
                break;
            }
        }
    }

    bool commit(RTCScene scene, const char* what) {
        rtcCommitScene(scene);
        log.throw_if_any(what);
        const Bounds found = bounds(scene);
        return found.lower.x <= found.upper.x;
    }

    /// Whether a ray passes from above all of the water to below it, or back, within its outline: then it
    /// cannot miss. Embree's test of edges keeps rays from slipping between two triangles, but about one in
    /// forty of those that are aimed at a vertex exactly slips between all that share it.
    bool crosses_water(const Ray& ray) const {
        for (const float level : {water_bounds.lower.y, water_bounds.upper.y}) {
            const float distance = (level - ray.origin.y) / ray.direction.y;
            if (!(distance > ray.near && distance < ray.far)) return false;
            const glm::vec3 at = ray.origin + distance * ray.direction;
            if (!(at.x > water_bounds.lower.x && at.x < water_bounds.upper.x && at.z > water_bounds.lower.z &&
                  at.z < water_bounds.upper.z)) {
                return false;
            }
        }
        return true;
    }

    /// The ray moved sideways by a few times the rounding of positions, away from the vertex.
    Ray beside(Ray ray) const {
        const glm::vec3 reach = glm::max(glm::abs(water_bounds.lower), glm::abs(water_bounds.upper));
        const float step = 0x1p-20f * std::max({reach.x, reach.y, reach.z});
        ray.origin += glm::vec3(step, 0, 0.7f * step);
        return ray;
    }
};

RayScene::RayScene(const scene::FrameScene& scene) : state_(std::make_unique<State>()) {
    State& state = *state_;
    state.device.reset(rtcNewDevice("isa=avx2"));
    if (!state.device) throw Error(ExitCode::failure, "Embree: no device with AVX2 could be made");
    rtcSetDeviceErrorFunction(state.device.get(), ErrorLog::report, &state.log);
    state.objects.reset(rtcNewScene(state.device.get()));
    state.water.reset(rtcNewScene(state.device.get()));
    rtcSetSceneFlags(state.objects.get(), kRobust);
    rtcSetSceneFlags(state.water.get(), kRobust);

    const std::size_t count = scene.state.objects.size();
    state.spheres.resize(count);
    state.mirrored.assign(count, false);
    for (std::size_t i = 0; i < count; ++i) {
        const auto* mesh = i < scene.object_meshes.size() ? scene.object_meshes[i].get() : nullptr;
        state.attach_object(scene.state.objects[i], mesh, scene.origin, static_cast<unsigned>(i));
    }
    state.has_objects = state.commit(state.objects.get(), "tree of the objects");

    if (scene.water) state.attach_water(*scene.water, scene.origin);
    state.has_water = state.commit(state.water.get(), "tree of the water");
    state.water_bounds = State::bounds(state.water.get());
}

RayScene::~RayScene() = default;
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;

void RayScene::intersect_objects(std::span<const Ray> rays, std::span<Hit> hits) const {
    if (!state_->has_objects) {
        std::fill_n(hits.begin(), rays.size(), Hit{});
        return;
    }
    intersect(state_->objects.get(), rays, hits);
    if (!state_->any_mirrored) return;
    for (Hit& hit : hits.first(rays.size())) {
        if (hit.primitive != kNoHit && state_->mirrored[hit.object]) hit.normal = -hit.normal;
    }
}

void RayScene::intersect_water(std::span<const Ray> rays, std::span<Hit> hits) const {
    if (!state_->has_water) {
        std::fill_n(hits.begin(), rays.size(), Hit{});
        return;
    }
    intersect(state_->water.get(), rays, hits);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        if (hits[i].primitive != kNoHit || !traceable(rays[i]) || !state_->crosses_water(rays[i])) continue;
        const Ray beside = state_->beside(rays[i]);
        intersect(state_->water.get(), std::span(&beside, 1), hits.subspan(i, 1));
    }
    if (!state_->grid) return;
    for (Hit& hit : hits.first(rays.size())) {
        if (hit.primitive != kNoHit) state_->grid->resolve(hit);
    }
}

void RayScene::occluded_by_objects(std::span<const Ray> rays, std::span<std::uint8_t> occluded) const {
    std::fill_n(occluded.begin(), rays.size(), std::uint8_t{0});
    if (!state_->has_objects) return;
    for (std::size_t first = 0; first < rays.size(); first += kPacket) {
        const std::size_t count = std::min(kPacket, rays.size() - first);
        const Mask<float> hidden = occluded_by_objects(lanes_of(rays.subspan(first, count)));
        for (std::size_t i = 0; i < count; ++i) occluded[first + i] = hidden[i] != 0;
    }
}

void RayScene::intersect_objects(const RayLanes& rays, HitLanes& hits) const {
    hits = {};
    if (!state_->has_objects) return;
    const RTCRayHit8 packet = intersect(state_->objects.get(), rays);
    hits.hit = reinterpret_cast<Mask<float>>(load(packet.hit.geomID)) != -1;  // RTC_INVALID_GEOMETRY_ID
    hits.distance = hits.hit ? load(packet.ray.tfar) : hits.distance;
    hits.normal =
        choose(hits.hit, {load(packet.hit.Ng_x), load(packet.hit.Ng_y), load(packet.hit.Ng_z)}, hits.normal);
    if (!state_->any_mirrored) return;
    for (unsigned left = lanes::bits(hits.hit); left != 0; left &= left - 1) {
        const auto k = static_cast<std::size_t>(__builtin_ctz(left));
        if (state_->mirrored[packet.hit.geomID[k]]) set_lane(hits.normal, k, -lane(hits.normal, k));
    }
}

lanes::Mask<float> RayScene::occluded_by_objects(const RayLanes& rays) const {
    if (!state_->has_objects) return Mask<float>{};
    RTCIntersectContext context = coherent_context();
    RTCRay8 packet;
    const Packet lanes(rays, packet);
    rtcOccluded8(lanes.valid, state_->objects.get(), &context, &packet);
    Mask<float> valid;
    std::memcpy(&valid, lanes.valid, sizeof valid);
    return valid & (load(packet.tfar) < 0.0f);
}

bool RayScene::has_objects() const {
    return state_->has_objects;
}

void RayScene::object_bounds(glm::vec3& lower, glm::vec3& upper) const {
    const State::Bounds bounds = State::bounds(state_->objects.get());
    lower = bounds.lower;
    upper = bounds.upper;
}

}  // namespace dapple::rays
