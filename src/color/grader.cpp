#include "color/grader.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <mutex>

#include "base/error.h"
#include "base/parallel.h"
#include "color/ocio_config.h"

namespace dapple::color {
namespace {

constexpr std::size_t kTilePixels = 4096;

[[noreturn]] void refuse(const std::string& source, const OCIO::Exception& error) {
    throw Error(ExitCode::input_unreadable, "OCIO config " + source + ": " + clipped(error.what()));
}

OCIO::TransformRcPtr exposure_transform(double stops) {
    const auto transform = OCIO::ExposureContrastTransform::Create();
    transform->setStyle(OCIO::EXPOSURE_CONTRAST_LINEAR);
    transform->setExposure(stops);
    return transform;
}

OCIO::TransformRcPtr cdl_transform(const Cdl& cdl) {
    const auto transform = OCIO::CDLTransform::Create();
    transform->setStyle(OCIO::CDL_NO_CLAMP);
    transform->setSlope(&cdl.slope.x);
    transform->setOffset(&cdl.offset.x);
    transform->setPower(&cdl.power.x);
    transform->setSat(cdl.saturation);
    return transform;
}

OCIO::TransformRcPtr conversion(const char* from, const char* to) {
    const auto transform = OCIO::ColorSpaceTransform::Create();
    transform->setSrc(from);
    transform->setDst(to);
    return transform;
}

OCIO::TransformRcPtr look_transform(const std::string& look) {
    const auto transform = OCIO::LookTransform::Create();
    transform->setSrc(OCIO::ROLE_SCENE_LINEAR);
    transform->setDst(OCIO::ROLE_SCENE_LINEAR);
    transform->setLooks(look.c_str());
    return transform;
}

/// Steps that change nothing are left out: they would round. OCIO's own viewing pipeline is not used, since
/// for a view of data ("Raw") it applies a CDL to linear light.
OCIO::ConstProcessorRcPtr make_processor(const LoadedConfig& loaded, const ViewDescription& description,
                                         const Grade& grade) {
    const auto steps = OCIO::GroupTransform::Create();
    if (grade.exposure != 0) steps->appendTransform(exposure_transform(grade.exposure));
    if (grade.cdl != Cdl{}) {
        if (!loaded.config->hasRole(OCIO::ROLE_COLOR_TIMING)) {
            throw Error(
                ExitCode::input_unreadable,
                "OCIO config " + loaded.source + ": has no role color_timing, in which a CDL is applied");
        }
        steps->appendTransform(conversion(OCIO::ROLE_SCENE_LINEAR, OCIO::ROLE_COLOR_TIMING));
        steps->appendTransform(cdl_transform(grade.cdl));
        steps->appendTransform(conversion(OCIO::ROLE_COLOR_TIMING, OCIO::ROLE_SCENE_LINEAR));
    }
    const auto display_view = OCIO::DisplayViewTransform::Create();
    display_view->setSrc(OCIO::ROLE_SCENE_LINEAR);
    display_view->setDisplay(description.display.c_str());
    display_view->setView(description.view.c_str());
    if (!description.look.empty()) {
        steps->appendTransform(look_transform(description.look));
        display_view->setLooksBypass(true);
    }
    steps->appendTransform(display_view);
    try {
        return loaded.config->getProcessor(steps);
    } catch (const OCIO::Exception& error) {
        refuse(loaded.source, error);
    }
}

std::size_t replace_non_finite(std::span<float> values) {
    std::size_t count = 0;
    for (float& value : values) {
        if (std::isfinite(value)) continue;
        value = 0;
        ++count;
    }
    return count;
}

struct MadeProcessor {
    Grade grade;
    OCIO::ConstCPUProcessorRcPtr processor;
    std::string id;
};

/// Applies a processor to packed pixels of `channels` floats.
void apply_packed(const OCIO::CPUProcessor& processor, std::span<float> values, long channels) {
    OCIO::PackedImageDesc pixels(values.data(), static_cast<long>(values.size()) / channels, 1, channels);
    processor.apply(pixels);
}

}  // namespace

struct Grader::State {
    LoadedConfig loaded;
    ViewDescription description;

    std::mutex mutex;  ///< guards what follows
    MadeProcessor last;
    OCIO::ConstCPUProcessorRcPtr texture_processor;

    MadeProcessor processor(const Grade& grade) {
        const std::lock_guard lock(mutex);
        if (last.processor == nullptr || !(grade == last.grade)) {
            const OCIO::ConstProcessorRcPtr made = make_processor(loaded, description, grade);
            last = {grade, made->getDefaultCPUProcessor(), made->getCacheID()};
        }
        return last;
    }

