// Footprints against the exact derivatives of where light lands: a curved piece of water, its rays found in
// double.
#include "methods/photon_splatting/footprint.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

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

/// A photon and its footprints, as eight lanes of the same.
struct Landed {
    Landed(const PhotonGrid& g, std::size_t photon, float depth, glm::vec3 plane_normal)
        : grid(g),
          photons(g.of(std::vector<std::size_t>{photon})),
          hits(g.hits(photons, all(depth), all(plane_normal))) {}
    glm::vec3 normal() const { return lane(hits.normal, 0); }
    glm::vec3 beam() const { return lane(hits.beam, 0); }

    struct Shape {
        glm::vec3 first, second;
        float gain;
        bool without_neighbors;
    };
    template <class Make>
    Shape make(Make footprint) const {
        const methods::Footprints all_eight = footprint(grid, photons, hits);
        EXPECT_EQ(lane(all_eight.first, 0), lane(all_eight.first, 7));
        EXPECT_EQ(all_eight.gain[0], all_eight.gain[7]);
        return {lane(all_eight.first, 0), lane(all_eight.second, 0), all_eight.gain[0],
                all_eight.without_neighbors[0] != 0};
    }

    const PhotonGrid& grid;
    Photons photons;
    PhotonHits hits;
};

class FootprintsOf : public testing::TestWithParam<Case> {
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
        mesh_.texel = glm::mat2(kCell);
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

    /// The one in the middle, where it lands.
    Landed middle(const PhotonGrid& grid) const {
        const glm::dvec3 at = land(0, 0);
        const glm::dvec3 way = trace(0, 0).direction;
        const glm::dvec3 normal =
            glm::normalize(glm::dot(GetParam().tilt, way) < 0 ? GetParam().tilt : -GetParam().tilt);
        return {grid, kMiddle, static_cast<float>(glm::dot(at, mesh_.axis)), glm::vec3(normal)};
    }

    static double away(glm::vec3 a, glm::dvec3 b) { return glm::length(glm::dvec3(a) - b) / glm::length(b); }

    scene::FrameScene scene_;
    light::BeamMesh mesh_;
};

INSTANTIATE_TEST_SUITE_P(Water, FootprintsOf, testing::ValuesIn(kCases),
                         [](const auto& c) { return std::string(c.param.name); });

TEST_P(FootprintsOf, DifferentialsAndDifferencesAreTheDerivativesOfTheLandingPoint) {
    const PhotonGrid grid(scene_, mesh_);
    const glm::dvec3 first = side(land, 1, 0), second = side(land, 0, 1);
    for (const auto footprint : {difference_footprint, differential_footprint}) {
        const Landed::Shape found = middle(grid).make(footprint);
        EXPECT_FALSE(found.without_neighbors);
        // Third derivatives over a cell of 4 mm, against lengths of 1 m, and rays in float: of normals, which
        // differ by 0.002 from cell to cell, 1e-7.
        EXPECT_LT(away(found.first, first), 5e-4);
        EXPECT_LT(away(found.second, second), 5e-4);
    }
    // Forward differences are the derivatives half a cell off.
    const Landed::Shape paper = middle(grid).make(paper_difference_footprint);
    EXPECT_LT(away(paper.first, first), 0.02);
    EXPECT_LT(away(paper.second, second), 0.02);
}

TEST_P(FootprintsOf, FixedOnesAreTheCellCarriedAlongTheRay) {
    const PhotonGrid grid(scene_, mesh_);
    const Landed at = middle(grid);
    const Landed::Shape found = at.make(fixed_footprint);
    for (const auto& [found_side, cell] :
         {std::pair(found.first, glm::vec3(kCell, 0, 0)), std::pair(found.second, glm::vec3(0, 0, kCell))}) {
        EXPECT_NEAR(glm::dot(found_side, at.normal()), 0, 1e-6f * kCell);
        EXPECT_LT(glm::length(glm::cross(found_side - cell, at.beam())), 1e-6f * glm::length(found_side));
    }
}

