#include "methods/adaptive_beams/beam_pieces.h"

#include <algorithm>
#include <functional>
#include <unordered_map>

#include "methods/adaptive_beams/mean_entries.h"
#include "methods/adaptive_beams/surface_jumps.h"

namespace dapple::methods::adaptive_beams {
namespace {

/// Times that a piece is cut again where more than two kinds of paths meet in it.
constexpr int kRounds = 4;
/// What lies between the corners of a cut piece is lost where it is smaller than this against the piece: with
/// paths of two kinds it is, being a millionth wide.
constexpr double kSliver = 1e-3;

/// Beams that carry less than this against a triangle of the grid as large as the one that they were cut
/// from, in the mean over the chain, are left out: near total reflection and at outlines there are thousands.
constexpr double kWeakest = 1e-4;

/// Where the corners of a piece differ by less than this, of the largest, in the share of the light that
/// takes the event, their mean is that of the piece: curvature makes it a few thousandths at most.
constexpr double kEven = 0.1;

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
        if (!keep_whole_) {
            pieces = cut_at_jumps(pieces);
            weigh(pieces);
        }
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
    using Alike = std::function<bool(std::uint32_t, std::uint32_t)>;

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
            const Alike alike = [&](std::uint32_t a, std::uint32_t b) { return kind(a) == kind(b); };
            for (const Piece& piece : mixed) cut_piece(piece, alike, weight, conserve, pieces);
        }
        return result;
    }

    /// The corners of a mixed piece, and what lies between where something of a third kind does.
    void cut_piece(const Piece& piece, const Alike& alike, const Weight& weight, bool conserve,
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
            if (alike(c[(i + 1) % 3], c[(i + 2) % 3])) odd = i;
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

    bool merged(const Corners& rays) const {
        return std::any_of(rays.begin(), rays.end(),
                           [&](std::uint32_t ray) { return rays_.paths[ray].merged; });
    }

    /// Cuts pieces where the surface that is met first jumps: what waves in the light's way hide of others is
    /// no part of a beam. Not where waves are merged. Each edge is cut once: what more outlines it crosses
    /// are narrower than the finest cells.
    std::vector<Piece> cut_at_jumps(const std::vector<Piece>& pieces) {
        std::vector<RayEdge> edges;
        changes_.clear();
        for (const Piece& piece : pieces) {
            if (merged(piece.rays)) continue;
            for (std::size_t i = 0; i < 3; ++i) {
                const auto [low, high] = std::minmax(piece.rays[i], piece.rays[(i + 1) % 3]);
                const RayEdge edge{low, high};
                if (!may_jump(view_, rays_, edge)) continue;
                if (changes_.try_emplace(key(low, high)).second) edges.push_back(edge);
            }
        }
        const std::vector<std::optional<RayEdge>> jumps = surface_jumps(tracer_, rays_, edges);
        for (std::size_t i = 0; i < edges.size(); ++i) {
            const std::uint64_t edge = key(edges[i][0], edges[i][1]);
            if (!jumps[i]) {
                changes_.erase(edge);
                continue;
            }
            const auto [last, next] = *jumps[i];
            changes_[edge] = {last, next, last, next};
        }
        const Alike alike = [&](std::uint32_t a, std::uint32_t b) {
            return !changes_.contains(key(std::min(a, b), std::max(a, b)));
        };
        const Weight weight = [&](const Piece& piece) { return mean_of(piece, Arriving{}); };
        std::vector<Piece> result;
        for (const Piece& piece : pieces) {
            const Corners& c = piece.rays;
            const int parted =
                (alike(c[0], c[1]) ? 0 : 1) + (alike(c[1], c[2]) ? 0 : 1) + (alike(c[2], c[0]) ? 0 : 1);
            if (parted == 0 || merged(c)) {
                result.push_back(piece);
            } else if (parted == 1) {
                cut_edge(piece, alike, result);
            } else {
                cut_piece(piece, alike, weight, false, result);
            }
        }
        return result;
    }

    /// An outline that begins in a piece crosses one of its edges only: both parts have the other corner.
    void cut_edge(const Piece& piece, const Alike& alike, std::vector<Piece>& result) const {
        const Corners& c = piece.rays;
        std::size_t edge = 0;
        while (alike(c[edge], c[(edge + 1) % 3])) ++edge;
        const std::uint32_t a = c[edge], b = c[(edge + 1) % 3], top = c[(edge + 2) % 3];
        const Change& change = changes_.at(key(std::min(a, b), std::max(a, b)));
        const std::uint32_t of_a = a < b ? change[0] : change[3], of_b = a < b ? change[3] : change[0];
        for (const Corners& rays : {Corners{a, of_a, top}, Corners{of_b, b, top}}) {
            Piece part = piece;
            part.rays = rays;
            part.extent = extent(rays);
            part.picture = picture(rays);
            result.push_back(part);
        }
    }

    /// Corrects the flux of pieces over which the share of the light that takes the event is uneven: where
    /// light grazes a wave it goes with the root of the distance from the outline, of which corners say
    /// little.
    void weigh(std::vector<Piece>& pieces) const {
        const auto share = [&](std::uint32_t ray) { return arriving(ray, 0).x; };
        std::vector<std::size_t> uneven;
        std::vector<RayTriangle> triangles;
        for (std::size_t i = 0; i < pieces.size(); ++i) {
            const Corners& c = pieces[i].rays;
            if (merged(c)) continue;
            const auto [least, most] = std::minmax({share(c[0]), share(c[1]), share(c[2])});
            if (!(most - least > kEven * most)) continue;
            uneven.push_back(i);
            triangles.push_back({rays_.uv[c[0]], rays_.uv[c[1]], rays_.uv[c[2]]});
        }
        const std::vector<double> means = mean_entries(tracer_, static_cast<light::Event>(event_), triangles);
        for (std::size_t i = 0; i < uneven.size(); ++i) {
            const Corners& c = pieces[uneven[i]].rays;
            pieces[uneven[i]].scale = glm::dvec3(3 * means[i] / (share(c[0]) + share(c[1]) + share(c[2])));
        }
    }

    static std::uint64_t key(std::uint32_t low, std::uint32_t high) {
        return static_cast<std::uint64_t>(low) << 32 | high;
    }

    /// Fills changes_ for all edges of the pieces whose ends differ.
    void find_changes(const std::vector<Piece>& pieces, const Kind& kind) {
        std::vector<RayEdge> edges;
        for (const Piece& piece : pieces)
            for (std::size_t i = 0; i < 3; ++i) {
                const auto [low, high] = std::minmax(piece.rays[i], piece.rays[(i + 1) % 3]);
                if (kind(low) == kind(high)) continue;
                if (changes_.try_emplace(key(low, high)).second) edges.push_back({low, high});
            }
        const auto like_first = [&](const RayEdge& edge, const RayEdge&, std::uint32_t probe) {
            return kind(probe) == kind(edge[0]);
        };
        const auto from_low = halve(tracer_, rays_, edges, like_first);
        // Where something of a third kind lies between, the other side of it is looked for from the other
        // end.
        std::vector<RayEdge> reversed;
        std::vector<std::size_t> which;
        for (std::size_t i = 0; i < edges.size(); ++i) {
            const auto [last, next] = from_low[i];
            changes_[key(edges[i][0], edges[i][1])] = {last, next, last, next};
            if (kind(next) == kind(edges[i][1])) continue;
            reversed.push_back({edges[i][1], edges[i][0]});
            which.push_back(i);
        }
        const auto from_high = halve(tracer_, rays_, reversed, like_first);
        for (std::size_t i = 0; i < which.size(); ++i) {
            Change& change = changes_[key(edges[which[i]][0], edges[which[i]][1])];
            change[2] = from_high[i][1];
            change[3] = from_high[i][0];
        }
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
