#include "judge/sequence_reader.h"

#include <time.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <filesystem>
#include <mutex>
#include <new>
#include <span>
#include <thread>
#include <utility>

#include "base/error.h"
#include "base/hash.h"
#include "image/exr.h"
#include "image/png.h"

namespace dapple::judge {
namespace {

constexpr const char* kDisplayReferred = "dapple:ocio_view";  // in pictures that dapple graded

double thread_cpu_seconds() {
    timespec now{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

bool is_png(std::span<const std::byte> bytes) {
    constexpr std::byte kSignature[] = {std::byte{0x89}, std::byte{'P'}, std::byte{'N'}, std::byte{'G'}};
    return bytes.size() >= std::size(kSignature) && std::ranges::equal(bytes.first<4>(), kSignature);
}

image::Image image_of(image::CodeValues values) {
    image::Image image;
    image.width = values.width;
    image.height = values.height;
    for (const char* name : {"R", "G", "B"}) {
        std::vector<float>& plane = image.add(name).values;
        const std::size_t offset = image.channels.size() - 1;
        for (std::size_t i = 0; i < plane.size(); ++i) plane[i] = values.rgb[3 * i + offset];
    }
    return image;
}

/// The channels to decode: those of the layer as metrics::picture_of takes them, and motion.
std::vector<std::string> wanted_channels(const ReadOptions& options, bool motion) {
    std::vector<std::string> names;
    const std::string prefix = options.layer.empty() ? "" : options.layer + ".";
    for (const char* channel : {"R", "G", "B"}) names.push_back(prefix + channel);
    names.push_back(options.layer.empty() ? "Y" : options.layer);
    if (motion) {
        names.push_back(options.motion_layer + ".X");
        names.push_back(options.motion_layer + ".Y");
    }
    return names;
}

void check_size(PictureSize size, const std::optional<PictureSize>& right, const std::string& path) {
    if (right && size != *right) {
        throw Error(ExitCode::input_unreadable,
                    path + ": is " + std::to_string(size.width) + " x " + std::to_string(size.height) +
                        " pixels, the other frames " + std::to_string(right->width) + " x " +
                        std::to_string(right->height));
    }
}

metrics::Motion motion_of(image::Image& image, const std::string& layer, const std::string& path) {
    image::Channel* x = image.find(layer + ".X");
    image::Channel* y = image.find(layer + ".Y");
    if (x == nullptr || y == nullptr) {
        throw Error(ExitCode::input_unreadable,
                    path + ": has no channels " + layer + ".X and " + layer + ".Y for motion");
    }
    return {image.width, image.height, std::move(x->values), std::move(y->values)};
}

image::Image decode_exr(std::span<const std::byte> bytes, const std::string& path,
                        const std::vector<std::string>& names, const std::optional<PictureSize>& right) {
    // The size first, and of the header alone: a damaged one must not take memory.
    const image::Image header = image::decode_exr(bytes, path, [](const std::string&) { return false; });
    check_size({header.width, header.height}, right, path);
    image::Image image = image::decode_exr(
        bytes, path, [&](const std::string& name) { return std::ranges::find(names, name) != names.end(); });
    // Without what is wanted the message names what there is.
    return image.channels.empty() ? image::decode_exr(bytes, path) : image;
}

void decode(ReadFrame& read, std::span<const std::byte> bytes, const ReadOptions& options, bool motion,
            std::optional<PictureSize>& right) {
    const bool png = is_png(bytes);
    image::Image image = png ? image_of(image::decode_png(bytes, read.path))
                             : decode_exr(bytes, read.path, wanted_channels(options, motion), right);
    const PictureSize size{image.width, image.height};
    check_size(size, right, read.path);
    metrics::Picture picture = metrics::picture_of(image, options.layer, read.path);
    if (motion) read.motion = motion_of(image, options.motion_layer, read.path);
    read.display_referred = png || std::ranges::any_of(image.metadata, [](const auto& entry) {
                                return entry.first == kDisplayReferred;
                            });
    read.chromaticities = image.chromaticities;
    read.picture = std::move(picture);
    right = size;
}

/// One frame of a sequence. Whatever goes wrong is its fault.
ReadFrame read(const Sequence& sequence, std::int64_t frame, const ReadOptions& options, bool motion,
               std::optional<PictureSize>& right) {
    ReadFrame read;
    read.frame = frame;
    const auto file = sequence.files.find(frame);
    std::error_code unknown;
    if (file == sequence.files.end() || !std::filesystem::exists(file->second, unknown)) {
        read.missing = true;
        read.fault = "there is no file of frame " + std::to_string(frame);
        return read;
    }
    read.path = file->second;
    try {
        const std::vector<std::byte> bytes = read_whole_file(read.path);
        read.bytes = bytes.size();
        if (options.content_hash) read.content_hash = content_hash(bytes.data(), bytes.size());
        decode(read, bytes, options, motion, right);
    } catch (const std::bad_alloc&) {
        read.fault = clipped(read.path + ": needs more memory than there is");
    } catch (const std::exception& error) {
        read.fault = clipped(error.what());
    }
    if (!read.fault.empty()) read.motion.reset();
    return read;
}

}  // namespace

void to_rec709(ReadFrame& frame) {
    if (!frame.picture) return;
    image::Image primaries;
    primaries.chromaticities = frame.chromaticities;
    metrics::to_rec709(*frame.picture, primaries);
}

struct SequenceReader::State {
    std::vector<Sequence> sequences;
    ReadOptions options;
    std::vector<std::optional<PictureSize>> sizes;  ///< that each sequence's pictures have, once known

    std::mutex mutex;
    std::condition_variable_any changed;
    std::optional<std::vector<ReadFrame>> ready;
    bool finished = false;
    std::atomic<double> cpu_s = 0;
    std::jthread thread;  ///< the last member: it ends before what it uses

    std::vector<ReadFrame> read_step(std::int64_t frame) {
        std::vector<ReadFrame> step;
        for (std::size_t i = 0; i < sequences.size(); ++i) {
            const bool motion = i == 0 && !options.motion_layer.empty();
            step.push_back(read(sequences[i], frame, options, motion, sizes[i]));
        }
        cpu_s = thread_cpu_seconds();
        return step;
    }

    void run(const std::stop_token& stop) {
        for (const std::int64_t frame : options.frames) {
            if (stop.stop_requested()) break;
            // Nothing is read while a step still waits: it starts when the caller takes that one to compute.
            std::unique_lock lock(mutex);
            if (!changed.wait(lock, stop, [this] { return !ready; })) break;
            lock.unlock();
            std::vector<ReadFrame> step = read_step(frame);
            lock.lock();
            ready = std::move(step);
            changed.notify_all();
        }
        const std::lock_guard lock(mutex);
        finished = true;
        changed.notify_all();
    }
};

SequenceReader::SequenceReader(std::vector<Sequence> sequences, const ReadOptions& options)
    : state_(std::make_unique<State>()) {
    state_->sequences = std::move(sequences);
    state_->options = options;
    if (state_->options.frames.empty() && !state_->sequences.empty()) {
        state_->options.frames = all_frames(state_->sequences);
    }
    state_->sizes.assign(state_->sequences.size(), options.size);
    state_->thread = std::jthread([state = state_.get()](const std::stop_token& stop) { state->run(stop); });
}

SequenceReader::~SequenceReader() = default;

std::vector<ReadFrame> SequenceReader::next() {
    std::unique_lock lock(state_->mutex);
    state_->changed.wait(lock, [this] { return state_->ready || state_->finished; });
    if (!state_->ready) return {};
    std::vector<ReadFrame> step = std::move(*state_->ready);
    state_->ready.reset();
    state_->changed.notify_all();
    return step;
}

double SequenceReader::decode_cpu_s() const {
    return state_->cpu_s;
}

}  // namespace dapple::judge
