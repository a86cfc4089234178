#include "methods/adaptive_beams/ring_areas.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"

namespace dapple::methods::adaptive_beams {
namespace {

constexpr std::size_t kTile = 1024;

double cross(glm::dvec2 a, glm::dvec2 b) {
    return a.x * b.y - a.y * b.x;
}

bool keeps_sign(const AreaFunction& area, double from, double to) {
    double least = std::min(area.at(from), area.at(to)), most = std::max(area.at(from), area.at(to));
    if (area.q.z != 0) {
        const double turn = area.middle - 0.5 * area.q.y / area.q.z;
        if (turn > from && turn < to) {
            least = std::min(least, area.at(turn));
            most = std::max(most, area.at(turn));
        }
    }
    return least >= 0 || most <= 0;
}

/// Triangles at each vertex, in ascending order.
struct Rings {
    std::vector<std::uint32_t> first, triangle;

    explicit Rings(const BeamSet& set)
        : first(set.vertices.size() + 1, 0), triangle(3 * set.triangles.size()) {
        for (const glm::uvec3& t : set.triangles)
            for (int k = 0; k < 3; ++k) ++first[t[k] + 1];
        for (std::size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
        std::vector<std::uint32_t> next(first.begin(), first.end() - 1);
        for (std::size_t i = 0; i < set.triangles.size(); ++i)
            for (int k = 0; k < 3; ++k) triangle[next[set.triangles[i][k]]++] = static_cast<std::uint32_t>(i);
    }
};

}  // namespace

AreaFunction AreaFunction::about(double depth) const {
    const double shift = depth - middle;
    return {{at(depth), q.y + 2 * shift * q.z, q.z}, depth};
}

AreaFunction AreaFunction::about_least(double from, double to) const {
    double depth = std::abs(at(from)) <= std::abs(at(to)) ? from : to;
    const double turn = q.z != 0 ? middle - 0.5 * q.y / q.z : from;
    if (turn > from && turn < to && std::abs(at(turn)) < std::abs(at(depth))) depth = turn;
    return about(static_cast<double>(static_cast<float>(depth)));
}

AreaFunction area_function(const BeamSet& set, const glm::uvec3& triangle, double middle) {
    glm::dvec2 place[3], slope[3];
    for (int k = 0; k < 3; ++k) {
        const BeamSet::Vertex& v = set.vertices[triangle[k]];
        slope[k] = {v.slope_a, v.slope_b};
        place[k] = glm::dvec2(v.a, v.b) + middle * slope[k];
    }
    const glm::dvec2 p = place[1] - place[0], q = place[2] - place[0];
    const glm::dvec2 s = slope[1] - slope[0], t = slope[2] - slope[0];
    return {0.5 * glm::dvec3(cross(p, q), cross(p, t) + cross(s, q), cross(s, t)), middle};
}

RingAreas::RingAreas(const BeamSet& set)
    : even(set.vertices.size()), flux(set.vertices.size(), glm::dvec3(0)), first(set.vertices.size() + 1, 0) {
    const Rings rings(set);
    std::vector<std::vector<std::uint32_t>> listed(set.vertices.size() / kTile + 1);
    parallel_for(set.vertices.size(), kTile, [&](std::size_t begin, std::size_t end) {
        std::vector<std::uint32_t>& list = listed[begin / kTile];
        for (std::size_t v = begin; v < end; ++v) {
            double from = std::numeric_limits<double>::infinity(), to = -from;
            const auto visit = [&](auto&& body) {
                for (std::uint32_t i = rings.first[v]; i < rings.first[v + 1]; ++i) body(rings.triangle[i]);
            };
            visit([&](std::uint32_t i) {
                flux[v] += glm::dvec3(set.flux[i]);
                for (int k = 0; k < 3; ++k) {
                    const BeamSet::Vertex& corner = set.vertices[set.triangles[i][k]];
                    from = std::min(from, static_cast<double>(corner.start));
                    to = std::max(to, static_cast<double>(corner.end));
                }
            });
            if (!(from <= to)) continue;
            even[v].middle = 0.5 * (from + to);
            visit([&](std::uint32_t i) {
                const AreaFunction area = area_function(set, set.triangles[i], even[v].middle);
                if (keeps_sign(area, from, to)) {
                    even[v].q += area.at(from) + area.at(to) < 0 ? -area.q : area.q;
                } else {
                    list.push_back(i);
                    ++first[v + 1];
                }
            });
            even[v] = even[v].about_least(from, to);
        }
    });
    for (std::size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
    for (const auto& list : listed) turning.insert(turning.end(), list.begin(), list.end());
}

double RingAreas::area(const BeamSet& set, std::size_t vertex, double depth) const {
    double sum = std::abs(even[vertex].at(depth));
    for (std::uint32_t i = first[vertex]; i < first[vertex + 1]; ++i)
        sum += std::abs(area_function(set, set.triangles[turning[i]], depth).q.x);
    return sum;
}

}  // namespace dapple::methods::adaptive_beams
