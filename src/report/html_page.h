#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace dapple::report {

/// Text made safe inside HTML and SVG.
std::string escaped(const std::string& text);

/// A report as one HTML file that needs nothing else: styles inside, plots as SVG, pictures as PNG in data
/// URIs, numbers as embedded JSON. No script is needed to read it.
class HtmlPage {
public:
    explicit HtmlPage(std::string title);

    void heading(const std::string& text);
    void paragraph(const std::string& text);
    enum class Tone { plain, good, bad };
    /// One line that says how it went.
    void verdict(const std::string& text, Tone tone);
    struct Cell {
        std::string text;
        Tone tone = Tone::plain;
    };
    void table(const std::vector<std::string>& header, const std::vector<std::vector<Cell>>& rows);
    /// From report/plot.h.
    void plot(const std::string& svg);
    /// Interleaved 8-bit rows, with what it shows.
    void picture(int width, int height, std::span<const std::uint8_t> rgb, const std::string& caption);
    /// All numbers for programs, in <script type="application/json" id="data">.
    void data(const std::string& json);

    std::string html() const;

private:
    std::string title_, body_, data_;
};

}  // namespace dapple::report
