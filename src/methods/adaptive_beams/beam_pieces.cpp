#include "methods/adaptive_beams/beam_pieces.h"

#include <algorithm>
#include <functional>
#include <unordered_map>

namespace dapple::methods::adaptive_beams {
namespace {

/// Halvings of an edge: what is lost is then a millionth of it: lines of black pixels are rare.
constexpr int kHalvings = 20;
/// Times that a piece is cut again where more than two kinds of paths meet in it.
constexpr int kRounds = 4;
/// What lies between the corners of a cut piece is lost where it is smaller than this against the piece: with
/// paths of two kinds it is, being a millionth wide.
constexpr double kSliver = 1e-3;

/// Beams that carry less than this against a triangle of the grid as large as the one that they were cut
/// from, in the mean over the chain, are left out: near total reflection and at outlines there are thousands.
constexpr double kWeakest = 1e-4;

using Corners = std::array<std::uint32_t, 3>;

/// A part of a triangle of the grid.
struct Piece {
    Corners rays;
    double extent = 0;      // LightView::extent
    glm::dvec3 scale{1};    // by which flux is corrected, so that pieces add up to what they were cut from
    glm::dvec3 picture{1};  // LightView::picture
    double whole = 0;       // extent of the triangle of the grid
};

/// Where the path changes along an edge: the last ray that is like the edge's first, the one after it, the
/// one before the first that is like the edge's second, and that.
using Change = std::array<std::uint32_t, 4>;

class Cutter {
public:
    Cutter(const PathTracer& tracer, const LightView& view, light::Event event, bool keep_whole,
           TracedRays& rays)
        : tracer_(tracer),
          view_(view),
          event_(static_cast<std::size_t>(event)),
          keep_whole_(keep_whole),
          rays_(rays) {}

    BeamHarvest run(std::span<const Corners> triangles, std::span<const glm::dvec2> entry) {
        std::vector<Piece> pieces;
        for (std::size_t i = 0; i < triangles.size(); ++i) {
            const Corners& corners = triangles[i];
            if (!on_body(corners[0]) && !on_body(corners[1]) && !on_body(corners[2])) continue;
            const double share = entry.empty() ? 1 : entry[i][static_cast<int>(event_)];
            const double whole = extent(corners);
            pieces.push_back({corners, whole, glm::dvec3(share), picture(corners), whole});
        }
        // Rays that meet the body at all. What the others would carry is nobody's to say, so that nothing is
        // made to add up here.
        pieces = cut(
            pieces, [&](std::uint32_t ray) { return on_body(ray) ? 1u : 0u; },
            [&](const Piece& piece) { return mean_of(piece, Arriving{}); }, false);
        harvest_.incident = harvest_.losses[static_cast<std::size_t>(Cause::silhouette)];
        std::erase_if(pieces, [&](const Piece& piece) { return !on_body(piece.rays[0]); });
        double extents = 0;
        for (const Piece& piece : pieces) {
            harvest_.incident += piece.extent * piece.scale * mean_of(piece, Arriving{}) * view_.color();
            extents += piece.extent;
        }
        const glm::dvec3 all = harvest_.incident;
        mean_flux_ = extents > 0 ? (all.x + all.y + all.z) / extents : 0;
        for (std::size_t leg = 0; leg < kMostLegs + 1 && !pieces.empty(); ++leg)
            pieces = take_leg(pieces, leg);
        return std::move(harvest_);
    }

private:
    /// What a path carries to its leg: `entry`, or the throughput of the leg before.
    struct Arriving {
        std::size_t leg = 0;
    };

    const LightPath& path(std::uint32_t ray) const { return rays_.paths[ray].paths[event_]; }
    bool on_body(std::uint32_t ray) const { return rays_.paths[ray].on_body; }

    std::uint64_t signature(std::uint32_t ray, std::size_t leg) const {
        return path(ray).legs.size() > leg ? path(ray).legs[leg].signature : 0;
    }

