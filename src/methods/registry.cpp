#include "methods/registry.h"

#include "base/error.h"
#include "methods/photon_splatting/photon_splatting.h"

namespace dapple::methods {

std::unique_ptr<CausticMethod> make_method(const std::string& name) {
    if (name == "photon_splatting") return std::make_unique<PhotonSplatting>();
    throw Error(ExitCode::timeline_invalid,
                "caustics.method: there is no method '" + name + "'; there is photon_splatting");
}

}  // namespace dapple::methods
