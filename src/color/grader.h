#pragma once
#include <cstddef>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "image/exr.h"
#include "image/image.h"

/// Colour management by OpenColorIO: from scene-linear light to the graded picture, on the CPU.
namespace dapple::color {

/// Where the picture is looked at, and through what.
struct ViewSettings {
    std::string config;   ///< path of an OCIO config; empty: $OCIO, else the shipped one
    std::string display;  ///< empty: the config's default
    std::string view;     ///< empty: the display's default
    std::string look;     ///< a look of the config, instead of those of the view; empty: the view's own
};

/// Color decision list (ASC CDL v1.2): out = (in * slope + offset) ^ power, then saturation about the luma of
/// Rec.709. Nothing is clamped; the power leaves negative values alone.
struct Cdl {
    glm::dvec3 slope{1, 1, 1};
    glm::dvec3 offset{0, 0, 0};
    glm::dvec3 power{1, 1, 1};
    double saturation = 1;
    bool operator==(const Cdl&) const = default;
};

/// What may change from frame to frame.
struct Grade {
    double exposure = 0;  ///< stops, applied to linear light
    Cdl cdl;              ///< in the role color_timing
    bool operator==(const Grade&) const = default;
};

/// What was really used, for manifests and metadata.
struct ViewDescription {
    std::string config;       ///< path, or "shipped"
    std::string config_name;  ///< as the config calls itself; may be empty
    std::string config_id;    ///< OCIO's cache id: a hash of the config and its environment
    std::string ocio_version;
    std::string display;
    std::string view;
    std::string look;  ///< empty: that of the view
};

struct GradedPicture {
    image::Image
        picture;  ///< R, G, B, half in files; code values of the display, 1 is its white. No metadata
    /// NaN and infinity, before or after grading: replaced by 0, since OCIO spreads them over a pixel.
    std::size_t non_finite = 0;
};

/// Grades pictures: exposure, CDL, look, display and view, in this order. Thread-safe. A config that is
/// missing, too new (this is OCIO 2.1) or broken throws Error(input_unreadable) naming it; a display, view or
/// look that the config does not have throws Error(timeline_invalid) with those it has.
class Grader {
public:
    explicit Grader(const ViewSettings& settings);
    ~Grader();
    Grader(Grader&&) noexcept;
    Grader& operator=(Grader&&) noexcept;

    const ViewDescription& description() const;
    /// The description as attributes for EXR headers and the like ("dapple:ocio_view", ...).
    std::vector<std::pair<std::string, std::string>> metadata() const;

    /// Makes the processor of a grade, so that the faults of a config show before frames are rendered. The
    /// last one made is kept, so a grade that does not change costs nothing after the first frame.
    void prepare(const Grade& grade) const;
    /// OCIO's cache id of that processor: equal ids, equal pictures.
    std::string processor_id(const Grade& grade) const;

    /// Channels R, G and B of `linear` (role scene_linear), graded in fixed tiles of pixels on all threads:
    /// the bits do not depend on their number.
    GradedPicture apply(const image::Image& linear, const Grade& grade) const;

    /// Interleaved code values of 8-bit textures (role texture_paint) to scene_linear, in place.
    /// Error(input_unreadable) where the config lacks the role.
    void texture_to_linear(std::span<float> rgb) const;

    /// Primaries of scene_linear for EXR headers, where it is ACEScg; none for other spaces, whose primaries
    /// OCIO 2.1 does not tell.
    std::optional<image::Chromaticities> working_chromaticities() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// The text of the config that is built in: ACES 1.0 for SDR, no LUT files (src/color/shipped_config.ocio).
const std::string& shipped_config();

}  // namespace dapple::color
