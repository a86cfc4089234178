#include "methods/adaptive_beams/mean_entries.h"

namespace dapple::methods::adaptive_beams {
namespace {

constexpr int kParts = 4;  // of a triangle's sides
constexpr std::size_t kSamples = std::size_t{kParts} * kParts;

}  // namespace

std::vector<double> mean_entries(const PathTracer& tracer, light::Event event,
                                 std::span<const RayTriangle> triangles) {
    std::vector<glm::dvec2> uv;
    uv.reserve(triangles.size() * kSamples);
    for (const auto& [a, b, c] : triangles) {
        const glm::dvec2 ab = (b - a) / static_cast<double>(kParts);
        const glm::dvec2 ac = (c - a) / static_cast<double>(kParts);
        for (int row = 0; row < kParts; ++row)
            for (int column = 0; row + column < kParts; ++column) {
                const glm::dvec2 corner =
                    a + static_cast<double>(column) * ab + static_cast<double>(row) * ac;
                uv.push_back(corner + (ab + ac) / 3.0);
                if (row + column + 1 < kParts) uv.push_back(corner + 2.0 * (ab + ac) / 3.0);
            }
    }
    const std::vector<glm::dvec2> entries = tracer.entries(uv);
    std::vector<double> means(triangles.size(), 0);
    for (std::size_t i = 0; i < entries.size(); ++i)
        means[i / kSamples] += entries[i][static_cast<int>(event)] / kSamples;
    return means;
}

}  // namespace dapple::methods::adaptive_beams
