#include "image/exr.h"

#include <ImfChannelList.h>
#include <ImfChromaticitiesAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfOutputFile.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfThreading.h>
#include <OpenEXRConfig.h>
#include <half.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <exception>
#include <mutex>

#include "base/error.h"
#include "base/parallel.h"
#include "image/exr_stream.h"

namespace dapple::image {
namespace {

constexpr float kLargestHalf = HALF_MAX;
constexpr int kMostPixelsASide = 16384;
constexpr std::uint64_t kMostDecodedBytes = std::uint64_t{8} << 30;

/// A channel as the file holds it: `halves` or, widened or not, `floats`.
struct StoredChannel {
    std::vector<Imath::half> halves;
    std::vector<float> floats;  ///< empty where the image's own values can be stored as they are
    StoredCounts counts;
};

float stored_half(float value, StoredCounts& counts) {
    if (!std::isfinite(value)) {
        ++counts.non_finite;
        return 0;
    }
    if (std::abs(value) > kLargestHalf) {
        ++counts.clamped;
        return std::copysign(kLargestHalf, value);
    }
    return value;
}

StoredChannel store(const Channel& channel) {
    StoredChannel stored;
    if (channel.type == PixelType::half_float) {
        stored.halves.reserve(channel.values.size());
        for (const float value : channel.values)
            stored.halves.emplace_back(stored_half(value, stored.counts));
        return stored;
    }
    const auto is_broken = [](float value) { return !std::isfinite(value); };
    stored.counts.non_finite = static_cast<std::size_t>(std::ranges::count_if(channel.values, is_broken));
    if (stored.counts.non_finite > 0) {
        stored.floats = channel.values;
        std::ranges::replace_if(stored.floats, is_broken, 0.0f);
    }
    return stored;
}

std::vector<StoredChannel> store(const Image& image) {
    std::vector<StoredChannel> stored(image.channels.size());
    parallel_for(stored.size(), 1, [&](std::size_t begin, std::size_t) {
        assert(image.channels[begin].values.size() == image.pixels());
        stored[begin] = store(image.channels[begin]);
    });
    return stored;
}

Imf::Header header_of(const Image& image, const ExrOptions& options) {
    Imf::Header header(image.width, image.height);
    header.compression() = Imf::ZIP_COMPRESSION;
    header.zipCompressionLevel() = options.zip_level;
    if (options.chromaticities) {
        const auto v2f = [](glm::vec2 v) { return Imath::V2f(v.x, v.y); };
        const Chromaticities& c = *options.chromaticities;
        Imf::addChromaticities(header, {v2f(c.red), v2f(c.green), v2f(c.blue), v2f(c.white)});
    }
    if (options.fps_numerator != 0) {
        Imf::addFramesPerSecond(header, Imf::Rational(static_cast<int>(options.fps_numerator),
                                                      static_cast<int>(options.fps_denominator)));
    }
    for (const auto& [name, text] : image.metadata) header.insert(name, Imf::StringAttribute(text));
    for (const Channel& channel : image.channels) {
        header.channels().insert(
            channel.name, Imf::Channel(channel.type == PixelType::half_float ? Imf::HALF : Imf::FLOAT));
    }
    return header;
}

template <typename T>
Imf::Slice slice_of(Imf::PixelType type, const T* first, int width) {
    // The library's one slice type serves reading and writing, hence the cast; it does not write through this
    // one.
    return {type, const_cast<char*>(reinterpret_cast<const char*>(first)), sizeof(T),
            sizeof(T) * static_cast<std::size_t>(width)};
}

std::vector<std::byte> encode(const Image& image, const ExrOptions& options,
                              const std::vector<StoredChannel>& stored) {
    assert(image.width > 0 && image.height > 0 && !image.channels.empty());
    std::vector<std::byte> bytes;
    try {
        MemoryWriter stream(bytes);
        Imf::OutputFile file(stream, header_of(image, options));
        Imf::FrameBuffer buffer;
        for (std::size_t i = 0; i < stored.size(); ++i) {
            const Channel& channel = image.channels[i];
            const std::vector<float>& floats = stored[i].floats.empty() ? channel.values : stored[i].floats;
            buffer.insert(channel.name, channel.type == PixelType::half_float
                                            ? slice_of(Imf::HALF, stored[i].halves.data(), image.width)
                                            : slice_of(Imf::FLOAT, floats.data(), image.width));
        }
        file.setFrameBuffer(buffer);
        file.writePixels(image.height);
    } catch (const std::exception& error) {
        throw Error(ExitCode::failure, "an EXR image cannot be encoded: " + clipped(error.what()));
    }
    return bytes;
}

StoredCounts sum_counts(const std::vector<StoredChannel>& stored) {
    StoredCounts sum;
    for (const StoredChannel& channel : stored) {
        sum.clamped += channel.counts.clamped;
        sum.non_finite += channel.counts.non_finite;
    }
    return sum;
}

[[noreturn]] void refuse(const std::string& name, const std::string& why) {
    throw Error(ExitCode::input_unreadable, name + ": " + why);
}

/// Allocation follows the header, so the header is judged first.
void check_readable(const Imf::Header& header, const std::string& name) {
    if (header.hasType() && header.type() != Imf::SCANLINEIMAGE && header.type() != Imf::TILEDIMAGE) {
        refuse(name, "is an EXR of type '" + clipped(header.type()) +
                         "'; scanlines or tiles are read, not deep pixels");
    }
    const Imf::Compression compression = header.compression();
    if (compression != Imf::NO_COMPRESSION && compression != Imf::RLE_COMPRESSION &&
        compression != Imf::ZIPS_COMPRESSION && compression != Imf::ZIP_COMPRESSION) {
        refuse(name,
               "is an EXR with lossy or fragile compression; none, RLE, ZIPS and ZIP are read "
               "(`oiiotool IN --compression zip -o OUT` converts)");
    }
    // In 64 bit: the corners are any 32-bit numbers.
    const Imath::Box2i& window = header.dataWindow();
    const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
    const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
    if (width < 1 || height < 1 || width > kMostPixelsASide || height > kMostPixelsASide) {
        refuse(name, "is an EXR of " + std::to_string(width) + " x " + std::to_string(height) +
                         " pixels; 1 to " + std::to_string(kMostPixelsASide) + " a side are read");
    }
    std::uint64_t channels = 0;
    for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel) {
        ++channels;
        if (channel.channel().xSampling != 1 || channel.channel().ySampling != 1) {
            refuse(name, "is an EXR with subsampled channels, which are not read");
        }
    }
    const std::uint64_t pixels = static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
    if (channels == 0) refuse(name, "is an EXR without channels");
    if (pixels * channels > kMostDecodedBytes / sizeof(float)) {
        refuse(name,
               "is an EXR of more than " + std::to_string(kMostDecodedBytes >> 30) + " GiB when decoded");
    }
}

Image decode(std::span<const std::byte> bytes, const std::string& name, const WantedChannel& wanted) {
    MemoryReader stream(bytes, name);
    Imf::MultiPartInputFile file(stream);
    if (file.parts() != 1) {
        refuse(name, "is an EXR of " + std::to_string(file.parts()) + " parts; one is read");
    }
    const Imf::Header& header = file.header(0);
    check_readable(header, name);

    const Imath::Box2i& window = header.dataWindow();
    Image image;
    image.width = window.max.x - window.min.x + 1;
    image.height = window.max.y - window.min.y + 1;
    for (auto attribute = header.begin(); attribute != header.end(); ++attribute) {
        const auto* text = dynamic_cast<const Imf::StringAttribute*>(&attribute.attribute());
        if (text != nullptr && std::strcmp(attribute.name(), "type") != 0) {
            image.metadata.emplace_back(attribute.name(), text->value());
        }
    }
    if (Imf::hasChromaticities(header)) {
        const Imf::Chromaticities& c = Imf::chromaticities(header);
        image.chromaticities = {
            {c.red.x, c.red.y}, {c.green.x, c.green.y}, {c.blue.x, c.blue.y}, {c.white.x, c.white.y}};
    }
    Imf::FrameBuffer buffer;
    const Imf::ChannelList& channels = header.channels();
    for (auto channel = channels.begin(); channel != channels.end(); ++channel) {
        if (wanted && !wanted(channel.name())) continue;
        Channel& read = image.add(
            channel.name(), channel.channel().type == Imf::HALF ? PixelType::half_float : PixelType::float32);
        // The file's own coordinates begin at the window's corner.
        buffer.insert(read.name, Imf::Slice::Make(Imf::FLOAT, read.values.data(), window.min, image.width,
                                                  image.height));
    }
    if (image.channels.empty()) return image;
    Imf::InputPart part(file, 0);
    part.setFrameBuffer(buffer);
    part.readPixels(window.min.y, window.max.y);
    return image;
}

/// Whether `read` holds the same bits as what was stored.
bool same_pixels(const Image& image, const std::vector<StoredChannel>& stored, const Image& read) {
    if (read.width != image.width || read.height != image.height ||
        read.channels.size() != image.channels.size()) {
        return false;
    }
    for (std::size_t i = 0; i < stored.size(); ++i) {
        const Channel& meant = image.channels[i];
        const Channel* found = read.find(meant.name);
        if (found == nullptr || found->type != meant.type) return false;
        if (meant.type == PixelType::half_float) {
            const auto same = [](float value, Imath::half half) {
                return Imath::half(value).bits() == half.bits();
            };
            if (!std::ranges::equal(found->values, stored[i].halves, same)) return false;
        } else {
            const std::vector<float>& floats = stored[i].floats.empty() ? meant.values : stored[i].floats;
            if (std::memcmp(found->values.data(), floats.data(), floats.size() * sizeof(float)) != 0)
                return false;
        }
    }
    return true;
}

}  // namespace

