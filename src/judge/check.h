#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/frame_set.h"
#include "judge/defects_jumps.h"
#include "judge/defects_shift.h"
#include "judge/sequence.h"
#include "metrics/band_flicker.h"
#include "metrics/bias_flicker.h"
#include "metrics/differences.h"
#include "metrics/errors.h"
#include "metrics/flicker.h"
#include "metrics/flip.h"
#include "metrics/ssim.h"
#include "metrics/warping.h"

/// `dapple check`: what is wrong with a sequence, by itself and against a reference.
namespace dapple::judge {

enum class FlipKind { automatic, ldr, hdr, none };

/// Limits that the user set; a frame beyond one is a finding.
struct CheckLimits {
    std::optional<double> max_flicker;  ///< metrics::ClipFlicker::Frame::flicker
    std::optional<double> max_error;    ///< relative RMSE
    std::optional<double> max_flip;     ///< mean
    std::optional<double> min_psnr;
    std::optional<double> min_ssim;
};

struct CheckOptions {
    std::string sequence;
    std::string reference;  ///< empty: none
    Pictures pictures = Pictures::linear;
    std::string layer;
    std::string motion_layer;
    std::optional<FrameSet> frames;  ///< in ascending order; default: all
    std::optional<double> fps;       ///< default: of the manifest, else bands are in cycles a frame
    FlipKind flip = FlipKind::automatic;
    bool delta_flip = false;
    double pixels_per_degree = metrics::kDefaultPixelsPerDegree;
    std::optional<metrics::Exposures> exposures;  ///< default: of the reference's pilots
    metrics::SsimWindow ssim = metrics::SsimWindow::gaussian;
    double peak = 1;  ///< of PSNR and SSIM
    CheckLimits limits;
    bool maps = false;  ///< keep what the HTML page shows of pixels
};

enum class FindingKind {
    missing,
    duplicate,
    damaged,
    not_finite,
    flash,
    pop,
    jump,
    shift,
    drift,
    reference,
    limit
};
/// "missing", "duplicate", ...
const char* name_of(FindingKind kind);

struct Finding {
    FindingKind kind = FindingKind::missing;
    std::optional<std::int64_t> frame;       ///< none: of the clip
    std::optional<std::int64_t> last_frame;  ///< where it lasts
    std::optional<Box> region;               ///< pixels
    std::string text;                        ///< one line, without the frame
};

struct Pixel {
    int x = 0, y = 0;
};

/// What is known of a frame; what cannot be told is absent.
struct FrameFigures {
    std::int64_t frame = 0;
    std::string path;
    std::string fault;
    std::uint64_t bytes = 0;
    bool readable = false;
    std::size_t not_finite = 0;  ///< pixels
    /// Of luminance; NaN where no pixel counts. With a reference over the pixels that count in both.
    double mean = 0;
    std::optional<double> reference_mean;
    std::optional<metrics::FrameFlicker> temporal;  ///< where both neighbours are there
    std::optional<metrics::Errors> errors;
    std::optional<double> ssim;
    struct Flip {
        double mean = 0, weighted_median = 0, largest = 0;
        Pixel worst;
    };
    std::optional<Flip> flip;
    std::optional<metrics::TemporalDifference> difference;
    std::optional<metrics::DeltaFlip> delta_flip;
    std::optional<metrics::WarpingError> warping;
    std::optional<Shift> shift;
};

/// Means over the frames that have the figure, and the worst of them. Means of relative errors (bias, L1,
/// RMSE) are over all counted pixels of all frames, as shares of the reference's mean over the same.
struct ClipFigure {
    double mean = 0;
    double worst = 0;
    std::int64_t worst_frame = 0;
};

struct CheckResult {
    CheckOptions options;
    std::int64_t first = 0, last = 0;
    int width = 0, height = 0;
    double fps = 0;  ///< 0: unknown, bands are in cycles a frame
    bool display_referred = false;
    FlipKind flip_kind = FlipKind::none;  ///< what was computed
    std::optional<metrics::Exposures> exposures;
    std::vector<Finding> findings;  ///< by kind and frame
    std::vector<std::string> notes;
    std::vector<FrameFigures> frames;
    metrics::ClipFlicker flicker;
    std::vector<metrics::BandFlicker::Band> bands;  ///< of luminance, or of its error
    std::optional<metrics::BiasFlicker::Split> split;
    /// "relative_rmse", "psnr", "ssim", "flip", ...
    std::map<std::string, ClipFigure> clip;
    Pixel worst_pixel;             ///< of the temporal deviation
    double worst_deviation = 0;    ///< there: root of the mean square of H, over the clip's mean
    std::vector<float> deviation;  ///< a value a pixel, where maps are kept
    double level = 0;              ///< largest of the pilots' mean luminances
    double decode_cpu_s = 0, metrics_cpu_s = 0, wall_s = 0;
    std::uint64_t peak_memory = 0;
};

/// Checks a sequence. Throws Error: input_unreadable where there is no sequence or none of its frames can be
/// read, usage for options that do not go together. Everything that is wrong with single frames is a finding.
CheckResult check(const CheckOptions& options);

}  // namespace dapple::judge
