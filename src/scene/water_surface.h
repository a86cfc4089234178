#pragma once
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

namespace dapple::scene {

/// One sinusoid: height = amplitude * cos(k . (x, z) - omega t + phase), k = wave_number * (cos,
/// sin)(heading).
struct Wave {
    double length = 1;             ///< m
    double heading = 0;            ///< rad, direction of travel: 0 is +x, 90 deg is +z
    double amplitude = 0;          ///< m
    double phase = 0;              ///< rad
    glm::dvec2 wave_vector{0, 0};  ///< rad/m, x and z, as written; length and heading follow from it
};

/// omega^2 = (g k + (sigma / rho) k^3) tanh(k depth).
struct Waves {
    std::vector<Wave> waves;
    double depth = 1e4;  ///< m, of the dispersion relation
};

/// JONSWAP sea by FFT.
struct Spectrum {
    double wind_speed = 5;          ///< m/s at 10 m
    double wind_heading = 0;        ///< rad, as Wave::heading
    double fetch = 1e4;             ///< m
    double depth = 1e4;             ///< m
    double peak_enhancement = 3.3;  ///< gamma
    double spreading = 4;           ///< s of cos^2s(theta / 2)
    double choppiness = 0;          ///< factor of the horizontal displacement
    double cutoff_length = 0.25;    ///< m, shortest wave
    double amplitude_scale = 1;     ///< factor on all heights
    /// m, way after which the sea repeats along x and z, rounded so that the water's extent has whole ones;
    /// 0: it repeats with the extent.
    double period = 0;
    double loop = 0;  ///< s, period after which the sea repeats; 0: it does not
    std::uint64_t seed = 1;
};

enum class UpAxis { y, z };
enum class MissingFrames { error, hold };

/// Meshes read from files, one a frame of the file's own clock; between files the earlier one holds.
struct MeshSequence {
    std::string pattern;          ///< path with %04d or ####
    std::int64_t first_file = 1;  ///< number of the file shown at time 0
    std::int64_t last_file = 1;
    double fps = 24;  ///< of the files
    UpAxis up = UpAxis::y;
    double scale = 1;
    glm::dvec3 offset{0, 0, 0};  ///< m, after scaling and turning
    MissingFrames missing = MissingFrames::error;
};

/// Number of the file that shows at `time` seconds; the last one that began, within [first_file, last_file].
std::int64_t file_number(const MeshSequence& sequence, double time);
/// The pattern with its %04d, %d or #### replaced by `number`.
std::string file_path(const MeshSequence& sequence, std::int64_t number);

enum class WaterSurfaceType { waves, spectrum, mesh_sequence };

struct WaterSurface {
    WaterSurfaceType type = WaterSurfaceType::waves;
    Waves waves;  ///< an empty list is flat water
    Spectrum spectrum;
    MeshSequence mesh_sequence;
};

}  // namespace dapple::scene
