#pragma once
#include "methods/reference/interval.h"

namespace dapple::oracle {

/// A function's value and its derivatives along u and v (forward differentiation: Griewank & Walther,
/// Evaluating Derivatives, 2008, chapter 3). Over intervals both are bounds on a box.
template <class T>
struct Dual {
    T value{};
    T du{};
    T dv{};
};

template <class T>
Dual<T> operator+(const Dual<T>& a, const Dual<T>& b) {
    return {a.value + b.value, a.du + b.du, a.dv + b.dv};
}
template <class T>
Dual<T> operator-(const Dual<T>& a, const Dual<T>& b) {
    return {a.value - b.value, a.du - b.du, a.dv - b.dv};
}
template <class T>
Dual<T> operator*(const Dual<T>& a, const Dual<T>& b) {
    return {a.value * b.value, a.value * b.du + a.du * b.value, a.value * b.dv + a.dv * b.value};
}
/// b must not hold 0.
template <class T>
Dual<T> operator/(const Dual<T>& a, const Dual<T>& b) {
    const T quotient = a.value / b.value;
    return {quotient, (a.du - quotient * b.du) / b.value, (a.dv - quotient * b.dv) / b.value};
}

template <class T>
Dual<T> operator+(const Dual<T>& a, double b) {
    return {a.value + b, a.du, a.dv};
}
template <class T>
Dual<T> operator-(const Dual<T>& a, double b) {
    return {a.value - b, a.du, a.dv};
}
template <class T>
Dual<T> operator-(double a, const Dual<T>& b) {
    return {a - b.value, -b.du, -b.dv};
}
template <class T>
Dual<T> operator*(double a, const Dual<T>& b) {
    return {a * b.value, a * b.du, a * b.dv};
}

template <class T>
Dual<T> square(const Dual<T>& a) {
    const T twice = 2.0 * a.value;
    return {square(a.value), twice * a.du, twice * a.dv};
}
/// Of a positive number.
template <class T>
Dual<T> square_root(const Dual<T>& a) {
    const T root = square_root(a.value);
    const T twice = 2.0 * root;
    return {root, a.du / twice, a.dv / twice};
}

}  // namespace dapple::oracle
