#pragma once
#include <memory>
#include <string>

#include "methods/caustic_method.h"

namespace dapple::methods {

/// The method of that name (scene::Caustics::method); throws Error(timeline_invalid) where there is none.
std::unique_ptr<CausticMethod> make_method(const std::string& name);

}  // namespace dapple::methods
