#pragma once
#include <cstdint>
#include <memory>

#include "methods/caustic_method.h"
#include "methods/reference/light_tracer.h"

namespace dapple::methods {

/// Brute force, to judge the other methods by: slow, noisy, and without their ideas. Light is traced in
/// double from a stratified, jittered grid over the water, on the analytic surface where there is one, and
/// from one over each light's view of each body of glass that the chains name, by
/// Snell's law and Fresnel's equations of its own, through any chain of water, glass and mirrors, to cells on
/// the receivers; a pixel's E is the mean over the cells that its own 16 x 16 camera paths end in. It shares
/// nothing with light/, optics/ and other methods; camera paths come from view/.
///
/// Light is traced in rounds of equal passes, whose means a pixel are independent estimates: they give E and
/// its standard error, which "E.variance.R/G/B" (data layers of sample 0, branch 0) hold squared. Rounds grow
/// until the mean standard error over the mean E is at most ReferenceParameters::standard_error; where
/// most_rays does not suffice the last round that fits is the answer. A cell of the receivers that straddles
/// a pixel's edge blurs by an eighth of a pixel at most; on planes aligned with the pixels there is none.
/// Where E changes much between neighbouring paths, as in the focus of a ball, such cells count for more or
/// fewer paths than lie in them: the flux there was 2.3 % low on a plane that was not aligned.
///
/// Bodies of glass are spheres, whose crossings are exact, and the triangles of boxes and meshes, these with
/// interpolated normals where the file gives normals. What lies about a body (water or air) is asked where a
/// ray comes out. S of a grid so dense that no event is found in its lit skin is 0, with a
/// relative error of 1 in the stats, after as many rays as are allowed.
///
/// With a checkpoint's file, what is done is kept there every 20 s, at the end of a call and when the user
/// wants to end, and read again by the same job, whose results then have the same bits as those of an
/// undisturbed one. The file holds all layers of a frame and is left to the caller to remove once the frame
/// is complete.
///
/// S is found the same way, a layer of segments at a time: light on its ways through media is scattered
/// towards the camera at random places. Transmittance is exact in homogeneous media and in what is dense of
/// grids, elsewhere by ratio tracking. Segments from the eye of a perspective camera have no bias
/// (eye_connection.h); others are seen by beams around sub-pixel camera paths, 8 x 8 a sample's part of a
/// pixel (fewer in pictures of more than 16384 pixels), whose error falls with the square of their width
/// (camera_beams.h).
///
/// A round ends the estimate because its own errors are small, which favours rounds that missed a little:
/// over 24 seeds S of a lamp over water was 0.3 % low where 3 % was asked for, a tenth of what is stated
/// (with one round alone -0.01 +- 0.14 %).
///
/// Limits: light that leaves the water's rectangle below open water does not meet the rest plane outside it;
/// branches of later crossings of less than 1e-4 of the light, and chains of more than 16 events, end (both
/// are counted in the stats).
/// Light of a sun's disc that would come from below the horizon is left out.
class Reference final : public CausticMethod {
public:
    explicit Reference(reference::ReferenceOptions options = {});
    ~Reference() override;
    Support supports_surface(const scene::FrameState& state) const override;
    Support supports_volume(const scene::FrameState& state) const override;
    bool serves_behind_specular() const override { return true; }
    bool follows_glass() const override { return true; }
    std::size_t bytes(const scene::FrameState& state, std::size_t pixels) const override;
    void begin(FrameContext& context) override;
    /// Error(interrupted) when the checkpoint says so.
    void irradiance(FrameContext& context, std::span<const view::ReceiverLayer> layers,
                    std::span<LayerResult> results) override;
    /// Error(interrupted) when the checkpoint says so.
    void in_scatter(FrameContext& context, const view::SegmentLayer& layer,
                    std::span<glm::vec3> radiance) override;
    /// "S.variance.R/G/B": squared standard error of what a pixel receives of its segments.
    std::vector<DataLayer> in_scatter_data() override;

    /// Strata a pass and source in the first round of S, where a ray has many events.
    static constexpr std::uint64_t kFirstVolumeStrata = 4096;

private:
    struct State;
    reference::ReferenceOptions options_;
    std::unique_ptr<State> state_;
};

}  // namespace dapple::methods