    /// The same for rays that have the leg in common; by where it ends too, so that the shadows of objects
    /// have their edges, except where whole triangles are kept or left out.
    std::uint64_t kind_of(std::uint32_t ray, std::size_t leg) const {
        const std::uint64_t here = signature(ray, leg);
        if (here == 0 || keep_whole_) return here;
        return here * 0x9e3779b97f4a7c15u + static_cast<std::uint64_t>(path(ray).legs[leg].end + 3);
    }

    glm::dvec3 arriving(std::uint32_t ray, std::size_t leg) const {
        // A ray that was found between others may have ended before.
        if (path(ray).legs.size() < leg) return glm::dvec3(0);
        const glm::dvec3& share = leg == 0 ? path(ray).entry : path(ray).legs[leg - 1].throughput;
        return rays_.paths[ray].falloff * share;
    }

    glm::dvec3 mean_of(const Piece& piece, Arriving what) const {
        return piece.picture *
               (arriving(piece.rays[0], what.leg) + arriving(piece.rays[1], what.leg) +
                arriving(piece.rays[2], what.leg)) /
               3.0;
    }

    glm::dvec3 picture(const Corners& c) const {
        return view_.picture(rays_.uv[c[0]], rays_.uv[c[1]], rays_.uv[c[2]]);
    }

    double extent(const Corners& c) const {
        return view_.extent(rays_.uv[c[0]], rays_.uv[c[1]], rays_.uv[c[2]]);
    }

    void lose(Cause cause, const glm::dvec3& flux) {
        harvest_.losses[static_cast<std::size_t>(cause)] += flux * view_.color();
    }

    /// Makes beams of one leg of pieces that have all the legs before in common; those that go on are left.
    std::vector<Piece> take_leg(std::vector<Piece> pieces, std::size_t leg) {
        pieces = cut(
            pieces, [&](std::uint32_t ray) { return kind_of(ray, leg); },
            [&](const Piece& piece) { return mean_of(piece, Arriving{leg}); }, true);
        std::vector<Piece> kept;
        for (const Piece& piece : pieces) {
            for (const std::uint32_t ray : piece.rays)
                for (const LightPath::Loss& loss : path(ray).losses)
                    if (loss.leg == leg)
                        lose(loss.cause, piece.extent * piece.scale * piece.picture * loss.amount *
                                             rays_.paths[ray].falloff / 3.0);
            if (signature(piece.rays[0], leg) == 0) continue;
            add_beam(piece, leg);
            kept.push_back(piece);
        }
        return kept;
    }

    void add_beam(const Piece& piece, std::size_t leg) {
        const glm::dvec3 flux =
            piece.extent * piece.scale * mean_of(piece, Arriving{leg + 1}) * view_.color();
        const auto leg_of = [&](std::size_t i) { return &path(piece.rays[i]).legs[leg]; };
        if (!tracer_.lights({leg_of(0), leg_of(1), leg_of(2)})) {
            lose(Cause::beyond, flux / view_color());
            return;
        }
        if (!(flux.x + flux.y + flux.z > kWeakest * mean_flux_ * piece.whole)) {
            lose(Cause::too_weak, flux / view_color());
            return;
        }
        LegBeams& legs = legs_of(path(piece.rays[0]), leg);
        legs.beams.push_back({piece.rays, flux});
    }

    /// Divides by the colour, where there is any.
    glm::dvec3 view_color() const {
        glm::dvec3 color = view_.color();
        for (int i = 0; i < 3; ++i)
            if (!(color[i] > 0)) color[i] = 1;
        return color;
    }

    LegBeams& legs_of(const LightPath& path, std::size_t leg) {
        const auto same = [&](const LegBeams& legs) {
            if (legs.leg != leg || legs.in_water != path.legs[leg].in_water) return false;
            for (std::size_t i = 0; i < leg; ++i)
                if (legs.surfaces[i] != path.legs[i].end) return false;
            return true;
        };
        const auto found = std::find_if(harvest_.legs.begin(), harvest_.legs.end(), same);
        if (found != harvest_.legs.end()) return *found;
        LegBeams& legs = harvest_.legs.emplace_back();
        legs.leg = leg;
        legs.in_water = path.legs[leg].in_water;
        for (std::size_t i = 0; i < leg; ++i) legs.surfaces.push_back(path.legs[i].end);
        return legs;
    }

