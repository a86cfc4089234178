#include "methods/reference/oracle_search.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <optional>

namespace dapple::oracle {
namespace {

constexpr double kSmallestBox = 1e-10;      // m; two paths that are nearer to each other are not told apart
constexpr std::size_t kMostBoxes = 400000;  // ends the search where a whole curve of water lights the point
/// Boxes are examined with a margin, so that a path on their common border is well inside one of them.
constexpr double kMargin = 1.05;
constexpr double kLeastMargin = 1e-12;  // m, far above the rounding of landing points
constexpr double kLeastAspect = 0.02;   // of the narrower side to the wider

bool disjoint(const Box& a, const Box& b) {
    return disjoint(a.x, b.x) || disjoint(a.z, b.z);
}
bool contains(const Box& outer, const Box& inner) {
    return contains(outer.x, inner.x) && contains(outer.z, inner.z);
}
bool contains_in_interior(const Box& outer, const Box& inner) {
    return contains_in_interior(outer.x, inner.x) && contains_in_interior(outer.z, inner.z);
}
Box intersection(const Box& a, const Box& b) {
    return {intersection(a.x, b.x), intersection(a.z, b.z)};
}
double larger_width(const Box& box) {
    return std::max(width(box.x), width(box.z));
}
bool holds_zero(const Interval& a) {
    return contains(a, 0.0);
}

/// A 2 x 2 matrix of intervals, rows x and z.
struct Matrix {
    Interval xu, xv, zu, zv;
};

class Finder {
public:
    Finder(const Surface::Local& surface, const MapConstants& map, const Box& domain)
        : surface_(surface), map_(map), domain_(domain) {}

    RootSearch run() {
        std::vector<Box> stack = {domain_};
        while (!stack.empty()) {
            Box box = stack.back();
            stack.pop_back();
            if (found_.boxes == kMostBoxes) {
                add_undecided(box);
                continue;
            }
            ++found_.boxes;
            const Box whole = box;
            if (!examine(box)) continue;
            if (larger_width(whole) < kSmallestBox) {
                add_undecided(box);
                continue;
            }
            // Split unless the examination itself has cut much off.
            if (width(box.x) * width(box.z) < 0.3 * width(whole.x) * width(whole.z)) {
                stack.push_back(box);
                continue;
            }
            Box half = box;
            if (width(box.x) > width(box.z)) {
                half.x.hi = box.x.lo = middle(box.x);
            } else {
                half.z.hi = box.z.lo = middle(box.z);
            }
            stack.push_back(half);
            stack.push_back(box);
        }
        return std::move(found_);
    }

private:
    /// A box about a point, its bounds, and the landing point of the middle with its derivatives on the box.
    struct Sample {
        Box box;
        double x, z;
        Interval radius_x, radius_z;
        Jet<Interval> middle, over;
    };

    /// True, with `box` reduced to where solutions can be, if more has to be done about it.
    bool examine(Box& box) {
        Sample sample;
        const bool fine = take(box, true, sample);
        const Jet<Interval>& over = sample.over;
        const auto ray = departure<Interval>(map_, sample.box.x, sample.box.z, over.height, over.x, over.z);
        if (ray.facing.hi <= 0 || ray.drop.hi <= 0 || ray.ahead_y.hi <= 0) return false;
        if (ray.ahead_y.lo <= 0) {  // the landing point goes through infinity: a form without the pole
            return holds_zero(sample.box.x * ray.ahead_y + ray.drop * ray.ahead_x) &&
                   holds_zero(sample.box.z * ray.ahead_y + ray.drop * ray.ahead_z);
        }
        // A solution with drop > 0 lies at -drop (ahead_x, ahead_z) / ahead_y.
        const Interval drop = {std::max(0.0, ray.drop.lo), ray.drop.hi};
        const Box source = {-(drop * (ray.ahead_x / ray.ahead_y)), -(drop * (ray.ahead_z / ray.ahead_y))};
        if (disjoint(box, source)) return false;
        box = intersection(box, source);
        if (!fine) return true;

        Interval f_x, f_z;
        Matrix j;
        if (!land(sample, f_x, f_z, j)) return true;
        if (misses(sample, f_x, f_z, j)) return false;
        const std::optional<Box> image = krawczyk(sample, f_x, f_z, j);
        if (!image) return true;
        if (disjoint(box, *image)) return false;
        if (contains_in_interior(sample.box, *image)) {
            add_root(sample.box, *image);
            return false;
        }
        box = intersection(box, *image);
        return true;
    }

