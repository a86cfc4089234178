#include "scene/medium.h"

#include <algorithm>
#include <cmath>

#include "base/number_pattern.h"

namespace dapple::scene {

// Solonenko & Mobley, Inherent optical properties of Jerlov water types, Applied Optics 54(17), 2015, tables
// 7 and 8 (as far as they are known to be sound), who inverted the diffuse attenuation by which Jerlov
// (Marine Optics, 1976) told his types apart. Red, green and blue are their rows at 650, 550 and 450 nm,
// taken from public transcriptions of the tables and not compared with the print. Where that cannot be:
//  * IA, IB: absorption at 450 nm lies between those of I and II as Jerlov's K_d there (0.019, 0.026, 0.036,
//    0.062 /m); at 550 and 650 nm the two agree. Scattering is the paper's equation 8 (Haltrin 1999: water,
//    small and large particles) fitted to its printed values, to two digits.
//  * 5C at 650 nm: the printed rows repeat those at 350 nm. Scattering is that at 550 nm times the ratio that
//    all types of equation 8 but the clearest share, 0.753; absorption lies between 3C and 7C as at 550 nm.
// The scattering of types II to 5C is two to four times that of waters measured since (Williamson & Hollins,
// Applied Optics 61(33), 2022): give `scattering` for a clearer look of the same colour.
WaterCoefficients jerlov_coefficients(JerlovType type) {
    switch (type) {
        case JerlovType::none:
            return {};
        case JerlovType::I:
            return {{0.334, 0.062, 0.018}, {0.000899, 0.00170, 0.00381}};
        case JerlovType::IA:
            return {{0.334, 0.062, 0.019}, {0.0023, 0.0035, 0.0063}};
        case JerlovType::IB:
            return {{0.334, 0.062, 0.020}, {0.045, 0.054, 0.069}};
        case JerlovType::II:
            return {{0.334, 0.0622, 0.0241}, {0.270, 0.358, 0.504}};
        case JerlovType::III:
            return {{0.336, 0.0646, 0.0388}, {0.737, 0.980, 1.38}};
        case JerlovType::C1:
            return {{0.344, 0.076, 0.105}, {0.274, 0.365, 0.514}};
        case JerlovType::C3:
            return {{0.346, 0.082, 0.154}, {0.800, 1.06, 1.50}};
        case JerlovType::C5:
            return {{0.364, 0.117, 0.297}, {1.00, 1.33, 1.87}};
        case JerlovType::C7:
            return {{0.403, 0.195, 0.542}, {1.77, 2.35, 3.30}};
        case JerlovType::C9:
            return {{0.456, 0.348, 0.943}, {2.35, 3.12, 4.39}};
    }
    return {};
}

std::int64_t file_number(const Medium& medium, std::int64_t frames) {
    // A step of 1 / 3 must not miss the file that begins with every third frame.
    constexpr double kRounding = 1e-6;  // files
    const std::int64_t count = medium.last_file - medium.first_file + 1;
    auto file = static_cast<std::int64_t>(std::floor(static_cast<double>(frames) * medium.step + kRounding));
    if (medium.loop)
        file = (file % count + count) % count;
    else
        file = std::clamp<std::int64_t>(file, 0, count - 1);
    return medium.first_file + file;
}

std::string file_path(const Medium& medium, std::int64_t number) {
    // A '#' in the name of a folder is no place for a number.
    const std::size_t name = medium.file.find_last_of('/') + 1;  // 0 where there is no folder
    NumberPattern place = find_number(std::string_view(medium.file).substr(name));
    if (place.length == 0) return medium.file;
    place.begin += name;
    return with_number(medium.file, place, number);
}

}  // namespace dapple::scene
