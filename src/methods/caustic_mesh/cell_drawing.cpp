#include "methods/caustic_mesh/cell_drawing.h"

#include <algorithm>
#include <cmath>

namespace dapple::methods::caustic_mesh {
namespace {

// A plane seen more edge-on than this covers no pixel.
constexpr float kLeastViewCosine = 1e-4f;
// Receivers within this share of a cell's extent of its plane are on the same surface: the sagitta of a cell
// as large as half the radius of curvature.
constexpr float kPlaneTolerance = 0.25f;
// Pixels: thinner cells would have no digits left of their coverage.
constexpr float kThinnest = 0.02f;
// Pixels whose shading costs as much as what a quad costs more than a point before it is shaded (measured on
// lavapipe, pool: 64 costs 5 % more).
constexpr float kQuadSetup = 16;
// Areas about a corner against the cell's own: where they differ more, near a fold, they do not tell how its
// brightness varies.
constexpr float kMostContrast = 2;

float area(glm::vec3 a, glm::vec3 b, glm::vec3 c) {
    return 0.5f * glm::length(glm::cross(b - a, c - a));
}

float cross_of(glm::vec2 a, glm::vec2 b) {
    return a.x * b.y - a.y * b.x;
}

/// Orthonormal, on the plane.
void basis(glm::vec3 normal, glm::vec3& right, glm::vec3& up) {
    right = glm::normalize(std::abs(normal.x) < 0.7f ? glm::cross(normal, glm::vec3(1, 0, 0))
                                                     : glm::cross(normal, glm::vec3(0, 1, 0)));
    up = glm::cross(normal, right);
}

glm::vec3 middle_of(const LandedCell& cell) {
    return 0.25f * (cell.corner[0] + cell.corner[1] + cell.corner[2] + cell.corner[3]);
}

bool finite(const layout::MeshCell& cell) {
    const glm::vec3 sum = cell.corner_0 + cell.corner_1 + cell.corner_2 + cell.corner_3 + cell.irradiance_0 +
                          cell.irradiance_1 + cell.irradiance_2 + cell.irradiance_3 + cell.facing;
    return std::isfinite(sum.x + sum.y + sum.z + cell.tolerance + cell.disc);
}

}  // namespace

CellDrawing::CellDrawing(const scene::FrameScene& scene, bool in_water, float largest_point)
    : picture_(scene), in_water_(in_water), largest_point_(largest_point) {}

bool CellDrawing::seen(const LandedCell& cell) const {
    const glm::vec3 to_camera = picture_.to_camera(cell.corner[0]);
    PictureCover box, tight;
    return glm::dot(cell.normal, to_camera) >= kLeastViewCosine * glm::length(to_camera) &&
           cover(cell, box, tight);
}

float CellDrawing::width(const LandedCell& cell) const {
    std::array<glm::vec2, 4> pixel;
    for (std::size_t k = 0; k < 4; ++k)
        if (!picture_.project(cell.corner[k], pixel[k])) return HUGE_VALF;
    float longest = 0;
    for (std::size_t k = 0; k < 4; ++k)
        longest = std::max(longest, glm::distance(pixel[k], pixel[(k + 1) % 4]));
    return longest;
}

/// m^2, square of the width of a box with the variance of the disc's image: w^2 / 12 = R^2 / 4.
float CellDrawing::disc_box(const LandedCell& cell) {
    return 3 * cell.disc * cell.disc;
}

/// m on the plane that the disc's part of the filter reaches from its middle.
float CellDrawing::disc_reach(const LandedCell& cell) {
    return 0.5f * std::sqrt(disc_box(cell)) / std::max(0.01f, std::abs(glm::dot(cell.beam, cell.normal)));
}

float CellDrawing::filter(const LandedCell& cell) const {
    glm::vec2 pixel;
    if (!picture_.project(cell.corner[0], pixel)) return 0;
    glm::vec3 gradient_x, gradient_y;
    picture_.gradients(cell.corner[0], gradient_x, gradient_y);
    return 0.5f + disc_reach(cell) * std::max(glm::length(gradient_x), glm::length(gradient_y));
}

/// The pixels whose filters reach the cell. The disc's part of a filter is that at the pixel's receiver.
bool CellDrawing::cover(const LandedCell& cell, PictureCover& box, PictureCover& tight) const {
    const glm::vec2 pixel(0.5f);
    if (!(cell.disc > 0)) return picture_.cover(cell.corner, pixel, box, tight);
    // What lies within the disc's reach, on the plane.
    glm::vec3 right, up;
    basis(cell.normal, right, up);
    const glm::vec3 middle = middle_of(cell);
    glm::vec2 half(0);
    for (const glm::vec3& corner : cell.corner)
        half = glm::max(half,
                        glm::abs(glm::vec2(glm::dot(corner - middle, right), glm::dot(corner - middle, up))));
    half += disc_reach(cell);
    const glm::vec3 a = half.x * right, b = half.y * up;
    return picture_.cover({middle - a - b, middle + a - b, middle + a + b, middle - a + b}, pixel, box,
                          tight);
}

/// Makes a cell that is thinner than kThinnest that wide, where and as long as it is.
bool CellDrawing::widen(LandedCell& cell) const {
    std::array<glm::vec2, 4> pixel;
    for (std::size_t k = 0; k < 4; ++k)
        if (!picture_.project(cell.corner[k], pixel[k])) return false;
    const float covered = 0.5f * (std::abs(cross_of(pixel[1] - pixel[0], pixel[2] - pixel[0])) +
                                  std::abs(cross_of(pixel[2] - pixel[0], pixel[3] - pixel[0])));
    glm::vec2 longest(0);
    for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t j = 0; j < k; ++j) {
            const glm::vec2 way = pixel[k] - pixel[j];
            if (glm::dot(way, way) > glm::dot(longest, longest)) longest = way;
        }
    const float length = glm::length(longest);
    if (!(covered < kThinnest * length) && length >= kThinnest) return false;
    const glm::vec2 along = length > 0 ? longest / length : glm::vec2(1, 0);
    const float half = 0.5f * std::max(length, kThinnest);

