// Footprints against the exact derivatives of where light lands: a curved piece of water, its rays found in
// double.
#include "methods/photon_splatting/footprint.h"

#include <gtest/gtest.h>

#include <cmath>

#include "optics/optics.h"

namespace dapple::methods {
namespace {

constexpr double kIndex = 1.333;
constexpr float kCell = 0.004f;  // m
constexpr int kSide = 9;         // photons along each side; the one in the middle is looked at
constexpr int kHalf = kSide / 2;
constexpr std::size_t kMiddle = kSide * kSide / 2;

struct Case {
    const char* name;
    light::Event event;
    glm::dvec3 light;  // unit direction of a sun, or position of a lamp, m
    bool sun;
    glm::dvec3 plane;  // point and
    glm::dvec3 tilt;   // normal of what the light lands on
};

const glm::dvec3 kLevel(0, 1, 0);
const Case kCases[] = {
    {"overhead", light::Event::transmission, {0, -1, 0}, true, {0, -2, 0}, kLevel},
    {"low", light::Event::transmission, {0.7, -0.5, 0.3}, true, {0, -2, 0}, {0.3, 1, -0.2}},
    {"wall", light::Event::transmission, {0.6, -0.8, 0}, true, {0.4, 0, 0}, {-1, 0.1, 0}},
    {"mirrored", light::Event::reflection, {0.6, -0.6, 0.2}, true, {0, 1.5, 0}, {0.1, -1, 0.2}},
    {"lamp", light::Event::transmission, {0.3, 0.8, -0.2}, false, {0, -1.5, 0}, kLevel},
    {"mirrored_lamp", light::Event::reflection, {-0.9, 1.1, 0.2}, false, {0, 2, 0}, {0, -1, 0}},
    {"submerged", light::Event::transmission, {0.1, -1.2, 0.3}, false, {0, 1.5, 0}, {0, -1, 0.1}},
};

class Footprints : public testing::TestWithParam<Case> {
protected:
    void SetUp() override {
        const Case& c = GetParam();
        scene_.state.water.emplace();
        scene_.state.water->refractive_index = kIndex;
        scene::Light light;
        light.type = c.sun ? scene::LightType::sun : scene::LightType::point;
        if (c.sun)
            light.direction = glm::normalize(c.light);
        else
            light.position = c.light;
        scene_.state.lights = {light};
        mesh_.event = c.event;
        mesh_.from_below = !c.sun && c.light.y < 0;
        mesh_.axis = {0, c.plane.y > 0 ? 1 : -1, 0};
        mesh_.rows = mesh_.columns = kSide;
        mesh_.cell = {kCell, kCell};
        for (int row = 0; row < kSide; ++row)
            for (int column = 0; column < kSide; ++column) {
                const Ray ray = trace(place(column), place(row));
                const glm::dvec3 slope = ray.direction / glm::dot(ray.direction, mesh_.axis);
                const double start = glm::dot(ray.point, mesh_.axis);
                mesh_.origin.emplace_back(ray.point - start * slope);
                mesh_.slope.emplace_back(slope);
                mesh_.start.push_back(static_cast<float>(start));
                mesh_.flux.push_back(1);
                mesh_.valid.push_back(1);
            }
    }

    struct Ray {
        glm::dvec3 point, direction;
    };

    static double place(int k) { return (k - kHalf) * static_cast<double>(kCell); }

    /// The ray of the light that passes through (u, 0, v).
    static Ray trace(double u, double v) {
        const Case& c = GetParam();
        const auto height = [](double x, double z) {
            return 0.3 * x * x - 0.25 * x * z + 0.2 * z * z + 0.05 * x;
        };
        const glm::dvec3 through(u, 0, v);
        const glm::dvec3 in = glm::normalize(c.sun ? c.light : through - c.light);
        glm::dvec3 point = through;
        for (int step = 0; step < 60; ++step) point = through + in * (height(point.x, point.z) / in.y);
        glm::dvec3 normal = glm::normalize(
            glm::dvec3(-(0.6 * point.x - 0.25 * point.z + 0.05), 1, -(-0.25 * point.x + 0.4 * point.z)));
        if (glm::dot(normal, in) > 0) normal = -normal;
        if (c.event == light::Event::reflection) return {point, optics::f64::reflected_direction(in, normal)};
        glm::dvec3 out;
        EXPECT_TRUE(optics::f64::refracted_direction(in, normal, in.y > 0 ? kIndex : 1 / kIndex, out));
        return {point, out};
    }

    static glm::dvec3 land(double u, double v) {
        const Case& c = GetParam();
        const Ray ray = trace(u, v);
        return ray.point +
               ray.direction * (glm::dot(c.tilt, c.plane - ray.point) / glm::dot(c.tilt, ray.direction));
    }

    /// Where light lands (or meets the water) a cell further along u and v, to first order.
    template <class Map>
    static glm::dvec3 side(Map map, double u, double v) {
        constexpr double h = 1e-6;
        return static_cast<double>(kCell) / (2 * h) * (map(h * u, h * v) - map(-h * u, -h * v));
    }

    PhotonHit hit(const PhotonGrid& grid) const {
        const glm::dvec3 at = land(0, 0);
        const glm::dvec3 way = trace(0, 0).direction;
        const glm::dvec3 normal =
            glm::normalize(glm::dot(GetParam().tilt, way) < 0 ? GetParam().tilt : -GetParam().tilt);
        return grid.hit(kMiddle, static_cast<float>(glm::dot(at, mesh_.axis)), glm::vec3(normal));
    }