    /// False if the box is too large for a jet at its middle. An enlarged box has a margin, and some width in
    /// both directions: a root can be proven only in the interior of a box, which may have shrunk to a line.
    bool take(const Box& box, bool enlarged, Sample& sample) const {
        sample.x = middle(box.x);
        sample.z = middle(box.z);
        double radius_x = above(std::max(box.x.hi - sample.x, sample.x - box.x.lo));
        double radius_z = above(std::max(box.z.hi - sample.z, sample.z - box.z.lo));
        if (enlarged) {
            const double least = std::max(kLeastMargin, kLeastAspect * std::max(radius_x, radius_z));
            radius_x = std::max(kMargin * radius_x, least);
            radius_z = std::max(kMargin * radius_z, least);
        }
        sample.box = {around(sample.x, radius_x), around(sample.z, radius_z)};
        sample.radius_x = sample.box.x - sample.x;
        sample.radius_z = sample.box.z - sample.z;
        return surface_.bounds(sample.x, sample.z, std::max(-sample.radius_x.lo, sample.radius_x.hi),
                               std::max(-sample.radius_z.lo, sample.radius_z.hi), sample.middle, sample.over);
    }

    /// f = X - receiver at the middle, J = dX/d(u, v) on the box; false where a ray may run level.
    bool land(const Sample& sample, Interval& f_x, Interval& f_z, Matrix& j) const {
        const Jet<Interval>& at = sample.middle;
        const Interval x = {sample.x, sample.x}, z = {sample.z, sample.z};
        const auto middle_ray = departure<Interval>(map_, x, z, at.height, at.x, at.z);
        if (middle_ray.ahead_y.lo <= 0) return false;
        const Landing<Interval> f = landing(middle_ray, x, z);
        f_x = f.x;
        f_z = f.z;
        using D = Dual<Interval>;
        const Jet<Interval>& over = sample.over;
        const D u = {sample.box.x, {1, 1}, {0, 0}}, v = {sample.box.z, {0, 0}, {1, 1}};
        const D height = {over.height, over.x, over.z};
        const D slope_x = {over.x, over.xx, over.xz}, slope_z = {over.z, over.xz, over.zz};
        const Departure<D> ray = departure<D>(map_, u, v, height, slope_x, slope_z);
        if (ray.ahead_y.value.lo <= 0) return false;
        const Landing<D> image = landing(ray, u, v);
        j = {image.x.du, image.x.dv, image.z.du, image.z.dv};
        return true;
    }

    /// Mean value theorem: no solution in the box if 0 is outside the range of a component of f. It needs no
    /// inverse of J, and so excludes boxes in the middle of a fold too.
    static bool misses(const Sample& sample, const Interval& f_x, const Interval& f_z, const Matrix& j) {
        return !holds_zero(f_x + j.xu * sample.radius_x + j.xv * sample.radius_z) ||
               !holds_zero(f_z + j.zu * sample.radius_x + j.zv * sample.radius_z);
    }

