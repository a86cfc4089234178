// What may stand in the light: tests by boxes against sampled segments and rays, and E beside an object.
#include <gtest/gtest.h>

#include <random>

#include "closed_form/beam_sheets.h"
#include "closed_form/flat_scene.h"
#include "closed_form/gentle_sea.h"
#include "methods/sliced_beams/occluders.h"
#include "ocean/water_surface.h"

namespace dapple {
namespace {

using light::BeamSheet;
using light::Event;
using methods::sliced_beams::Bounds;
using methods::sliced_beams::may_meet;
using methods::sliced_beams::Occluders;
using methods::sliced_beams::QueryCounts;

class Random {
public:
    explicit Random(unsigned seed) : engine_(seed) {}
    double uniform(double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(engine_);
    }
    bool chance(double share) { return uniform(0, 1) < share; }
    glm::dvec3 point(double low, double high) {
        return {uniform(low, high), uniform(low, high), uniform(low, high)};
    }

private:
    std::mt19937 engine_;
};

// ---- boxes ------------------------------------------------------------------------------------------------

/// Some are flat, thin or points, as the boxes of planes, level receivers and lamps are.
Bounds random_box(Random& random) {
    const glm::dvec3 centre = random.point(-3, 3);
    glm::dvec3 half = random.point(0, 1);
    for (int axis = 0; axis < 3; ++axis)
        if (random.chance(0.25)) half[axis] = 0;
    return {centre - half, centre + half};
}

glm::dvec3 point_of(const Bounds& box, Random& random) {
    glm::dvec3 share;
    for (int axis = 0; axis < 3; ++axis)
        share[axis] = random.chance(0.5) ? std::round(random.uniform(0, 1)) : random.uniform(0, 1);
    return glm::mix(box.low, box.high, share);
}

bool meets(const Bounds& box, glm::dvec3 from, glm::dvec3 to) {
    double enter = 0, leave = 1;
    for (int axis = 0; axis < 3; ++axis) {
        const double way = to[axis] - from[axis];
        if (way == 0) {
            if (from[axis] < box.low[axis] || from[axis] > box.high[axis]) return false;
            continue;
        }
        const double s = (box.low[axis] - from[axis]) / way, t = (box.high[axis] - from[axis]) / way;
        enter = std::max(enter, std::min(s, t));
        leave = std::min(leave, std::max(s, t));
    }
    return enter <= leave;
}

TEST(MayMeet, IsNeverFalseWhereASegmentMeetsTheObject) {
    Random random(1);
    int met = 0;
    for (int i = 0; i < 30000; ++i) {
        const Bounds from = random_box(random), to = random_box(random), object = random_box(random);
        bool meeting = false;
        for (int k = 0; k < 30 && !meeting; ++k)
            meeting = meets(object, point_of(from, random), point_of(to, random));
        met += meeting;
        // Boxes that are flat along the same axis meet in a plane: a rounding decides.
        const Bounds with_room{object.low - 1e-12, object.high + 1e-12};
        ASSERT_TRUE(!meeting || may_meet(from, to, with_room)) << "triple " << i;
    }
    EXPECT_GT(met, 1000);
}

TEST(MayMeet, HoldsForAnObjectThatASegmentOnlyTouches) {
    // The object's corner lies on a segment, itself often between corners of the two boxes.
    Random random(2);
    for (int i = 0; i < 30000; ++i) {
        const Bounds from = random_box(random), to = random_box(random);
        const glm::dvec3 touched =
            glm::mix(point_of(from, random), point_of(to, random), random.uniform(0, 1));
        Bounds object;
        object.widen(touched);
        object.widen(touched + random.point(-1, 1));
        object.low -= 1e-13;  // the rounding of the point
        object.high += 1e-13;
        ASSERT_TRUE(may_meet(from, to, object)) << "triple " << i;
    }
}

TEST(MayMeet, IsFalseForMostObjectsThatLieClearlyApart) {
    // Clearly: 0.2 m or more lie between the object and the hull of the two boxes along some direction.
    Random random(3);
    std::vector<glm::dvec3> directions;
    while (directions.size() < 200) {
        const glm::dvec3 d = random.point(-1, 1);
        if (glm::length(d) > 0.1 && glm::length(d) < 1) directions.push_back(glm::normalize(d));
    }
    const auto furthest = [](const Bounds& box, glm::dvec3 d) {
        return glm::dot(d, 0.5 * (box.low + box.high)) + glm::dot(glm::abs(d), 0.5 * (box.high - box.low));
    };
    int apart = 0, free = 0;
    for (int i = 0; i < 10000; ++i) {
        const Bounds from = random_box(random), to = random_box(random), object = random_box(random);
        const bool clear = std::any_of(directions.begin(), directions.end(), [&](glm::dvec3 d) {
            return std::max(furthest(from, d), furthest(to, d)) + 0.2 < -furthest(object, -d);
        });
        if (!clear) continue;
        ++apart;
        free += !may_meet(from, to, object);
    }
    const double share = static_cast<double>(free) / apart;
    printf("of %d triples that are clearly apart, %.1f %% are found free\n", apart, 100 * share);
    EXPECT_GT(apart, 3000);
    EXPECT_GT(share, 0.99);
    EXPECT_FALSE(may_meet({{0, 0, 0}, {1, 1, 1}}, {{4, 4, 0}, {5, 5, 1}}, {{4, 0, 0}, {5, 1, 1}}));
}

// ---- a scene ----------------------------------------------------------------------------------------------

enum class Lit { sun, lamp_above, lamp_below };

constexpr std::uint32_t kFloor = 0, kColumn = 1;
constexpr double kFloorHeight = -2, kCeilingHeight = 2.5;

/// Gentle waves over a floor with a column on it that is turned; a board hangs in the air.
scene::FrameScene make_scene(Lit lit) {
    scene::FrameScene scene;
    scene::Water& water = scene.state.water.emplace();
    water.extent.size = {6, 6};
    water.absorption = {0, 0, 0};
    water.surface.waves = test::gentle_waves();
    water.mesh_cells = 90;
    scene.water = std::make_shared<scene::WaterMesh>(ocean::WaterSurface(water).mesh(0));
    const auto box = [](const char* name, glm::dvec3 size, glm::dvec3 position, double turned) {
        scene::Object object;
        object.name = name;
        object.shape = scene::Shape::box;
        object.size = size;
        object.transform.position = position;
        object.transform.rotation.y = turned;
        return object;
    };
    scene.state.objects = {test::level_plane("floor", kFloorHeight, 10),
                           box("column", {0.5, 1.5, 0.4}, {0.3, -1.2, 0.1}, 0.5),
                           box("parasol", {0.7, 0.05, 0.6}, {-1, 1, 0.4}, 0.2)};
    scene.state.lights = {test::sun_from_zenith(35)};
    if (lit != Lit::sun) {
        scene.state.lights[0].type = scene::LightType::point;
        scene.state.lights[0].position =
            lit == Lit::lamp_above ? glm::dvec3(-0.6, 2.5, 0.2) : glm::dvec3(-0.5, -1.6, -0.3);
    }
    return scene;
}

/// Rays of a patch of the water, from where they leave it to where they land on a level plane.
struct Patch {
    std::vector<glm::dvec3> water, landed;  // m, world
    Bounds surface[2], receivers[2];        // in the sheet's axes and in the world's
};

/// False where the sheet has not all rays of the patch.
bool make_patch(const BeamSheet<double>& sheet, double height, int row, int column, int size, Patch& patch) {
    for (int r = row; r <= row + size; ++r) {
        for (int c = column; c <= column + size; ++c) {
            const auto i = static_cast<std::size_t>(r * sheet.columns + c);
            if (!sheet.valid[i]) return false;
            const auto& ray = sheet.rays[i];
            const auto at = [&](double depth) {
                return glm::dvec3(ray.a + depth * ray.slope_a, ray.b + depth * ray.slope_b, depth);
            };
            const double from = (sheet.world_from_mesh * at(0)).y, to = (sheet.world_from_mesh * at(1)).y;
            const double depth = (height - from) / (to - from);
            if (!(depth > sheet.start[i] && depth < 20)) return false;
            patch.surface[0].widen(at(sheet.start[i]));
            patch.receivers[0].widen(at(depth));
            patch.water.push_back(sheet.world_from_mesh * at(sheet.start[i]));
            patch.landed.push_back(sheet.world_from_mesh * at(depth));
        }
    }
    for (const glm::dvec3& point : patch.water) patch.surface[1].widen(point);
    for (const glm::dvec3& point : patch.landed) patch.receivers[1].widen(point);
    return true;
}

glm::dvec3 mixed(const std::vector<glm::dvec3>& points, Random& random) {
    const auto pick = [&] {
        return points[static_cast<std::size_t>(random.uniform(0, static_cast<double>(points.size())))];
    };
    const double s = random.uniform(0, 1);
    return glm::mix(pick(), pick(), random.chance(0.5) ? 0 : s);
}

/// Whether an object stands on the way, but for its last thousandth at either end.
bool blocked(const rays::RayScene& rays, glm::dvec3 from, glm::dvec3 to) {
    const rays::Ray ray{glm::vec3(from), 1e-3f, glm::vec3(to - from), 0.999f};
    std::uint8_t hit = 0;
    rays.occluded_by_objects({&ray, 1}, {&hit, 1});
    return hit != 0;
}

struct Tally {
    int asked = 0, free = 0, blocked = 0;
    double share_found() const { return static_cast<double>(free) / (asked - blocked); }
};

class OccludersOf : public testing::TestWithParam<Lit> {};
constexpr const char* kLitNames[] = {"Sun", "LampAbove", "LampBelow"};
INSTANTIATE_TEST_SUITE_P(Lights, OccludersOf, testing::Values(Lit::sun, Lit::lamp_above, Lit::lamp_below),
                         [](const auto& lit) { return kLitNames[static_cast<int>(lit.param)]; });

TEST_P(OccludersOf, WhatTheyCallFreeIsFree) {
    const scene::FrameScene scene = make_scene(GetParam());
    const rays::RayScene rays(scene);
    const scene::Light& light = scene.state.lights[0];
    const test::SheetSet<double> sheets(scene, Event::transmission, 20);
    Random random(7);
    Tally after, before;
    for (const auto& coverage : sheets.sheets()) {
        const BeamSheet<double>& sheet = coverage->sheet();
        const Occluders occluders(scene, sheet);
        const double height = sheet.in_water() ? kFloorHeight : kCeilingHeight;
        for (int i = 0; i < 3000; ++i) {
            const int size = static_cast<int>(random.uniform(1, 9));
            const int row = static_cast<int>(random.uniform(0, sheet.rows - size - 1));
            const int column = static_cast<int>(random.uniform(0, sheet.columns - size - 1));
            Patch patch;
            if (!make_patch(sheet, height, row, column, size, patch)) continue;
            bool after_blocked = false, before_blocked = false;
            for (int k = 0; k < 30; ++k) {
                const glm::dvec3 water = mixed(patch.water, random);
                after_blocked |= blocked(rays, water, mixed(patch.landed, random));
                const bool sun = light.type == scene::LightType::sun;
                before_blocked |= blocked(rays, water, sun ? water - 10.0 * light.direction : light.position);
            }
            const bool after_free = occluders.free_after_water(patch.surface, patch.receivers, kFloor);
            const bool before_free = occluders.free_before_water(patch.surface[1]);
            ASSERT_FALSE(after_blocked && after_free) << row << ' ' << column << ' ' << size;
            ASSERT_FALSE(before_blocked && before_free) << row << ' ' << column << ' ' << size;
            ++after.asked;
            ++before.asked;
            after.blocked += after_blocked;
            before.blocked += before_blocked;
            after.free += after_free;
            before.free += before_free;
            if (!sheet.in_water()) continue;
            // The floor is in the way of its own receivers unless it is named as theirs.
            ASSERT_FALSE(occluders.free_after_water(patch.surface, patch.receivers, kColumn));
        }
    }
    printf("after the water: %d patches, %d blocked, of the others %.1f %% found free; before: %d, %.1f %%\n",
           after.asked, after.blocked, 100 * after.share_found(), before.blocked, 100 * before.share_found());
    EXPECT_GT(after.blocked, 50);
    EXPECT_GT(before.blocked, 50);
    // The rest lies beside the boxes about turned boxes, or is blocked in a corner that no sample met.
    EXPECT_GT(after.share_found(), 0.9);
    EXPECT_GT(before.share_found(), 0.9);
}

// ---- E beside an object -----------------------------------------------------------------------------------

/// A thin upright plate, turned by 45 degrees: light falls through two corners of its bounding box. Overhead
/// sun on waves that move it by less than 10 cm at 1.5 m.
template <class Real>
struct BesideAPlate {
    static constexpr double kDepth = 1.5, kLength = 1.6;

