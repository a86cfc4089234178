#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>

#include "methods/reference/own_picture.h"
#include "methods/reference/strata_layout.h"
#include "scene/frame_scene.h"

/// What is drawn at random of a light before its first event.
namespace dapple::reference {

/// One set of light rays, stratified over the water or over a light's view of a body of glass: each pass is
/// an estimate of its own.
struct LightPass {
    std::uint64_t number = 0;              ///< of the pass; its random numbers follow from it and `strata`
    std::size_t strata = 0;                ///< asked for; there may be a few more
    const StrataLayout* layout = nullptr;  ///< where they lie; null: evenly
};

/// Random numbers of a stratum, by what they are for.
enum class Dimension : std::uint32_t { along, across, facet, disc_radius, disc_angle };
constexpr std::uint32_t kDimensions = 5;

/// Draws for one source: a light, and what its light meets first.
class LightSamples {
public:
    /// `object` is light::kWater or an object of glass. `scene` outlives it.
    LightSamples(const scene::FrameScene& scene, std::uint32_t light, int object);

    double number(const LightPass& pass, std::size_t stratum, Dimension dimension) const;
    /// Index of the random numbers of the ray of a stratum.
    std::uint64_t ray(const LightPass& pass, std::size_t stratum) const;

private:
    const scene::FrameScene& scene_;
    std::uint32_t source_;
};

/// Equal strata over a rectangle where a pass has no layout.
struct StrataGrid {
    std::size_t columns = 1, rows = 1;

    /// At least as many as are asked for, nearly square on a rectangle of that width over height; 0: one row.
    StrataGrid(std::size_t strata, double aspect);
    std::size_t strata() const { return columns * rows; }
};

/// A direction of the sun's disc, evenly over the disc as seen on a plane that faces it, and the irradiance
/// on a plane across that very direction, over the sun's.
struct SunRay {
    glm::dvec3 direction;
    double irradiance;
};
SunRay sun_ray(const scene::Light& sun, double random_radius, double random_angle);

/// m, relative to FrameScene::origin: where a lamp's light starts. Of a part of an area light a point of it,
/// evenly by two random numbers.
glm::dvec3 emission_point(const scene::FrameScene& scene, const scene::Light& lamp, double random_first,
                          double random_second);

/// Two unit vectors across a unit axis.
struct AcrossAxis {
    glm::dvec3 u, v;
    explicit AcrossAxis(const glm::dvec3& axis);
};

/// Of a point light, a spot with its picture or a part of an area light, W/sr.
glm::dvec3 intensity_towards(const scene::Light& light, const OwnPicture& picture,
                             const glm::dvec3& direction);

}  // namespace dapple::reference
