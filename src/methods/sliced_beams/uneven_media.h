#pragma once
#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "media/media.h"

namespace dapple::methods::sliced_beams {

/// What a camera segment through bounded media scatters towards its near end of a unit of fluence and phase:
/// W(s), the integral of scattering times transmittance from the near end to s, a component and channel.
class SegmentScatter {
public:
    SegmentScatter() = default;
    SegmentScatter(const media::Media& media, const glm::dvec3& origin, const glm::dvec3& direction,
                   double length, bool in_water);

    /// m along the segment, between which something scatters; first() >= last(): nothing does.
    double first() const { return place_.empty() ? 0 : place_.front(); }
    double last() const { return place_.empty() ? 0 : place_.back(); }
    /// Places between which W is smooth, first() to last().
    std::span<const double> places() const { return place_; }
    /// W of the component at s in [places()[piece], places()[piece + 1]].
    glm::dvec3 scattered(std::size_t component, std::size_t piece, double s) const;

    /// Three channels, and their sum.
    using Channels __attribute__((vector_size(16))) = float;
    /// The piece that holds s in [first(), last()], looked for from a near one on.
    std::size_t piece(float s, std::size_t near) const {
        near = std::min(near, pieces_.size() - 1);
        while (near > 0 && s < pieces_[near].begin) --near;
        while (near + 1 < pieces_.size() && s >= pieces_[near + 1].begin) ++near;
        return near;
    }
    /// Between `from`, which lies in the piece, and `to` there are at most so many pieces and so much optical
    /// depth.
    bool is_short(std::size_t piece, float from, float to, std::size_t most_pieces, float most_depth) const {
        std::size_t last = piece;
        while (last + 1 < pieces_.size() && to > pieces_[last + 1].begin) ++last;
        const auto depth = [](const Piece& at, float s) { return at.depth + at.rate * (s - at.begin); };
        return last - piece < most_pieces &&
               depth(pieces_[last], to) - depth(pieces_[piece], from) <= most_depth;
    }
    /// W(to) - W(from), from <= to, from in the piece, which becomes that of `to`.
    Channels scattered(std::size_t component, std::size_t& piece, float from, float to) const {
        Channels sum{};
        for (;; ++piece) {
            const bool last = piece + 1 == pieces_.size() || to <= pieces_[piece + 1].begin;
            const Cubic& cubic = cubics_[piece * components_ + component];
            const float begin = pieces_[piece].begin, end = last ? to : pieces_[piece + 1].begin;
            sum += cubic(end - begin) - cubic(from - begin);
            if (last) return sum;
            from = end;
        }
    }

private:
    struct Curve {
        glm::dvec3 value;          ///< W where the piece begins
        glm::vec3 rises, arrives;  ///< its slope there, and where the piece ends
    };
    struct Piece {
        float begin;        ///< m
        float depth, rate;  ///< optical depth there in the densest channel, and its mean change, /m
    };
    /// W - W where the piece begins.
    struct Cubic {
        Channels c1, c2, c3;
        Channels operator()(float t) const { return t * (c1 + t * (c2 + t * c3)); }
    };
    std::size_t components_ = 0;
    std::vector<double> place_;
    std::vector<Curve> curve_;  ///< [piece * components + component]; of the last place only the value
    std::vector<Piece> pieces_;
    std::vector<Cubic> cubics_;  ///< [piece * components + component]: the same as curve_
};

}  // namespace dapple::methods::sliced_beams
