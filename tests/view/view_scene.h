#pragma once
#include <memory>

#include "rays/ray_scene.h"
#include "rays/water_meshes.h"
#include "view/camera_paths.h"

namespace dapple::test {

/// A frame with a camera and, by default, nothing else.
struct ViewScene {
    scene::FrameScene frame;

    ViewScene(int width, int height) {
        frame.state.clip.width = width;
        frame.state.clip.height = height;
        frame.state.clip.samples = 1;
    }
    scene::Camera& camera() { return frame.state.camera; }

    void look(const glm::dvec3& from, const glm::dvec3& at, double field_of_view = 0.7) {
        camera().projection = scene::Projection::perspective;
        camera().position = from;
        camera().target = at;
        camera().field_of_view = field_of_view;
    }
    void look_in_parallel(const glm::dvec3& from, const glm::dvec3& at, double view_height) {
        look(from, at);
        camera().projection = scene::Projection::orthographic;
        camera().view_height = view_height;
    }
    scene::Object& add(scene::Shape shape, const glm::dvec3& position,
                       const glm::dvec3& size = glm::dvec3(1)) {
        scene::Object object;
        object.shape = shape;
        object.size = size;
        object.transform.position = position;
        frame.state.objects.push_back(object);
        return frame.state.objects.back();
    }
    scene::Object& add_floor(double y, double size = 200) {
        return add(scene::Shape::plane, {0, y, 0}, {size, 1, size});
    }
    scene::Water& fill(std::shared_ptr<const scene::WaterMesh> mesh, double size,
                       scene::ExtentKind kind = scene::ExtentKind::open_water) {
        frame.water = std::move(mesh);
        scene::Water water;
        water.extent.kind = kind;
        water.extent.size = {size, size};
        frame.state.water = water;
        return *frame.state.water;
    }
    scene::Water& fill_flat(double size) { return fill(flat_water(size), size); }

    view::ReceiverLayer trace(int branch = 0, view::LayerCounts* counts = nullptr) const {
        view::LayerCounts ignored;
        const rays::RayScene rays(frame);
        return view::trace_layer(frame, rays, {0, branch}, counts != nullptr ? *counts : ignored);
    }
};

/// Fresnel's equations as in textbooks, from angles: the oracle of shaders/optics/refraction.h as used by
/// view.
struct Crossing {
    double cos_t;          ///< negative: total reflection
    double transmittance;  ///< of power
};
inline Crossing cross_surface(double cos_i, double index_from, double index_to) {
    const double theta_i = std::acos(cos_i);
    const double sine = index_from / index_to * std::sin(theta_i);
    if (sine >= 1) return {-1, 0};
    const double theta_t = std::asin(sine);
    if (theta_i < 1e-6) {
        return {1, 4 * index_from * index_to / std::pow(index_from + index_to, 2)};
    }
    const double s = std::sin(theta_i - theta_t) / std::sin(theta_i + theta_t);
    const double p = std::tan(theta_i - theta_t) / std::tan(theta_i + theta_t);
    return {std::cos(theta_t), 1 - 0.5 * (s * s + p * p)};
}

}  // namespace dapple::test
