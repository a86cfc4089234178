#pragma once
#include <algorithm>
#include <cmath>

/// Interval arithmetic with outward rounding (Moore, Kearfott & Cloud, Introduction to Interval Analysis,
/// 2009).
namespace dapple::oracle {

/// All reals between two finite numbers, both included. Every function below returns an interval that holds
/// each exact result of its arguments' members. Overflow and empty intervals are the caller's affair.
struct Interval {
    double lo = 0;
    double hi = 0;
};

/// A rounded result less (plus) one to two units in its last place: at or beyond the exact result, since
/// rounding to nearest errs by half a unit. The constant covers what underflows. This needs no switch of the
/// rounding mode, which compilers do not respect.
inline double below(double x) {
    return x - (std::abs(x) * 0x1p-52 + 1e-307);
}
inline double above(double x) {
    return x + (std::abs(x) * 0x1p-52 + 1e-307);
}
inline Interval outward(double lo, double hi) {
    return {below(lo), above(hi)};
}
/// [center - radius, center + radius]; radius >= 0.
inline Interval around(double center, double radius) {
    return outward(center - radius, center + radius);
}

inline Interval operator-(Interval a) {
    return {-a.hi, -a.lo};
}
inline Interval operator+(Interval a, Interval b) {
    return outward(a.lo + b.lo, a.hi + b.hi);
}
inline Interval operator-(Interval a, Interval b) {
    return outward(a.lo - b.hi, a.hi - b.lo);
}
inline Interval operator*(Interval a, Interval b) {
    const double p = a.lo * b.lo, q = a.lo * b.hi, r = a.hi * b.lo, s = a.hi * b.hi;
    return outward(std::min(std::min(p, q), std::min(r, s)), std::max(std::max(p, q), std::max(r, s)));
}
/// b must not hold 0.
inline Interval operator/(Interval a, Interval b) {
    const double p = a.lo / b.lo, q = a.lo / b.hi, r = a.hi / b.lo, s = a.hi / b.hi;
    return outward(std::min(std::min(p, q), std::min(r, s)), std::max(std::max(p, q), std::max(r, s)));
}

inline Interval operator+(Interval a, double b) {
    return outward(a.lo + b, a.hi + b);
}
inline Interval operator-(Interval a, double b) {
    return outward(a.lo - b, a.hi - b);
}
inline Interval operator-(double a, Interval b) {
    return outward(a - b.hi, a - b.lo);
}
inline Interval operator*(double a, Interval b) {
    return a >= 0 ? outward(a * b.lo, a * b.hi) : outward(a * b.hi, a * b.lo);
}

/// a * a, which a product of two intervals would overestimate.
inline Interval square(Interval a) {
    const double low = a.lo > 0 ? a.lo : (a.hi < 0 ? -a.hi : 0.0);
    const double high = std::max(-a.lo, a.hi);
    return {std::max(0.0, below(low * low)), above(high * high)};
}
/// Of the part of `a` that is not negative.
inline Interval square_root(Interval a) {
    return {std::max(0.0, below(std::sqrt(std::max(0.0, a.lo)))), above(std::sqrt(std::max(0.0, a.hi)))};
}

inline double middle(Interval a) {
    return 0.5 * (a.lo + a.hi);
}
inline double width(Interval a) {
    return a.hi - a.lo;
}
inline bool contains(Interval a, double x) {
    return a.lo <= x && x <= a.hi;
}
inline bool contains(Interval outer, Interval inner) {
    return outer.lo <= inner.lo && inner.hi <= outer.hi;
}
inline bool contains_in_interior(Interval outer, Interval inner) {
    return outer.lo < inner.lo && inner.hi < outer.hi;
}
inline bool disjoint(Interval a, Interval b) {
    return a.hi < b.lo || b.hi < a.lo;
}
/// Of intervals that are not disjoint.
inline Interval intersection(Interval a, Interval b) {
    return {std::max(a.lo, b.lo), std::min(a.hi, b.hi)};
}
inline Interval hull(Interval a, Interval b) {
    return {std::min(a.lo, b.lo), std::max(a.hi, b.hi)};
}

/// The same names for plain numbers, for code that is written once for both.
inline double square(double a) {
    return a * a;
}
inline double square_root(double a) {
    return std::sqrt(a);
}

}  // namespace dapple::oracle