    OCIO::ConstCPUProcessorRcPtr texture_to_scene() {
        const std::lock_guard lock(mutex);
        if (texture_processor == nullptr) {
            try {
                texture_processor =
                    loaded.config->getProcessor(OCIO::ROLE_TEXTURE_PAINT, OCIO::ROLE_SCENE_LINEAR)
                        ->getDefaultCPUProcessor();
            } catch (const OCIO::Exception& error) {
                refuse(loaded.source, error);
            }
        }
        return texture_processor;
    }
};

Grader::Grader(const ViewSettings& settings) : state_(std::make_unique<State>()) {
    state_->loaded = load_config(settings.config);
    state_->description = describe_view(state_->loaded, settings);
    prepare({});
}

Grader::~Grader() = default;
Grader::Grader(Grader&&) noexcept = default;
Grader& Grader::operator=(Grader&&) noexcept = default;

const ViewDescription& Grader::description() const {
    return state_->description;
}

std::vector<std::pair<std::string, std::string>> Grader::metadata() const {
    const ViewDescription& description = state_->description;
    const bool is_named = !description.config_name.empty();
    return {
        {"dapple:ocio_config", is_named ? description.config_name : description.config},
        {"dapple:ocio_config_id", description.config_id},
        {"dapple:ocio_display", description.display},
        {"dapple:ocio_view", description.view},
        {"dapple:ocio_look", description.look},
    };
}

void Grader::prepare(const Grade& grade) const {
    state_->processor(grade);
}

std::string Grader::processor_id(const Grade& grade) const {
    return state_->processor(grade).id;
}

GradedPicture Grader::apply(const image::Image& linear, const Grade& grade) const {
    const std::array<const char*, 3> names{"R", "G", "B"};
    const OCIO::ConstCPUProcessorRcPtr processor = state_->processor(grade).processor;
    GradedPicture graded;
    graded.picture.width = linear.width;
    graded.picture.height = linear.height;
    std::array<const float*, 3> from{};
    for (std::size_t c = 0; c < 3; ++c) {
        const image::Channel* channel = linear.find(names[c]);
        assert(channel != nullptr);
        from[c] = channel->values.data();
        graded.picture.add(names[c], image::PixelType::half_float);
    }
    const std::size_t pixels = linear.pixels();
    std::vector<std::size_t> non_finite((pixels + kTilePixels - 1) / kTilePixels);
    parallel_for(pixels, kTilePixels, [&](std::size_t begin, std::size_t end) {
        // Four floats a pixel are OCIO's own layout, which spares it a copy.
        std::vector<float> rgba(4 * (end - begin), 1.0f);
        for (std::size_t i = begin; i < end; ++i) {
            for (std::size_t c = 0; c < 3; ++c) rgba[4 * (i - begin) + c] = from[c][i];
        }
        std::size_t& count = non_finite[begin / kTilePixels];
        count = replace_non_finite(rgba);
        apply_packed(*processor, rgba, 4);
        count += replace_non_finite(rgba);
        for (std::size_t c = 0; c < 3; ++c) {
            float* to = graded.picture.channels[c].values.data();
            for (std::size_t i = begin; i < end; ++i) to[i] = rgba[4 * (i - begin) + c];
        }
    });
    for (const std::size_t count : non_finite) graded.non_finite += count;
    return graded;
}

void Grader::texture_to_linear(std::span<float> rgb) const {
    assert(rgb.size() % 3 == 0);
    const OCIO::ConstCPUProcessorRcPtr processor = state_->texture_to_scene();
    parallel_for(rgb.size() / 3, kTilePixels, [&](std::size_t begin, std::size_t end) {
        apply_packed(*processor, rgb.subspan(3 * begin, 3 * (end - begin)), 3);
    });
}

std::optional<image::Chromaticities> Grader::working_chromaticities() const {
    const OCIO::Config& config = *state_->loaded.config;
    if (!config.hasRole("aces_interchange")) return std::nullopt;
    const auto ap1_to_ap0 = OCIO::BuiltinTransform::Create();
    ap1_to_ap0->setStyle("ACEScg_to_ACES2065-1");
    // The images of the primaries under both: a matrix is what it does to a basis.
    std::array<float, 9> expected{1, 0, 0, 0, 1, 0, 0, 0, 1};
    std::array<float, 9> found = expected;
    try {
        apply_packed(*config.getProcessor(ap1_to_ap0)->getDefaultCPUProcessor(), expected, 3);
        apply_packed(
            *config.getProcessor(OCIO::ROLE_SCENE_LINEAR, "aces_interchange")->getDefaultCPUProcessor(),
            found, 3);
    } catch (const OCIO::Exception& error) {
        refuse(state_->loaded.source, error);
    }
    // Configs write the matrix with 7 or more digits; the next space in use differs in the second.
    constexpr float same_matrix = 1e-5f;
    const bool is_acescg =
        std::ranges::equal(found, expected, [](float a, float b) { return std::abs(a - b) <= same_matrix; });
    return is_acescg ? std::optional(image::kAcesCgChromaticities) : std::nullopt;
}

}  // namespace dapple::color