TEST_P(FootprintsOf, OfThePaperAreForeshortenedSquaresOfTheBeamsArea) {
    const PhotonGrid grid(scene_, mesh_);
    const Landed at = middle(grid);
    const double cosine = -static_cast<double>(glm::dot(at.beam(), at.normal()));
    const double cell = static_cast<double>(kCell) * static_cast<double>(kCell) *
                        std::abs(static_cast<double>(grid.incident(at.photons.own).y[0]));
    const auto expect_area = [&](const Landed::Shape& found, double across, double tolerance) {
        EXPECT_NEAR(glm::dot(found.first, found.second), 0, 1e-6f * kCell * kCell);
        const double area = static_cast<double>(glm::length(glm::cross(found.first, found.second)));
        EXPECT_NEAR(area * cosine, across, tolerance * across);
        // Long along the ray's shadow on the plane.
        const double stretch =
            static_cast<double>(glm::length(found.first)) / static_cast<double>(glm::length(found.second));
        EXPECT_NEAR(stretch * cosine, 1, 5e-4);
        const glm::vec3 shadow = at.beam() - glm::dot(at.beam(), at.normal()) * at.normal();
        if (cosine < 0.99) {
            EXPECT_LT(glm::length(glm::cross(found.first, shadow)), 1e-5f * kCell);
        }
    };
    // Equation 19's epsilon, 1e-4 over the cosine.
    expect_area(at.make(paper_fixed_footprint), cell, 5e-4);
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
    expect_area(at.make(paper_differential_footprint), cell * area(far) / area(water), 0.02);
    const Landed::Shape point = at.make(paper_point_footprint);
    EXPECT_EQ(point.first, glm::vec3(0));
    EXPECT_NEAR(static_cast<double>(point.gain), area(water) / area(land),
                0.05 * static_cast<double>(point.gain));
}

TEST(Footprint, AlonePhotonsTakeTheirCell) {
    // Not on the stack, where GCC 12 takes parts of an optional for uninitialised.
    const auto made = std::make_unique<scene::FrameScene>();
    scene::FrameScene& scene = *made;
    scene.state.water.emplace();
    scene.state.lights.emplace_back();
    light::BeamMesh mesh;
    mesh.rows = mesh.columns = 1;
    mesh.texel = {{0.1f, 0}, {0, 0.2f}};
    mesh.origin = {glm::vec3(0)};
    mesh.slope = {glm::vec3(0, -1, 0)};
    mesh.start = {0};
    mesh.valid = {1};
    const PhotonGrid grid(scene, mesh);
    for (const auto footprint : {difference_footprint, differential_footprint, paper_difference_footprint,
                                 paper_differential_footprint}) {
        const Landed::Shape found = Landed(grid, 0, 2, {0, 1, 0}).make(footprint);
        EXPECT_TRUE(found.without_neighbors);
        EXPECT_NEAR(glm::length(glm::cross(found.first, found.second)), 0.02f, 1e-4f);
    }
}

/// A sun overhead and three by three photons that it sends straight down.
struct Grid {
    Grid() : made(std::make_unique<scene::FrameScene>()) {
        made->state.water.emplace();
        made->state.lights.emplace_back();
        made->state.lights[0].direction = {0, -1, 0};
        mesh.rows = mesh.columns = 3;
        mesh.texel = glm::mat2(0.1f);
        for (int i = 0; i < 9; ++i)
            mesh.origin.emplace_back(0.1f * static_cast<float>(i % 3), 0, 0.1f * static_cast<float>(i / 3));
        mesh.slope.assign(9, {0, -1, 0});
        mesh.start.assign(9, 0.0f);
        mesh.flux.assign(9, 1.0f);
        mesh.valid.assign(9, 1);
    }
    std::unique_ptr<scene::FrameScene> made;
    light::BeamMesh mesh;
};

TEST(Footprint, CellsLieAsTheMapsColumnsAndRowsDo) {
    Grid of;
    of.mesh.texel = {{0.06f, 0.08f}, {-0.04f, 0.03f}};  // as the paper's maps do, turned with the sun
    const PhotonGrid grid(*of.made, of.mesh);
    const Landed::Shape found = Landed(grid, 4, 2, {0, 1, 0}).make(fixed_footprint);
    EXPECT_NEAR(glm::distance(found.first, glm::vec3(0.06f, 0, 0.08f)), 0, 1e-7f);
    EXPECT_NEAR(glm::distance(found.second, glm::vec3(-0.04f, 0, 0.03f)), 0, 1e-7f);
}

TEST(Footprint, CompressionComparesAreasBetweenTheSameRays) {
    // The next ray along columns runs along the plane on which the photon lands, so the one before is taken,
    // which left the water twice as far away.
    Grid of;
    of.mesh.slope[5] = {-0.75f, -1, 0};
    of.mesh.origin[3].x -= 0.1f;
    const PhotonGrid grid(*of.made, of.mesh);
    const Landed::Shape found = Landed(grid, 4, 2, {-0.8f, 0.6f, 0}).make(paper_point_footprint);
    EXPECT_FALSE(found.without_neighbors);
    EXPECT_NEAR(found.gain, 0.6f, 1e-5f);  // parallel rays, on a plane that leans by its normal's cosine
}

}  // namespace
}  // namespace dapple::methods
