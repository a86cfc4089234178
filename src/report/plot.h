#pragma once
#include <string>
#include <utility>
#include <vector>

namespace dapple::report {

struct Series {
    std::string name = {};
    std::vector<std::pair<double, double>> points = {};  ///< in the order of x; not finite: a gap
    bool line = true;
    bool marks = false;
};

struct Plot {
    std::string title = {}, x_label = {}, y_label = {};
    bool log_x = false;  ///< values <= 0 are gaps
    bool log_y = false;
    std::vector<Series> series = {};
    std::vector<std::pair<double, std::string>> limits = {};  ///< level lines: y and what they are
    int width = 760, height = 300;                            ///< px
};

/// The plot as an <svg> element of its own, with axes, ticks, legend; text is escaped. Without a point it
/// says so.
std::string svg(const Plot& plot);

}  // namespace dapple::report