    // Back onto the plane.
    const glm::vec3 middle = middle_of(cell);
    glm::vec3 gradient_x, gradient_y, right, up;
    picture_.gradients(middle, gradient_x, gradient_y);
    basis(cell.normal, right, up);
    const glm::mat2 plane_from_pixel =
        glm::inverse(glm::mat2(glm::vec2(glm::dot(gradient_x, right), glm::dot(gradient_y, right)),
                               glm::vec2(glm::dot(gradient_x, up), glm::dot(gradient_y, up))));
    const auto on_plane = [&](glm::vec2 way) {
        const glm::vec2 p = plane_from_pixel * way;
        return p.x * right + p.y * up;
    };
    const glm::vec3 a = on_plane(half * along), b = on_plane(0.5f * kThinnest * glm::vec2(-along.y, along.x));
    cell.corner = {middle - a - b, middle + a - b, middle + a + b, middle - a + b};
    cell.area.fill(0);
    cell.flux.fill((2 * (cell.flux[0] + cell.flux[2]) + cell.flux[1] + cell.flux[3]) / 6);
    return true;
}

Drawn CellDrawing::draw(const LandedCell& landed, layout::MeshCell& drawn, bool& widened) const {
    LandedCell cell = landed;
    widened = widen(cell);
    const float first = area(cell.corner[0], cell.corner[1], cell.corner[2]),
                second = area(cell.corner[0], cell.corner[2], cell.corner[3]), whole = first + second;
    if (!(whole > 0)) return Drawn::lost;
    std::array<float, 4> density;
    for (std::size_t k = 0; k < 4; ++k) {
        const float about = cell.area[k] > 0 ? cell.area[k] / cell.share : whole;
        density[k] = cell.flux[k] / std::clamp(about, whole / kMostContrast, whole * kMostContrast);
    }
    const float integral =
        (first * (density[0] + density[1] + density[2]) + second * (density[0] + density[2] + density[3])) /
        3;
    // Each triangle a third of half a cell for each of its corners: over the mesh these shares of a ray sum
    // to one, and brightness is the linear interpolation of flux where areas are alike.
    const float whole_flux =
        cell.share * (2 * (cell.flux[0] + cell.flux[2]) + cell.flux[1] + cell.flux[3]) / 6;
    if (!(whole_flux > 0)) return Drawn::not_seen;
    if (!(integral > 0)) return Drawn::lost;
    const float scale = whole_flux / integral;
    drawn.irradiance_0 = scale * density[0] * cell.power[0];
    drawn.irradiance_1 = scale * density[1] * cell.power[1];
    drawn.irradiance_2 = scale * density[2] * cell.power[2];
    drawn.irradiance_3 = scale * density[3] * cell.power[3];
    return finish(cell, drawn);
}

