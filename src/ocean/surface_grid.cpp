#include "ocean/surface_grid.h"

#include <cmath>

namespace dapple::ocean {

FieldFactor field_factor(Field field, glm::dvec2 wave_vector, double angular_frequency) {
    const double kx = wave_vector.x;
    const double kz = wave_vector.y;
    const double omega = angular_frequency;
    const double k = std::sqrt(kx * kx + kz * kz);
    // d/dx of c is kx d, of d it is -kx c; d/dt of c is -omega d, of d it is omega c. D = (k / |k|) d.
    switch (field) {
        case Field::height:
            return {1, true};
        case Field::slope_x:
            return {kx, false};
        case Field::slope_z:
            return {kz, false};
        case Field::height_rate:
            return {-omega, false};
        case Field::slope_rate_x:
            return {kx * omega, true};
        case Field::slope_rate_z:
            return {kz * omega, true};
        case Field::second_xx:
            return {-kx * kx, true};
        case Field::second_xz:
            return {-kx * kz, true};
        case Field::second_zz:
            return {-kz * kz, true};
        case Field::displacement_x:
            return {kx / k, false};
        case Field::displacement_z:
            return {kz / k, false};
        case Field::displacement_xx:
            return {-kx * kx / k, true};
        case Field::displacement_xz:
            return {-kx * kz / k, true};
        case Field::displacement_zz:
            return {-kz * kz / k, true};
    }
    return {};
}

std::vector<Field> fields_of(FieldMask mask) {
    std::vector<Field> fields;
    for (std::size_t i = 0; i < kFieldCount; ++i) {
        const auto field = static_cast<Field>(i);
        if (mask & field_bit(field)) fields.push_back(field);
    }
    return fields;
}

void add_sinusoid(SurfaceSample& sample, double c, double d, glm::dvec2 wave_vector,
                  double angular_frequency) {
    const auto value = [&](Field field) {
        const FieldFactor f = field_factor(field, wave_vector, angular_frequency);
        return f.factor * (f.of_cosine ? c : d);
    };
    sample.height += value(Field::height);
    sample.slope += glm::dvec2(value(Field::slope_x), value(Field::slope_z));
    sample.height_rate += value(Field::height_rate);
    sample.slope_rate += glm::dvec2(value(Field::slope_rate_x), value(Field::slope_rate_z));
    sample.d2[0] += value(Field::second_xx);
    sample.d2[1] += value(Field::second_xz);
    sample.d2[2] += value(Field::second_zz);
}

}  // namespace dapple::ocean
