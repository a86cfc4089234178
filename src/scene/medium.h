#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "scene/transform.h"

/// Plain data of what light is absorbed and scattered by on its way. Scattering and absorption are per metre
/// and channel.
namespace dapple::scene {

enum class PhaseType { isotropic, henyey_greenstein, two_lobe, fournier_forand, table };

/// A value of a tabulated phase function.
struct PhaseSample {
    double angle = 0;  ///< rad between the ways before and after scattering: 0 is straight on
    double value = 1;  ///< relative; the table is normalised
};

/// How scattered light is shared among directions: p(cos), normalised over the sphere, /sr.
struct PhaseFunction {
    PhaseType type = PhaseType::isotropic;
    /// Mean cosine, of Henyey-Greenstein's function and of two_lobe's first lobe; in timelines from -0.75 to
    /// 0.99, narrower peaks are not resolved by all methods.
    double anisotropy = 0.8;
    double back_anisotropy = -0.5;     ///< two_lobe: of the other lobe, the same
    double forward_share = 0.95;       ///< two_lobe: of the light that the first lobe takes, [0, 1]
    double particle_index = 1.1;       ///< Fournier-Forand: refractive index of the particles against water
    double size_slope = 3.6;           ///< Fournier-Forand: exponent of the (hyperbolic) size distribution
    std::vector<PhaseSample> samples;  ///< table: ascending angles
};

/// Optical water types (Jerlov 1976), clear ocean to turbid coast: presets of absorption and scattering.
enum class JerlovType { none, I, IA, IB, II, III, C1, C3, C5, C7, C9 };

/// Absorption and scattering of a water, /m, red, green, blue.
struct WaterCoefficients {
    glm::dvec3 absorption{0};
    glm::dvec3 scattering{0};
};

/// Of a water type, at 650, 550 and 450 nm. Type none: zeros. medium.cpp says where the numbers are from.
WaterCoefficients jerlov_coefficients(JerlovType type);

enum class MediumType {
    box,   ///< homogeneous
    grid,  ///< OpenVDB files
};

/// On which side of the water a medium lies; where it reaches across, the rest is cut off.
enum class MediumSide { everywhere, air, water };

/// What to show where a file of a sequence is not there.
enum class MissingGrid { error, hold, empty };

/// A bounded medium. Extinction is density times `extinction`, in /m; `albedo` of it is scattered.
struct Medium {
    std::string name;
    MediumType type = MediumType::grid;
    MediumSide side = MediumSide::everywhere;
    double density = 1;                ///< factor of all densities
    glm::dvec3 extinction{1, 1, 1};    ///< /m where density is 1
    glm::dvec3 albedo{0.9, 0.9, 0.9};  ///< share of the extinction that scatters, [0, 1]
    PhaseFunction phase;
    Transform transform;
    glm::dvec3 size{1, 1, 1};  ///< m; box, centred
    std::string file;          ///< grid: a path, or a pattern with a place for the number
    std::string grid = "density";
    std::int64_t first_file = 1;  ///< number of the file shown at the clip's first frame
    std::int64_t last_file = 1;   ///< after it `loop` says what comes
    double step = 1;              ///< files a frame; the nearest file at or before is shown
    bool loop = false;            ///< begin again with first_file, or hold the last
    MissingGrid missing = MissingGrid::error;
    bool z_up = false;  ///< the file's z axis points up (turned so that it becomes y)
};

/// Number of the file of a grid that shows `frames` frames after the clip's first (also before it).
std::int64_t file_number(const Medium& medium, std::int64_t frames);
/// Path of that file: the medium's, with %04d, %d or #### (if its name has one) replaced by `number`.
std::string file_path(const Medium& medium, std::int64_t number);

}  // namespace dapple::scene