    static double away(glm::vec3 a, glm::dvec3 b) { return glm::length(glm::dvec3(a) - b) / glm::length(b); }

    scene::FrameScene scene_;
    light::BeamMesh mesh_;
};

INSTANTIATE_TEST_SUITE_P(Water, Footprints, testing::ValuesIn(kCases),
                         [](const auto& c) { return std::string(c.param.name); });

TEST_P(Footprints, DifferentialsAndDifferencesAreTheDerivativesOfTheLandingPoint) {
    const PhotonGrid grid(scene_, mesh_);
    const glm::dvec3 first = side(land, 1, 0), second = side(land, 0, 1);
    for (const auto footprint : {difference_footprint, differential_footprint}) {
        const Footprint found = footprint(grid, hit(grid));
        EXPECT_FALSE(found.without_neighbors);
        // Third derivatives over a cell of 4 mm, against lengths of 1 m, and rays in float: of normals, which
        // differ by 0.002 from cell to cell, 1e-7.
        EXPECT_LT(away(found.first, first), 5e-4);
        EXPECT_LT(away(found.second, second), 5e-4);
    }
    // Forward differences are the derivatives half a cell off.
    const Footprint paper = paper_difference_footprint(grid, hit(grid));
    EXPECT_LT(away(paper.first, first), 0.02);
    EXPECT_LT(away(paper.second, second), 0.02);
}

TEST_P(Footprints, FixedOnesAreTheCellCarriedAlongTheRay) {
    const PhotonGrid grid(scene_, mesh_);
    const PhotonHit at = hit(grid);
    const Footprint found = fixed_footprint(grid, at);
    for (const auto& [found_side, cell] :
         {std::pair(found.first, glm::vec3(kCell, 0, 0)), std::pair(found.second, glm::vec3(0, 0, kCell))}) {
        EXPECT_NEAR(glm::dot(found_side, at.normal), 0, 1e-6f * kCell);
        EXPECT_LT(glm::length(glm::cross(found_side - cell, at.beam)), 1e-6f * glm::length(found_side));
    }
}

TEST_P(Footprints, OfThePaperAreForeshortenedSquaresOfTheBeamsArea) {
    const PhotonGrid grid(scene_, mesh_);
    const PhotonHit at = hit(grid);
    const double cosine = -static_cast<double>(glm::dot(at.beam, at.normal));
    const double cell = static_cast<double>(kCell) * static_cast<double>(kCell) *
                        std::abs(static_cast<double>(grid.incident(kMiddle).y));
    const auto expect_area = [&](const Footprint& found, double across, double tolerance) {
        EXPECT_NEAR(glm::dot(found.first, found.second), 0, 1e-6f * kCell * kCell);
        const double area = static_cast<double>(glm::length(glm::cross(found.first, found.second)));
        EXPECT_NEAR(area * cosine, across, tolerance * across);
        // Long along the ray's shadow on the plane.
        const double stretch =
            static_cast<double>(glm::length(found.first)) / static_cast<double>(glm::length(found.second));
        EXPECT_NEAR(stretch * cosine, 1, 5e-4);
        const glm::vec3 shadow = at.beam - glm::dot(at.beam, at.normal) * at.normal;
        if (cosine < 0.99) {
            EXPECT_LT(glm::length(glm::cross(found.first, shadow)), 1e-5f * kCell);
        }
    };
    // Equation 19's epsilon, 1e-4 over the cosine.
    expect_area(paper_fixed_footprint(grid, at), cell, 5e-4);
    // The water's and the beam's area where it has gone as far as its middle.
    const glm::dvec3 here = trace(0, 0).point;
    const double way = glm::length(land(0, 0) - here);
    const auto far = [way](double u, double v) {
        const Ray ray = trace(u, v);
        return ray.point + way * ray.direction;
    };
    const auto water = [](double u, double v) { return trace(u, v).point; };
    const auto area = [](auto map) { return glm::length(glm::cross(side(map, 1, 0), side(map, 0, 1))); };
    // Forward differences, half a cell off.
    expect_area(paper_differential_footprint(grid, at), cell * area(far) / area(water), 0.02);
    const Footprint point = paper_point_footprint(grid, at);
    EXPECT_EQ(point.first, glm::vec3(0));
    EXPECT_NEAR(static_cast<double>(point.gain), area(water) / area(land),
                0.05 * static_cast<double>(point.gain));
}

TEST(Footprint, AlonePhotonsTakeTheirCell) {
    scene::FrameScene scene;
    scene.state.water.emplace();
    scene.state.lights.emplace_back();
    light::BeamMesh mesh;
    mesh.rows = mesh.columns = 1;
    mesh.cell = {0.1f, 0.2f};
    mesh.origin = {glm::vec3(0)};
    mesh.slope = {glm::vec3(0, -1, 0)};
    mesh.start = {0};
    mesh.valid = {1};
    const PhotonGrid grid(scene, mesh);
    for (const auto footprint : {difference_footprint, differential_footprint, paper_difference_footprint,
                                 paper_differential_footprint}) {
        const Footprint found = footprint(grid, grid.hit(0, 2, {0, 1, 0}));
        EXPECT_TRUE(found.without_neighbors);
        EXPECT_NEAR(glm::length(glm::cross(found.first, found.second)), 0.02f, 1e-4f);
    }
}

}  // namespace
}  // namespace dapple::methods