    explicit BesideAPlate(bool plate) : scene_(make(plate)), sheets_(scene_, Event::transmission, 3) {}

    /// Receivers in tiles of 8 x 8 about (x, z) = +-(0.32, -0.32), under the two corners: W/m^2.
    std::vector<double> irradiance(double size, QueryCounts& counts) const {
        std::vector<double> result;
        for (const double side : {-1.0, 1.0}) {
            std::vector<methods::sliced_beams::Receiver<Real>> receivers;
            for (int i = 0; i < 64; ++i) {
                const int row = i / 8, column = i % 8;
                const double x = side * 0.32 + size * (column - 3.5), z = -side * 0.32 + size * (row - 3.5);
                receivers.push_back(test::receiver<Real>({x, -kDepth, z}, {0, 1, 0}, {size, size}));
            }
            add(receivers, counts, result);
        }
        return result;
    }
    /// One receiver of side `size`.
    double irradiance_at(double x, double z, double size, QueryCounts& counts) const {
        std::vector<double> result;
        add({test::receiver<Real>({x, -kDepth, z}, {0, 1, 0}, {size, size})}, counts, result);
        return result[0];
    }

private:
    void add(const std::vector<methods::sliced_beams::Receiver<Real>>& receivers, QueryCounts& counts,
             std::vector<double>& result) const {
        std::vector<glm::vec<3, Real>> sums(receivers.size(), glm::vec<3, Real>(0));
        for (const auto& sheet : sheets_.sheets()) sheet->add(receivers, kFloor, std::span(sums), counts);
        for (const auto& value : sums) result.push_back(static_cast<double>(value.x));
    }
    static scene::FrameScene make(bool plate) {
        scene::FrameScene scene;
        scene::Water& water = scene.state.water.emplace();
        water.extent.size = {4, 4};
        water.absorption = {0, 0, 0};
        water.surface.waves = test::gentle_waves();
        water.mesh_cells = 200;  // 2 cm
        scene.water = std::make_shared<scene::WaterMesh>(ocean::WaterSurface(water).mesh(0));
        scene.state.lights = {test::sun_from_zenith(0)};
        scene.state.objects = {test::level_plane("floor", -kDepth, 10)};
        if (!plate) return scene;
        scene::Object object;
        object.shape = scene::Shape::box;
        object.size = {kLength, 1, 0.02};
        object.transform.position = {0, -0.8, 0};
        // Its length runs along (1, 0, 1): the corners that light falls through are at (x, -x).
        object.transform.rotation.y = -0.25 * glm::pi<double>();
        scene.state.objects.push_back(object);
        return scene;
    }

