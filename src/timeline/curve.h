#pragma once
#include <array>
#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

namespace dapple::timeline {

/// How a curve goes from a key to the next.
enum class Interpolation {
    step,    ///< the key's value holds
    linear,  ///< per component
    cubic,   ///< monotone: between two keys it never leaves the range of their values
    bezier,  ///< eased by the handles `out` of the key and `in` of the next
};

/// Up to three numbers; those beyond a curve's components are 0.
using Values = std::array<double, 3>;

struct Key {
    double time = 0;  ///< s
    Values values{};
    Interpolation interpolation = Interpolation::linear;  ///< to the next key
    // Handles in the unit square of the segment (x: time, y: from its first value to its second), as in CSS.
    glm::dvec2 out{1.0 / 3, 0};  ///< leaving this key
    glm::dvec2 in{2.0 / 3, 1};   ///< arriving at this key
};

/// Values over time: exactly those of the keys at the keys, held before the first and after the last.
class Curve {
public:
    /// `keys`: at least one, times strictly increasing; `components`: 1 to 3.
    Curve(std::vector<Key> keys, std::size_t components);

    Values at(double time) const;
    const std::vector<Key>& keys() const { return keys_; }
    std::size_t components() const { return components_; }

private:
    std::vector<Key> keys_;
    std::size_t components_;
    std::vector<Values> slopes_;  // of monotone cubic segments: at the begin and the end of each segment
};

}  // namespace dapple::timeline
