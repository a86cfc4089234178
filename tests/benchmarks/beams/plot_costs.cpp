// Draws what bench_beams measured: CPU seconds of sliced_beams over beams, receivers and depth, log-log, as a
// page. Call: bench_beams --benchmark_filter=coverage --benchmark_out=costs.json; plot_costs costs.json >
// costs.html
#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "report/plot.h"

namespace {

using dapple::report::Plot;

/// A row "coverage/CELLS/DEPTH/SIDE/...".
struct Row {
    int cells = 0, depth = 0, side = 0;
    double beams_M = 0, beams_s = 0, pyramid_s = 0, coverage_s = 0;
};

std::vector<Row> read_rows(const char* file) {
    std::ifstream in(file);
    if (!in) throw std::runtime_error(std::string(file) + ": cannot be opened");
    std::vector<Row> rows;
    const nlohmann::json measured = nlohmann::json::parse(in);
    for (const auto& entry : measured.at("benchmarks")) {
        std::istringstream name(entry.at("name").get<std::string>());
        Row row;
        std::string part;
        char slash = 0;
        std::getline(name, part, '/');
        if (part != "coverage" || !(name >> row.cells >> slash >> row.depth >> slash >> row.side)) continue;
        row.beams_M = entry.at("triangles_M");
        row.beams_s = entry.at("beams_cpu_s");
        row.pyramid_s = entry.at("pyramid_cpu_s");
        row.coverage_s = entry.at("coverage_cpu_s");
        rows.push_back(row);
    }
    return rows;
}

/// The three costs of the rows that pass, over a value of theirs.
template <class Keep, class Value>
std::string plot(const std::vector<Row>& rows, std::string title, std::string label, Keep keep, Value value) {
    std::map<double, const Row*> sorted;
    for (const Row& row : rows)
        if (keep(row)) sorted[value(row)] = &row;
    Plot plot;
    plot.title = std::move(title);
    plot.x_label = std::move(label);
    plot.y_label = "CPU-s";
    plot.log_x = plot.log_y = true;
    plot.series = {{"coverage", {}, true, true}, {"beams", {}, true, true}, {"pyramid", {}, true, true}};
    for (const auto& [x, row] : sorted) {
        plot.series[0].points.emplace_back(x, row->coverage_s);
        plot.series[1].points.emplace_back(x, row->beams_s);
        plot.series[2].points.emplace_back(x, row->pyramid_s);
    }
    return dapple::report::svg(plot);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        std::cerr << "plot_costs FILE.json, of bench_beams --benchmark_out=FILE.json\n";
        return 2;
    }
    const std::vector<Row> rows = read_rows(argv[1]);
    std::cout << "<!DOCTYPE html><meta charset=\"utf-8\"><title>Costs of sliced_beams</title>\n"
              << plot(
                     rows, "over beams: 1 M receivers, 2 m deep", "beams, million",
                     [](const Row& row) { return row.depth == 2 && row.side == 1024; },
                     [](const Row& row) { return row.beams_M; })
              << plot(
                     rows, "over receivers: 2.1 M beams, 2 m deep", "receivers, million",
                     [](const Row& row) { return row.depth == 2 && row.cells == 1024; },
                     [](const Row& row) { return 1e-6 * row.side * row.side; })
              << plot(
                     rows, "over depth: 2.1 M beams, 1 M receivers", "depth, m",
                     [](const Row& row) { return row.cells == 1024 && row.side == 1024; },
                     [](const Row& row) { return row.depth; });
    return 0;
}
