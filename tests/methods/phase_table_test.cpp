// The tabulated phase function against the function, over all mean cosines that a timeline may have.
#include "methods/sliced_beams/phase_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/constants.hpp>

#include "media/media.h"

namespace dapple {
namespace {

/// Largest relative error over angles that lie close at both ends.
double worst_error(double anisotropy) {
    scene::FrameScene scene;
    scene.state.water.emplace();
    scene.state.water->phase.type = scene::PhaseType::henyey_greenstein;
    scene.state.water->phase.anisotropy = anisotropy;
    const media::Media media(scene);
    const methods::sliced_beams::PhaseTable<double> table(media, 0);
    double worst = 0;
    constexpr int count = 50000;
    for (int i = 0; i < count; ++i) {
        const double small = glm::half_pi<double>() * std::pow(1e-5, static_cast<double>(i) / count);
        for (const double angle : {small, glm::pi<double>() - small}) {
            const double exact = media.phase(0, std::cos(angle));
            worst = std::max(worst, std::abs(table.at(std::sin(0.5 * angle)) / exact - 1));
        }
    }
    return worst;
}

TEST(PhaseTable, HoldsForwardPeaks) {
    for (const double g : {-0.5, 0.0, 0.5, 0.9, 0.95, 0.99}) EXPECT_LT(worst_error(g), 3e-5) << g;
}

/// The nodes lie apart about 180 degrees: the table is good for the lobes of real media, and 2e-3 where
/// timelines end; at -0.9 it would be 4e-2.
TEST(PhaseTable, HoldsTheBackwardPeaksThatAreAllowed) {
    EXPECT_LT(worst_error(-0.75), 2e-3);
}

}  // namespace
}  // namespace dapple
