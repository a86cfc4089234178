// The tabulated phase function against the function, over all mean cosines that a timeline may have.
#include "methods/sliced_beams/phase_table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/constants.hpp>

#include "media/media.h"

namespace dapple {
namespace {

/// Largest relative error over angles that lie close at both ends, the least one given.
template <class Real>
double worst_error(const scene::PhaseFunction& phase, double least = 1e-5) {
    scene::FrameScene scene;
    scene.state.water.emplace();
    scene.state.water->phase = phase;
    const media::Media media(scene);
    const methods::sliced_beams::PhaseTable<Real> table(media, 0);
    double worst = 0;
    constexpr int count = 50000;
    for (int i = 0; i < count; ++i) {
        const double small = glm::half_pi<double>() * std::pow(least, static_cast<double>(i) / count);
        for (const double angle : {small, glm::pi<double>() - small}) {
            const double exact = media.phase(0, std::cos(angle));
            worst = std::max(worst, std::abs(static_cast<double>(table.at(
                                                 static_cast<Real>(std::pow(std::sin(0.5 * angle), 2)))) /
                                                 exact -
                                             1));
        }
    }
    return worst;
}

TEST(PhaseTable, LobesAreExact) {
    for (const double g : {-0.75, -0.5, 0.0, 0.5, 0.9, 0.95, 0.99}) {
        scene::PhaseFunction phase;
        phase.type = scene::PhaseType::henyey_greenstein;
        phase.anisotropy = g;
        // The function's own cosine is rounded to 1e-16, a part in 5e-9 of the narrowest lobe's width;
        // backward lobes lose the digits that 1 - sin^2 does: 2^-24 * 3 / 2 of 49 times their width.
        EXPECT_LT(worst_error<double>(phase), 1e-11) << g;
        EXPECT_LT(worst_error<float>(phase), g < 0 ? 1e-5 : 1e-6) << g;
        phase.type = scene::PhaseType::two_lobe;
        phase.back_anisotropy = -0.4;
        phase.forward_share = 0.8;
        EXPECT_LT(worst_error<double>(phase), 1e-11) << g;
        EXPECT_LT(worst_error<float>(phase), g < 0 ? 1e-5 : 1e-6) << g;
    }
}

TEST(PhaseTable, HoldsTheForwardPeakOfFournierAndForand) {
    scene::PhaseFunction phase;
    phase.type = scene::PhaseType::fournier_forand;
    // Which is steep as a power of the angle down to where it is cut off: linear interpolation over the root
    // of the sine is good from a degree on.
    const double error = worst_error<double>(phase, 0.01);
    printf("Fournier & Forand, tabulated: off by %.1e\n", error);
    EXPECT_LT(error, 1e-4);
}

}  // namespace
}  // namespace dapple
