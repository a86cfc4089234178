#include "methods/registry.h"

#include "base/error.h"
#include "methods/adaptive_beams/adaptive_beams.h"
#include "methods/caustic_mesh/caustic_mesh.h"
#include "methods/photon_splatting/photon_splatting.h"
#include "methods/reference/reference.h"
#include "methods/sliced_beams/sliced_beams.h"

namespace dapple::methods {

std::unique_ptr<CausticMethod> make_method(const std::string& name) {
    if (name == "photon_splatting") return std::make_unique<PhotonSplatting>();
    if (name == "sliced_beams") return std::make_unique<SlicedBeams>();
    if (name == "reference") return std::make_unique<Reference>();
    if (name == "caustic_mesh") return std::make_unique<CausticMesh>();
    if (name == "adaptive_beams") return std::make_unique<AdaptiveBeams>();
    throw Error(ExitCode::timeline_invalid,
                "caustics.method: there is no method '" + name +
                    "'; there are sliced_beams, photon_splatting, reference, adaptive_beams, caustic_mesh");
}

}  // namespace dapple::methods