    /// K(B) = m - Y f(m) + (I - Y J(B)) (B - m), Y an approximate inverse of J: it holds all solutions of B;
    /// if it lies in the interior of B there is exactly one. Nothing where J has no inverse to speak of.
    static std::optional<Box> krawczyk(const Sample& sample, const Interval& f_x, const Interval& f_z,
                                       const Matrix& j) {
        const double xu = middle(j.xu), xv = middle(j.xv), zu = middle(j.zu), zv = middle(j.zv);
        const double det = xu * zv - xv * zu;
        const double size = xu * xu + xv * xv + zu * zu + zv * zv;
        if (!(std::abs(det) > 1e-12 * size)) return std::nullopt;
        const double yxx = zv / det, yxz = -xv / det, yzx = -zu / det, yzz = xu / det;
        const Interval a_xx = 1.0 - (yxx * j.xu + yxz * j.zu), a_xz = -(yxx * j.xv + yxz * j.zv);
        const Interval a_zx = -(yzx * j.xu + yzz * j.zu), a_zz = 1.0 - (yzx * j.xv + yzz * j.zv);
        return Box{sample.x - (yxx * f_x + yxz * f_z) + a_xx * sample.radius_x + a_xz * sample.radius_z,
                   sample.z - (yzx * f_x + yzz * f_z) + a_zx * sample.radius_x + a_zz * sample.radius_z};
    }

    /// One solution is in `image`, and no other in `alone_in`.
    void add_root(const Box& alone_in, Box image) {
        Root root;
        root.alone_in = alone_in;
        // Slowly at first, then quadratically, down to where rounding holds it.
        for (double previous = INFINITY; larger_width(image) < 0.999 * previous;) {
            previous = larger_width(image);
            Sample sample;
            Interval f_x, f_z;
            Matrix j;
            if (!take(image, false, sample) || !land(sample, f_x, f_z, j)) break;
            const Interval det = j.xu * j.zv - j.xv * j.zu;
            root.sign = det.lo > 0 ? 1 : (det.hi < 0 ? -1 : 0);
            const std::optional<Box> next = krawczyk(sample, f_x, f_z, j);
            // They share the solution; the test is for what rounding may leave of boxes of no width.
            if (!next || disjoint(image, *next)) break;
            image = intersection(image, *next);
        }
        root.enclosure = image;
        for (const Root& other : found_.roots) {
            if (contains(other.alone_in, image) || contains(alone_in, other.enclosure))
                return;  // found again
        }
        for (const Root& other : found_.roots) {
            if (!disjoint(other.enclosure, image)) return add_undecided(image);
        }
        const auto answer = carries(image);
        if (!answer || (*answer && root.sign == 0)) return add_undecided(image);
        if (*answer) found_.roots.push_back(root);
    }

    /// Thousands of small boxes line up along a fold: neighbours become one rectangle.
    void add_undecided(Box box) {
        const auto near = [&](const Box& other) {
            return !disjoint(Box{outward(other.x.lo - kSmallestBox, other.x.hi + kSmallestBox),
                                 outward(other.z.lo - kSmallestBox, other.z.hi + kSmallestBox)},
                             box);
        };
        std::vector<Box>& all = found_.undecided;
        for (auto other = std::ranges::find_if(all, near); other != all.end();
             other = std::ranges::find_if(all, near)) {
            box = {hull(other->x, box.x), hull(other->z, box.z)};
            all.erase(other);
        }
        all.push_back(box);
    }

    /// Whether the solution in `image` is a ray of the light inside the domain; nothing if it is too near to
    /// a border to say.
    std::optional<bool> carries(const Box& image) const {
        if (disjoint(domain_, image)) return false;
        Sample sample;
        take(image, false, sample);
        const Jet<Interval>& over = sample.over;
        const auto ray = departure<Interval>(map_, sample.box.x, sample.box.z, over.height, over.x, over.z);
        if (ray.facing.hi <= 0 || ray.drop.hi <= 0 || ray.ahead_y.hi <= 0) return false;
        if (!contains(domain_, image) || ray.facing.lo <= 0 || ray.drop.lo <= 0 || ray.ahead_y.lo <= 0)
            return std::nullopt;
        return true;
    }

    const Surface::Local& surface_;
    const MapConstants& map_;
    Box domain_;
    RootSearch found_;
};

}  // namespace

RootSearch find_roots(const Surface::Local& surface, const MapConstants& map, const Box& domain) {
    return Finder(surface, map, domain).run();
}

}  // namespace dapple::oracle
