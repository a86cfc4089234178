#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>
#include <memory>
#include <string>

#include "app/verbs.h"
#include "base/parallel.h"
#include "color/grader.h"
#include "gpu/device.h"
#include "grids/vdb_file.h"
#include "run/memory_budget.h"
#include "run/timeline_source.h"
#include "scene/schema.h"

namespace dapple::app {
namespace {

std::string processor_name() {
    std::ifstream stream("/proc/cpuinfo");
    for (std::string line; std::getline(stream, line);) {
        const std::size_t colon = line.find(": ");
        if (line.starts_with("model name") && colon != std::string::npos) return line.substr(colon + 2);
    }
    return "unknown processor";
}

void print_devices() {
    const std::vector<gpu::DeviceInfo> devices = gpu::list_devices();
    if (devices.empty()) std::printf("device        none that satisfies the program's needs (Vulkan 1.3)\n");
    for (const gpu::DeviceInfo& device : devices) {
        std::printf("device        %s (%s), driver %s, Vulkan %s\n", device.name.c_str(),
                    run::to_string(device.type).c_str(), device.driver.c_str(), device.api_version.c_str());
    }
}

ExitCode info() {
    const color::Grader grader({});
    std::printf("dapple        %s\n", run::program_identity().c_str());
    for (const auto& [name, version] : run::library_versions(grader)) {
        std::printf("%-13s %s\n", name.c_str(), version.c_str());
    }
    print_devices();
    std::printf("processor     %s, %d threads\n", processor_name().c_str(), thread_count());
    for (const auto& [name, text] : run::instruction_sets()) {
        std::printf("instructions  of the %s: %s\n", name.c_str(), text.c_str());
    }
    std::printf("memory        %s a frame by default\n",
                run::format_bytes(static_cast<double>(run::default_memory_budget())).c_str());
    const color::ViewDescription& view = grader.description();
    std::printf("colour        config %s (%s), display %s, view %s\n", view.config.c_str(),
                view.config_id.c_str(), view.display.c_str(), view.view.c_str());
    return ExitCode::done;
}

std::string at(const glm::ivec3& voxel) {
    return std::to_string(voxel.x) + " " + std::to_string(voxel.y) + " " + std::to_string(voxel.z);
}

ExitCode info_of_grids(const std::string& file) {
    for (const grids::VdbGridInfo& grid : grids::read_vdb_info(file)) {
        std::printf("%-13s %s, %s, %lld voxels", grid.name.c_str(), grid.value_type.c_str(),
                    grid.grid_class.c_str(), static_cast<long long>(grid.active_voxels));
        if (grid.active_voxels > 0) {
            std::printf(" of %g x %g x %g from (%s) to (%s), %s to load", grid.voxel_size.x,
                        grid.voxel_size.y, grid.voxel_size.z, at(grid.low).c_str(), at(grid.high).c_str(),
                        run::format_bytes(static_cast<double>(grid.loading_bytes)).c_str());
        }
        std::printf("\n");
    }
    return ExitCode::done;
}

}  // namespace

void add_info_verb(CLI::App& app, Run& run) {
    const auto keys = std::make_shared<bool>(false);
    const auto file = std::make_shared<std::string>();
    CLI::App* verb = app.add_subcommand(
        "info", "Versions, devices and colour config; or all keys of a timeline, or the grids of a file");
    CLI::Option* key_reference =
        verb->add_flag("--keys", *keys, "Print the keys of a timeline with type, unit, range and default");
    verb->add_option("file", *file, "OpenVDB file")->excludes(key_reference);
    verb->callback([keys, file, &run] {
        run = [keys, file] {
            if (!file->empty()) return info_of_grids(*file);
            if (!*keys) return info();
            std::printf("%s", scene::key_reference().c_str());
            return ExitCode::done;
        };
    });
}

}  // namespace dapple::app