float CellDrawing::carried(const LandedCell& cell, bool paper) {
    const std::array<float, 4> weight = paper ? std::array{1.0f, 1.0f, 1.0f, 0.0f}   // of half a cell, a
                                              : std::array{2.0f, 1.0f, 2.0f, 1.0f};  // sixth each
    float sum = 0;
    for (std::size_t k = 0; k < 4; ++k)
        sum += weight[k] * cell.flux[k] * (cell.power[k].r + cell.power[k].g + cell.power[k].b);
    return cell.share * sum / 18;
}

Drawn CellDrawing::draw_paper(const LandedCell& landed, layout::MeshCell& drawn) const {
    LandedCell cell = landed;
    cell.corner[3] = cell.corner[2];
    cell.disc = 0;
    const float covered = area(cell.corner[0], cell.corner[1], cell.corner[2]);
    const float flux = (cell.flux[0] + cell.flux[1] + cell.flux[2]) / 3;
    const glm::vec3 power = (cell.power[0] + cell.power[1] + cell.power[2]) / 3.0f;
    drawn.irradiance_0 = (0.5f * flux / covered) * power;
    drawn.irradiance_1 = drawn.irradiance_2 = drawn.irradiance_3 = drawn.irradiance_0;
    return finish(cell, drawn);
}

Drawn CellDrawing::finish(const LandedCell& cell, layout::MeshCell& drawn) const {
    drawn.corner_0 = cell.corner[0];
    drawn.corner_1 = cell.corner[1];
    drawn.corner_2 = cell.corner[2];
    drawn.corner_3 = cell.corner[3];
    drawn.normal = cell.normal;
    const float facing = glm::dot(cell.beam, cell.normal);
    drawn.facing = cell.beam / facing;
    const float extent = std::max({cell.spacing, glm::length(cell.corner[2] - cell.corner[0]),
                                   glm::length(cell.corner[3] - cell.corner[1])});
    drawn.tolerance = kPlaneTolerance * extent * std::abs(facing);
    drawn.in_water = in_water_ ? 1.0f : 0.0f;
    drawn.disc = disc_box(cell);
    if (!finite(drawn)) return Drawn::lost;

    PictureCover box, tight;
    if (!cover(cell, box, tight)) return Drawn::not_seen;
    // A point sprite is a square about the box, cheap to set up; a quad fits closely.
    const float side = 2 * std::max(box.edge_a.x, box.edge_b.y);
    const float fitting = 4 * std::abs(cross_of(tight.edge_a, tight.edge_b));
    const bool point =
        side * side < kQuadSetup || (side <= largest_point_ && side * side - fitting <= kQuadSetup);
    const PictureCover& cover = point ? box : tight;
    drawn.center = cover.middle;
    drawn.edge_a = cover.edge_a;
    drawn.edge_b = cover.edge_b;
    return point ? Drawn::as_point : Drawn::as_quad;
}

}  // namespace dapple::methods::caustic_mesh
