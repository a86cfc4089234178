#pragma once
#include <OpenColorIO/OpenColorIO.h>

#include <string>

#include "color/grader.h"

/// Loading and judging an OCIO config. Only for this folder's sources: OpenColorIO's header is heavy.
namespace dapple::color {

namespace OCIO = OCIO_NAMESPACE;

struct LoadedConfig {
    OCIO::ConstConfigRcPtr config;
    std::string source;  ///< path, or "shipped"
};

/// The config of `path`, else of $OCIO, else the shipped one; it has the role scene_linear. Its processors
/// are not cached, since keyed grades make one a frame.
LoadedConfig load_config(const std::string& path);

/// Fills in the defaults of display and view, and refuses names that the config does not have.
ViewDescription describe_view(const LoadedConfig& loaded, const ViewSettings& settings);

}  // namespace dapple::color
