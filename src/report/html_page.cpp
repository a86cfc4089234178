#include "report/html_page.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <utility>

#include "image/png.h"

namespace dapple::report {
namespace {

/// RFC 4648.
std::string base64(std::span<const std::byte> bytes) {
    constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::size_t count = std::min<std::size_t>(bytes.size() - i, 3);
        unsigned group = 0;
        for (std::size_t k = 0; k < 3; ++k)
            group = group << 8 | (k < count ? static_cast<unsigned>(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k) text += k <= count ? kDigits[group >> (18 - 6 * k) & 63] : '=';
    }
    return text;
}

/// JSON that cannot end the <script> it stands in: "<" occurs only inside of strings.
std::string script_safe(const std::string& json) {
    std::string safe;
    safe.reserve(json.size());
    for (const char c : json) {
        if (c == '<') {
            safe += "\\u003c";
        } else {
            safe += c;
        }
    }
    return safe;
}

/// Nothing is fetched and no script runs, and browsers are told so.
constexpr const char* kHead = R"(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; img-src data:; style-src 'unsafe-inline'">
<link rel="icon" href="data:,">
)";

constexpr const char* kStyle = R"(<style>
:root { color-scheme: light; }
body { margin: 2rem auto; padding: 0 1.25rem; max-width: 70rem; background: #fff; color: #1d1f23;
  font: 15px/1.5 "DejaVu Sans", Verdana, system-ui, sans-serif; overflow-wrap: anywhere; }
h1 { font-size: 1.55rem; margin: 0 0 1rem; }
h2 { font-size: 1.15rem; margin: 2.2rem 0 .6rem; padding-bottom: .25rem; border-bottom: 1px solid #d9dce1; }
p { margin: .5rem 0; max-width: 55rem; }
.verdict { margin: .4rem 0; padding: .45rem .8rem; border-left: .3rem solid #9aa1ab; background: #f3f4f6; }
.verdict.good { border-color: #1a7f4b; background: #e9f6ef; }
.verdict.bad { border-color: #b3261e; background: #fcecea; }
.scroll { overflow-x: auto; margin: .8rem 0; }
table { border-collapse: collapse; font-size: .87rem; font-variant-numeric: tabular-nums; overflow-wrap: normal; }
th, td { padding: .28rem .7rem; border-bottom: 1px solid #e2e4e8; text-align: right; vertical-align: top; }
th { background: #f3f4f6; border-bottom: 1px solid #b6bcc5; }
th:first-child, td:first-child { text-align: left; }
th.text, td.text { text-align: left; }
td.good { color: #13663b; }
td.bad { color: #a3160e; font-weight: bold; }
figure { display: inline-block; margin: .8rem 1rem .8rem 0; max-width: 100%; vertical-align: top; }
figcaption { font-size: .85rem; color: #4d535c; }
img { max-width: 100%; height: auto; border: 1px solid #d9dce1; image-rendering: pixelated; }
svg { max-width: 100%; height: auto; }
@media print { body { margin: 0; max-width: none; font-size: 11px; } figure, svg, tr { break-inside: avoid; } }
</style>
)";

const char* tone_class(HtmlPage::Tone tone) {
    return tone == HtmlPage::Tone::good ? "good" : tone == HtmlPage::Tone::bad ? "bad" : "";
}

/// "0.25", "-3 dB", "12 %"; not sentences that begin with a number.
bool looks_like_a_number(const std::string& cell) {
    const std::size_t first = cell.find_first_not_of("+-.<> ");
    return first != std::string::npos && cell[first] >= '0' && cell[first] <= '9' && cell.size() <= 24;
}

}  // namespace

std::string escaped(const std::string& text) {
    std::string safe;
    safe.reserve(text.size());
    for (const char c : text) {
        switch (c) {
            case '&':
                safe += "&amp;";
                break;
            case '<':
                safe += "&lt;";
                break;
            case '>':
                safe += "&gt;";
                break;
            case '"':
                safe += "&quot;";
                break;
            case '\'':
                safe += "&#39;";
                break;
            default:
                // Control characters are not allowed in XML, not even as entities.
                safe += static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t' ? ' ' : c;
        }
    }
    return safe;
}

HtmlPage::HtmlPage(std::string title) : title_(std::move(title)) {}

void HtmlPage::heading(const std::string& text) {
    body_ += "<h2>" + escaped(text) + "</h2>\n";
}

void HtmlPage::paragraph(const std::string& text) {
    body_ += "<p>" + escaped(text) + "</p>\n";
}

void HtmlPage::verdict(const std::string& text, Tone tone) {
    body_ += std::string("<p class=\"verdict ") + tone_class(tone) + "\">" + escaped(text) + "</p>\n";
}

void HtmlPage::table(const std::vector<std::string>& header, const std::vector<std::vector<Cell>>& rows) {
    // Numbers stand at the right, so that their digits are below one another, text at the left.
    std::vector<bool> numbers(header.size(), false);
    for (const std::vector<Cell>& row : rows) {
        assert(row.size() == header.size());
        for (std::size_t i = 0; i < row.size(); ++i) {
            if (looks_like_a_number(row[i].text)) numbers[i] = true;
        }
    }
    body_ += "<div class=\"scroll\"><table>\n<thead><tr>";
    for (std::size_t i = 0; i < header.size(); ++i) {
        body_ += numbers[i] ? "<th scope=\"col\">" : "<th scope=\"col\" class=\"text\">";
        body_ += escaped(header[i]) + "</th>";
    }
    body_ += "</tr></thead>\n<tbody>\n";
    for (const std::vector<Cell>& row : rows) {
        body_ += "<tr>";
        for (std::size_t i = 0; i < row.size(); ++i) {
            std::string style = tone_class(row[i].tone);
            if (!numbers[i]) style += style.empty() ? "text" : " text";
            body_ += style.empty() ? "<td>" : "<td class=\"" + style + "\">";
            body_ += escaped(row[i].text) + "</td>";
        }
        body_ += "</tr>\n";
    }
    body_ += "</tbody></table></div>\n";
}

void HtmlPage::plot(const std::string& svg) {
    body_ += "<figure>" + svg + "</figure>\n";
}

void HtmlPage::picture(int width, int height, std::span<const std::uint8_t> rgb, const std::string& caption) {
    const std::string png = base64(image::encode_png(width, height, rgb));
    body_ += "<figure><img width=\"" + std::to_string(width) + "\" height=\"" + std::to_string(height) +
             "\" alt=\"" + escaped(caption) + "\" src=\"data:image/png;base64," + png + "\"><figcaption>" +
             escaped(caption) + "</figcaption></figure>\n";
}

void HtmlPage::data(const std::string& json) {
    data_ = json;
}

std::string HtmlPage::html() const {
    std::string page = kHead;
    page += "<title>" + escaped(title_) + "</title>\n" + kStyle + "</head>\n<body>\n<h1>" + escaped(title_) +
            "</h1>\n" + body_;
    if (!data_.empty()) {
        page += "<script type=\"application/json\" id=\"data\">" + script_safe(data_) + "</script>\n";
    }
    return page + "</body>\n</html>\n";
}

}  // namespace dapple::report