std::string openexr_version() {
    return OPENEXR_VERSION_STRING;
}

void set_exr_threads(int threads) {
    // OpenEXR counts helpers beside the caller; one helper gains nothing over none.
    Imf::setGlobalThreadCount(threads > 1 ? threads : 0);
}

EncodedExr encode_exr(const Image& image, const ExrOptions& options) {
    const std::vector<StoredChannel> stored = store(image);
    return {encode(image, options, stored), sum_counts(stored)};
}

Image decode_exr(std::span<const std::byte> bytes, const std::string& name, const WantedChannel& wanted) {
    static std::once_flag limited;
    std::call_once(limited, [] {
        Imf::Header::setMaxImageSize(kMostPixelsASide, kMostPixelsASide);
        Imf::Header::setMaxTileSize(kMostPixelsASide, kMostPixelsASide);
    });
    try {
        return decode(bytes, name, wanted);
    } catch (const Error&) {
        throw;
    } catch (const std::exception& error) {
        refuse(name, "is no readable EXR: " + clipped(error.what()));
    }
}

Image read_exr(const std::string& path, const WantedChannel& wanted) {
    return decode_exr(read_whole_file(path), path, wanted);
}

bool exr_holds(std::span<const std::byte> bytes, const Image& image, const std::string& name) {
    return same_pixels(image, store(image), decode_exr(bytes, name));
}

WrittenExr write_exr_verified(const std::string& path, const Image& image, const ExrOptions& options) {
    const std::vector<StoredChannel> stored = store(image);
    const auto verify = [&](std::span<const std::byte> read_back) {
        bool same = false;
        try {
            same = same_pixels(image, stored, decode_exr(read_back, path));
        } catch (const Error& error) {
            throw Error(ExitCode::output_unwritable,
                        std::string("written, but not decoded again: ") + error.what());
        }
        if (!same)
            throw Error(ExitCode::output_unwritable, path + ": the pixels read back are not those written");
    };
    const WrittenFile written = write_file_atomically(path, encode(image, options, stored), verify);
    return {written.bytes, written.content_hash, sum_counts(stored)};
}

}  // namespace dapple::image
