#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace dapple::ocean {

/// Quantities of a surface h(x, z, t) that can be asked for. `displacement` is the horizontal displacement at
/// choppiness 1 (crests sharpen, as in Tessendorf 2001, section 4.6, with the sign turned).
enum class Field : std::uint8_t {
    height,           ///< h, m
    slope_x,          ///< dh/dx
    slope_z,          ///< dh/dz
    height_rate,      ///< dh/dt, m/s
    slope_rate_x,     ///< d2h/dxdt, 1/s
    slope_rate_z,     ///< d2h/dzdt, 1/s
    second_xx,        ///< d2h/dx2, 1/m
    second_xz,        ///< d2h/dxdz, 1/m
    second_zz,        ///< d2h/dz2, 1/m
    displacement_x,   ///< D_x, m
    displacement_z,   ///< D_z, m
    displacement_xx,  ///< dD_x/dx
    displacement_xz,  ///< dD_x/dz = dD_z/dx
    displacement_zz,  ///< dD_z/dz
};
constexpr std::size_t kFieldCount = 14;

/// A set of fields as bits.
using FieldMask = std::uint32_t;
constexpr FieldMask field_bit(Field field) {
    return FieldMask{1} << static_cast<unsigned>(field);
}
constexpr FieldMask kHeight = field_bit(Field::height);
constexpr FieldMask kSlope = field_bit(Field::slope_x) | field_bit(Field::slope_z);
constexpr FieldMask kHeightRate = field_bit(Field::height_rate);
constexpr FieldMask kSlopeRate = field_bit(Field::slope_rate_x) | field_bit(Field::slope_rate_z);
constexpr FieldMask kSecondDerivatives =
    field_bit(Field::second_xx) | field_bit(Field::second_xz) | field_bit(Field::second_zz);
constexpr FieldMask kDisplacement = field_bit(Field::displacement_x) | field_bit(Field::displacement_z);
constexpr FieldMask kDisplacementGradient =
    field_bit(Field::displacement_xx) | field_bit(Field::displacement_xz) | field_bit(Field::displacement_zz);

/// How a sinusoid c = a cos(phi), phi = k . (x, z) - omega t + phase, with d = -a sin(phi), enters a field:
/// field = factor * (of_cosine ? c : d). Derivatives of sums of sinusoids follow without differences.
struct FieldFactor {
    double factor = 0;
    bool of_cosine = true;
};
FieldFactor field_factor(Field field, glm::dvec2 wave_vector, double angular_frequency);

/// The fields at the vertices of the surface's grid (before any horizontal displacement), row-major, rows
/// along z.
struct SurfaceGrid {
    int rows = 0;     ///< vertices along z: cells + 1
    int columns = 0;  ///< vertices along x: cells + 1
    std::array<std::vector<double>, kFieldCount>
        values;  ///< rows * columns entries where asked for, else empty
    const std::vector<double>& operator[](Field field) const {
        return values[static_cast<std::size_t>(field)];
    }
    std::vector<double>& operator[](Field field) { return values[static_cast<std::size_t>(field)]; }
};

/// The fields of `mask`, in the order of the enumeration.
std::vector<Field> fields_of(FieldMask mask);

/// The surface at one point, before any horizontal displacement.
struct SurfaceSample {
    double height = 0;            ///< m
    glm::dvec2 slope{0, 0};       ///< along x, z
    glm::dvec2 slope_rate{0, 0};  ///< 1/s
    double height_rate = 0;       ///< m/s
    double d2[3] = {0, 0, 0};     ///< second derivatives xx, xz, zz, 1/m
};

/// Adds one sinusoid with c and d as in FieldFactor.
void add_sinusoid(SurfaceSample& sample, double c, double d, glm::dvec2 wave_vector,
                  double angular_frequency);

}  // namespace dapple::ocean
