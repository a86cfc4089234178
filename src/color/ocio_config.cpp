#include "color/ocio_config.h"

#include <cstdlib>
#include <regex>
#include <sstream>
#include <string_view>

#include "base/checked_file.h"
#include "base/error.h"

namespace dapple::color {
namespace {

[[noreturn]] void refuse(const std::string& source, const std::string& why) {
    throw Error(ExitCode::input_unreadable, "OCIO config " + source + ": " + why);
}

/// Configs of OCIO 2.2 and later are refused before OCIO sees them: its own message says only what it does
/// not know.
void check_version(const std::string& text, const std::string& source) {
    static const std::regex version_line(
        R"((?:^|\n)ocio_profile_version\s*:\s*["']?(\d{1,4})(?:\.(\d{1,4}))?)");
    std::smatch found;
    if (!std::regex_search(text, found, version_line)) refuse(source, "has no ocio_profile_version");
    const int major = std::stoi(found[1]);
    const int minor = found[2].matched ? std::stoi(found[2]) : 0;
    if (major > 2 || (major == 2 && minor > 1)) {
        refuse(source, "is of version " + std::to_string(major) + "." + std::to_string(minor) +
                           "; OpenColorIO " + OCIO::GetVersion() + " reads configs up to version 2.1");
    }
}

OCIO::ConfigRcPtr read_config(const std::string& path) {
    if (path.starts_with("ocio://")) {
        refuse(path, "built-in configs came with OpenColorIO 2.2, this is " +
                         std::string(OCIO::GetVersion()) +
                         "; name a file, or leave it out for the shipped config");
    }
    constexpr std::uint64_t most_bytes = std::uint64_t{64} << 20;
    const std::vector<std::byte> bytes = read_whole_file(path, most_bytes);
    check_version({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, path);
    return OCIO::Config::CreateFromFile(path.c_str())->createEditableCopy();
}

OCIO::ConfigRcPtr read_shipped() {
    std::istringstream stream(shipped_config());
    return OCIO::Config::CreateFromStream(stream)->createEditableCopy();
}

std::string path_of_config(const std::string& path) {
    if (!path.empty()) return path;
    const char* from_environment = std::getenv("OCIO");
    return from_environment != nullptr ? from_environment : "";
}

/// "'a', 'b'"
template <typename NameOf>
std::string listed(int count, NameOf name_of) {
    std::string list;
    for (int i = 0; i < count; ++i) {
        list.append(i > 0 ? ", '" : "'").append(name_of(i)).append("'");
    }
    return list.empty() ? "none" : list;
}

[[noreturn]] void unknown(const LoadedConfig& loaded, const std::string& kind, const std::string& name,
                          const std::string& known) {
    throw Error(ExitCode::timeline_invalid, "OCIO config " + loaded.source + " has no " + kind + " '" +
                                                clipped(name) + "'; it has " + known);
}

}  // namespace

LoadedConfig load_config(const std::string& path) {
    const std::string chosen = path_of_config(path);
    LoadedConfig loaded{nullptr, chosen.empty() ? "shipped" : chosen};
    try {
        const OCIO::ConfigRcPtr config = chosen.empty() ? read_shipped() : read_config(chosen);
        config->setProcessorCacheFlags(OCIO::PROCESSOR_CACHE_OFF);
        loaded.config = config;
    } catch (const OCIO::Exception& error) {
        refuse(loaded.source, clipped(error.what()));
    }
    if (!loaded.config->hasRole(OCIO::ROLE_SCENE_LINEAR)) {
        refuse(loaded.source, "has no role scene_linear; its roles are " +
                                  listed(loaded.config->getNumRoles(),
                                         [&](int i) { return loaded.config->getRoleName(i); }));
    }
    return loaded;
}

ViewDescription describe_view(const LoadedConfig& loaded, const ViewSettings& settings) {
    const OCIO::Config& config = *loaded.config;
    ViewDescription description;
    description.config = loaded.source;
    description.config_name = config.getName();
    description.config_id = config.getCacheID();
    description.ocio_version = OCIO::GetVersion();

    description.display = settings.display.empty() ? config.getDefaultDisplay() : settings.display;
    const char* display = description.display.c_str();
    const auto view_name = [&](int i) { return config.getView(display, i); };
    if (config.getNumViews(display) == 0) {
        unknown(loaded, "display", description.display,
                listed(config.getNumDisplays(), [&](int i) { return config.getDisplay(i); }));
    }
    description.view =
        settings.view.empty() ? config.getDefaultView(display, OCIO::ROLE_SCENE_LINEAR) : settings.view;
    if (std::string_view(config.getDisplayViewColorSpaceName(display, description.view.c_str())).empty()) {
        unknown(
            loaded, "view", description.view,
            listed(config.getNumViews(display), view_name) + " for display '" + description.display + "'");
    }
    description.look = settings.look;
    if (!settings.look.empty() && config.getLook(settings.look.c_str()) == nullptr) {
        unknown(loaded, "look", settings.look,
                listed(config.getNumLooks(), [&](int i) { return config.getLookNameByIndex(i); }));
    }
    return description;
}

}  // namespace dapple::color
