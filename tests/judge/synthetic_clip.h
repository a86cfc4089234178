#pragma once
#include <ImfChannelList.h>
#include <ImfChromaticities.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "image/exr.h"
#include "image/image.h"

/// Small clips whose defects are known because they were planted.
namespace dapple::judge::test {

inline constexpr int kWidth = 120;
inline constexpr int kHeight = 72;

/// Bright soft lines that move and focus, as caustics do: smooth in space and time, and bright where waves of
/// three headings agree. `t` in frames.
inline float caustic(double x, double y, double t) {
    const double a = std::sin(0.21 * x + 0.05 * y - 0.20 * t);
    const double b = std::sin(-0.08 * x + 0.23 * y - 0.17 * t + 1.0);
    const double c = std::sin(0.15 * x - 0.17 * y - 0.23 * t + 2.5);
    return static_cast<float>(0.1 + 0.2 * std::exp(1.2 * (a + b + c)));
}

/// A frame of the clean clip, moved by (dx, dy) pixels to the right and down.
inline image::Image clean_frame(double t, double dx = 0, double dy = 0) {
    image::Image frame;
    frame.width = kWidth;
    frame.height = kHeight;
    for (const char* name : {"R", "G", "B"}) frame.add(name);
    for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
            const float value = caustic(x - dx, y - dy, t);
            const std::size_t i = static_cast<std::size_t>(y * kWidth + x);
            frame.channels[0].values[i] = 0.7f * value;
            frame.channels[1].values[i] = value;
            frame.channels[2].values[i] = 1.1f * value;
        }
    }
    return frame;
}

inline void scale(image::Image& frame, double factor, int x0 = 0, int y0 = 0, int width = kWidth,
                  int height = kHeight) {
    for (image::Channel& channel : frame.channels) {
        for (int y = y0; y < y0 + height; ++y) {
            for (int x = x0; x < x0 + width; ++x) {
                channel.values[static_cast<std::size_t>(y * kWidth + x)] *= static_cast<float>(factor);
            }
        }
    }
}

inline std::string frame_path(const std::string& folder, int frame) {
    char name[32];
    std::snprintf(name, sizeof name, "/clip.%04d.exr", frame);
    return folder + name;
}

/// dapple's own writer takes NaN out of pictures, so this one writes it.
inline void write_raw(const std::string& path, const image::Image& frame) {
    Imf::Header header(frame.width, frame.height);
    header.compression() = Imf::ZIP_COMPRESSION;
    Imf::FrameBuffer buffer;
    for (const image::Channel& channel : frame.channels) {
        header.channels().insert(channel.name, Imf::Channel(Imf::FLOAT));
        buffer.insert(
            channel.name,
            Imf::Slice(Imf::FLOAT, const_cast<char*>(reinterpret_cast<const char*>(channel.values.data())),
                       sizeof(float), sizeof(float) * static_cast<std::size_t>(frame.width)));
    }
    Imf::OutputFile file(path.c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(frame.height);
}

using Edit = std::function<void(int number, image::Image& frame)>;

/// Frames 1 to `count`.
inline void write_clip(const std::string& folder, int count, const Edit& edit = {}) {
    std::filesystem::create_directories(folder);
    for (int number = 1; number <= count; ++number) {
        image::Image frame = clean_frame(number);
        if (edit) edit(number, frame);
        write_raw(frame_path(folder, number), frame);
    }
}

inline std::vector<char> bytes_of(const std::string& path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

inline void write_bytes(const std::string& path, const std::vector<char>& bytes) {
    std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace dapple::judge::test