    scene::FrameScene scene_;
    test::SheetSet<Real> sheets_;
};

template <class Real>
class Plate : public testing::Test {};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(Plate, Reals);

TYPED_TEST(Plate, LightBesideItIsThatWithoutIt) {
    const BesideAPlate<TypeParam> with(true), without(false);
    // Sums of the same shares in another order, single beams for sums of nodes: up to some 100 additions.
    const double tolerance = 64 * static_cast<double>(std::numeric_limits<TypeParam>::epsilon());
    // Receivers far smaller than the beams of 2 cm, a little larger, and so large that nodes are added whole.
    for (const double size : {0.002, 0.03}) {
        QueryCounts beside, alone;
        const std::vector<double> expected = without.irradiance(size, alone);
        const std::vector<double> found = with.irradiance(size, beside);
        double worst = 0, sum = 0, expected_sum = 0;
        for (std::size_t i = 0; i < found.size(); ++i) {
            worst = std::max(worst, std::abs(found[i] / expected[i] - 1));
            sum += found[i];
            expected_sum += expected[i];
        }
        printf("receivers of %.3f m: E off by %.1e, energy by %.1e; %zu shadow rays\n", size, worst,
               std::abs(sum / expected_sum - 1), beside.shadow_rays);
        EXPECT_LT(worst, tolerance);
        EXPECT_LT(std::abs(sum / expected_sum - 1), std::min(1e-6, tolerance));
        EXPECT_EQ(alone.occluded_tiles, 0u);
        EXPECT_EQ(alone.shadow_rays, 0u);
        EXPECT_GE(beside.occluded_tiles, 2u);
        EXPECT_GT(beside.shadow_rays, found.size());
    }
    for (const double side : {-1.0, 1.0}) {
        QueryCounts beside, alone;
        const double expected = without.irradiance_at(side * 0.36, -side * 0.36, 0.3, alone);
        const double found = with.irradiance_at(side * 0.36, -side * 0.36, 0.3, beside);
        EXPECT_NEAR(found / expected, 1, tolerance);
        EXPECT_GT(alone.whole_nodes, 0u);
        EXPECT_EQ(beside.whole_nodes, 0u);
        EXPECT_EQ(beside.occluded_tiles, 1u);
    }
    // Below the plate there is a shadow for receivers of all sizes. A large one loses what falls on the
    // plate's upper edge, 2 cm along the diagonal; waves may move a half of that elsewhere.
    QueryCounts counts;
    EXPECT_LT(with.irradiance_at(0, 0, 0.004, counts), 0.01 * without.irradiance_at(0, 0, 0.004, counts));
    const double kept = with.irradiance_at(0, 0, 0.35, counts) / without.irradiance_at(0, 0, 0.35, counts);
    printf("of 0.35 m below the plate %.1f %% is lit\n", 100 * kept);
    const double hidden = 0.02 * 0.35 * std::numbers::sqrt2 / (0.35 * 0.35);
    EXPECT_LT(kept, 1 - 0.5 * hidden);
}

}  // namespace
}  // namespace dapple
