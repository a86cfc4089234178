#pragma once

namespace dapple::methods::sliced_beams {

/// Nodes of Gauss & Legendre's rule on [-1, 1] and its weights, three of each: exact for degree five.
constexpr double kNodes[3] = {-0.7745966692414834, 0, 0.7745966692414834};
constexpr double kNodeWeights[3] = {5.0 / 9, 8.0 / 9, 5.0 / 9};
/// Where |q1| + 3 |q2| is at most so much of |q0|, the integral of 1 / (q0 + q1 u + q2 u^2) by these alone is
/// off by 5e-5 at most.
constexpr double kEvenEnough = 0.3;

/// Product quadrature: weights for which sum_j weight[j] g(kNodes[j]) is the integral of g(u) / |q(u)| over
/// [-1, 1], exact for g of degree two, with q = q0 + q1 u + q2 u^2 of one sign there and
/// |q1| + 3 |q2| > kEvenEnough |q0|. From the exact moments of 1 / |q|. False where q has a root in [-1, 1],
/// where the integral does not exist.
bool product_weights(double q0, double q1, double q2, double (&weight)[3]);

}  // namespace dapple::methods::sliced_beams