    using Kind = std::function<std::uint64_t(std::uint32_t)>;
    using Weight = std::function<glm::dvec3(const Piece&)>;

    /// Pieces whose rays have one kind each; `weight` is what a piece carries a unit of extent. `conserve`:
    /// pieces carry together what they were cut from did.
    std::vector<Piece> cut(std::vector<Piece> pieces, const Kind& kind, const Weight& weight, bool conserve) {
        std::vector<Piece> result;
        changes_.clear();
        for (int round = 0; !pieces.empty(); ++round) {
            std::vector<Piece> mixed;
            for (const Piece& piece : pieces) {
                const std::uint64_t first = kind(piece.rays[0]);
                const bool alike = kind(piece.rays[1]) == first && kind(piece.rays[2]) == first;
                (alike ? result : mixed).push_back(piece);
            }
            pieces.clear();
            if (keep_whole_ || round == kRounds) {
                for (const Piece& piece : mixed)
                    lose(Cause::silhouette, piece.extent * piece.scale * weight(piece));
                break;
            }
            find_changes(mixed, kind);
            for (const Piece& piece : mixed) cut_piece(piece, kind, weight, conserve, pieces);
        }
        return result;
    }

    /// The corners of a mixed piece, and what lies between where something of a third kind does.
    void cut_piece(const Piece& piece, const Kind& kind, const Weight& weight, bool conserve,
                   std::vector<Piece>& result) {
        const Corners& c = piece.rays;
        const std::size_t first = result.size();
        double rest = piece.extent;
        const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t d, double least) {
            Piece part{{a, b, d}, 0, piece.scale};
            part.extent = std::min(rest, extent(part.rays));
            if (!(part.extent > least * piece.extent)) return;
            part.whole = piece.whole;
            part.picture = picture(part.rays);
            rest -= part.extent;
            result.push_back(part);
        };
        // Rays on the way from a corner to another: 0 the last that is like the corner, 1 the first that is
        // not.
        const auto on_way = [&](std::uint32_t from, std::uint32_t to, std::size_t i) {
            const auto [low, high] = std::minmax(from, to);
            const Change& change = changes_.at(key(low, high));
            return from == low ? change[i] : change[3 - i];
        };
        std::size_t odd = 3;  // the corner that is unlike the other two, which are alike
        for (std::size_t i = 0; i < 3; ++i)
            if (kind(c[(i + 1) % 3]) == kind(c[(i + 2) % 3])) odd = i;
        if (odd < 3) {
            const std::uint32_t a = c[odd], b = c[(odd + 1) % 3], d = c[(odd + 2) % 3];
            add(a, on_way(a, b, 0), on_way(a, d, 0), 0);
            add(on_way(a, b, 1), on_way(b, a, 1), on_way(d, a, 1), kSliver);
            add(on_way(a, b, 1), on_way(d, a, 1), on_way(a, d, 1), kSliver);
            add(b, d, on_way(b, a, 0), 0);
            add(d, on_way(d, a, 0), on_way(b, a, 0), 0);
        } else {
            for (std::size_t i = 0; i < 3; ++i)
                add(c[i], on_way(c[i], c[(i + 1) % 3], 0), on_way(c[i], c[(i + 2) % 3], 0), 0);
            // The hexagon between: a fan from its first corner.
            std::array<std::uint32_t, 6> rim{};
            for (std::size_t i = 0; i < 3; ++i) {
                rim[2 * i] = on_way(c[i], c[(i + 1) % 3], 1);
                rim[2 * i + 1] = on_way(c[(i + 1) % 3], c[i], 1);
            }
            for (std::size_t i = 1; i < 5; ++i) add(rim[0], rim[i], rim[i + 1], kSliver);
        }
        const glm::dvec3 whole = weight(piece);
        glm::dvec3 factor(1);
        if (conserve) {
            // Means over pieces are a finer quadrature than that over the whole: they are made to add up.
            glm::dvec3 sum = rest * whole;
            for (std::size_t i = first; i < result.size(); ++i) sum += result[i].extent * weight(result[i]);
            for (int i = 0; i < 3; ++i)
                if (sum[i] > 0) factor[i] = piece.extent * whole[i] / sum[i];
            for (std::size_t i = first; i < result.size(); ++i) result[i].scale *= factor;
        }
        lose(Cause::silhouette, rest * piece.scale * factor * whole);
    }

    static std::uint64_t key(std::uint32_t low, std::uint32_t high) {
        return static_cast<std::uint64_t>(low) << 32 | high;
    }

    /// Fills changes_ for all edges of the pieces whose ends differ.
    void find_changes(const std::vector<Piece>& pieces, const Kind& kind) {
        std::vector<std::array<std::uint32_t, 2>> edges;
        for (const Piece& piece : pieces)
            for (std::size_t i = 0; i < 3; ++i) {
                const auto [low, high] = std::minmax(piece.rays[i], piece.rays[(i + 1) % 3]);
                if (kind(low) == kind(high)) continue;
                if (changes_.try_emplace(key(low, high)).second) edges.push_back({low, high});
            }
        const auto from_low = halve(edges, kind);
        // Where something of a third kind lies between, the other side of it is looked for from the other
        // end.
        std::vector<std::array<std::uint32_t, 2>> reversed;
        std::vector<std::size_t> which;
        for (std::size_t i = 0; i < edges.size(); ++i) {
            const auto [last, next] = from_low[i];
            changes_[key(edges[i][0], edges[i][1])] = {last, next, last, next};
            if (kind(next) == kind(edges[i][1])) continue;
            reversed.push_back({edges[i][1], edges[i][0]});
            which.push_back(i);
        }
        const auto from_high = halve(reversed, kind);
        for (std::size_t i = 0; i < which.size(); ++i) {
            Change& change = changes_[key(edges[which[i]][0], edges[which[i]][1])];
            change[2] = from_high[i][1];
            change[3] = from_high[i][0];
        }
    }

    /// The last ray like each edge's first end, and one beyond it that is not.
    std::vector<std::array<std::uint32_t, 2>> halve(const std::vector<std::array<std::uint32_t, 2>>& edges,
                                                    const Kind& kind) {
        // A working ray an end of each edge, in place of thousands that nobody asks for again.
        const std::size_t first = rays_.uv.size(), count = edges.size();
        auto brackets = edges;
        std::vector<glm::dvec2> uv(count);
        std::vector<VertexPaths> traced(count);
        std::vector<std::uint64_t> alike(count);
        for (std::size_t i = 0; i < count; ++i) alike[i] = kind(edges[i][0]);
        rays_.uv.resize(first + 3 * count);
        rays_.paths.resize(first + 3 * count);
        for (int step = 0; step < kHalvings; ++step) {
            for (std::size_t i = 0; i < count; ++i)
                uv[i] = 0.5 * (rays_.uv[brackets[i][0]] + rays_.uv[brackets[i][1]]);
            tracer_.trace(uv, traced);
            for (std::size_t i = 0; i < count; ++i) {
                const std::size_t probe = first + 3 * i;
                rays_.uv[probe] = uv[i];
                rays_.paths[probe] = std::move(traced[i]);
                const std::size_t side = kind(static_cast<std::uint32_t>(probe)) == alike[i] ? 0 : 1;
                rays_.uv[probe + 1 + side] = uv[i];
                std::swap(rays_.paths[probe + 1 + side], rays_.paths[probe]);
                brackets[i][side] = static_cast<std::uint32_t>(probe + 1 + side);
            }
        }
        return brackets;
    }

    const PathTracer& tracer_;
    const LightView& view_;
    std::size_t event_;
    bool keep_whole_;
    TracedRays& rays_;
    BeamHarvest harvest_;
    double mean_flux_ = 0;  // W, sum of the channels, a unit of extent, of the light that takes the event
    std::unordered_map<std::uint64_t, Change> changes_;
};

}  // namespace

BeamHarvest cut_into_beams(const PathTracer& tracer, const LightView& view, light::Event event,
                           std::span<const std::array<std::uint32_t, 3>> triangles, bool keep_whole,
                           TracedRays& rays, std::span<const glm::dvec2> entry) {
    return Cutter(tracer, view, event, keep_whole, rays).run(triangles, entry);
}

}  // namespace dapple::methods::adaptive_beams
