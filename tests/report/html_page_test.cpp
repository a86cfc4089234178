#include "report/html_page.h"

#include <gmock/gmock.h>

#include <cstddef>
#include <string>
#include <vector>

#include "image/png.h"

namespace dapple::report {
namespace {

using testing::HasSubstr;
using testing::Not;

std::vector<std::byte> from_base64(const std::string& text) {
    const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::vector<std::byte> bytes;
    unsigned bits = 0, held = 0;
    for (const char c : text) {
        if (c == '=') break;
        held = held << 6 | static_cast<unsigned>(digits.find(c));
        bits += 6;
        if (bits >= 8) bytes.push_back(static_cast<std::byte>(held >> (bits -= 8) & 255));
    }
    return bytes;
}

TEST(Escaped, LeavesNoMarkup) {
    EXPECT_EQ(escaped("a<b>&\"c'"), "a&lt;b&gt;&amp;&quot;c&#39;");
    EXPECT_EQ(escaped("&amp;"), "&amp;amp;");
    EXPECT_EQ(escaped(std::string("a\0\x1b[31m\n", 8)), "a  [31m\n");
    EXPECT_EQ(escaped("Größe"), "Größe");
}

TEST(HtmlPage, EscapesTextWhereverItStands) {
    const std::string evil = "<script>alert('x')</script>\"&";
    HtmlPage page(evil);
    page.heading(evil);
    page.paragraph(evil);
    page.verdict(evil, HtmlPage::Tone::bad);
    page.table({evil}, {{{evil, HtmlPage::Tone::good}}, {{evil}}});
    page.picture(1, 1, std::vector<std::uint8_t>{1, 2, 3}, evil);
    page.data("{\"name\": \"</script><script>alert(1)</script>\"}");
    const std::string html = page.html();
    EXPECT_THAT(html, Not(HasSubstr("<script>")));
    EXPECT_THAT(
        html,
        HasSubstr(R"(id="data">{"name": "\u003c/script>\u003cscript>alert(1)\u003c/script>"}</script>)"));
    std::size_t ends = 0;
    for (std::size_t at = html.find("</script"); at != std::string::npos; at = html.find("</script", at + 1))
        ++ends;
    EXPECT_EQ(ends, 1u);
}

TEST(HtmlPage, NeedsNothingElse) {
    HtmlPage page("report");
    page.plot("<svg></svg>");
    page.picture(2, 1, std::vector<std::uint8_t>{1, 2, 3, 4, 5, 6}, "two pixels");
    const std::string html = page.html();
    for (const char* reference : {"http://", "https://", "@import", "url("})
        EXPECT_THAT(html, Not(HasSubstr(reference)));
    EXPECT_THAT(html, HasSubstr("default-src 'none'"));
}

TEST(HtmlPage, PicturesAreLossless) {
    // 1 to 3 bytes are left for the last group of base64, whatever the PNG's length.
    for (int width = 1; width < 12; ++width) {
        std::vector<std::uint8_t> rgb(3 * static_cast<std::size_t>(width) * 2);
        for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = static_cast<std::uint8_t>(i * i * 7 + 1);
        HtmlPage page("p");
        page.picture(width, 2, rgb, "c");
        const std::string html = page.html();
        const std::size_t begin = html.find("base64,") + 7;
        const image::CodeValues read =
            image::decode_png(from_base64(html.substr(begin, html.find('"', begin) - begin)), "embedded");
        ASSERT_EQ(read.width, width);
        ASSERT_EQ(read.height, 2);
        for (std::size_t i = 0; i < rgb.size(); ++i)
            EXPECT_EQ(read.rgb[i], static_cast<float>(rgb[i]) / 255.0f);
    }
}

TEST(HtmlPage, TonesShowInTheMarkup) {
    HtmlPage page("p");
    page.verdict("fine", HtmlPage::Tone::good);
    page.table({"name", "value"}, {{{"flicker"}, {"0.25", HtmlPage::Tone::bad}},
                                   {{"4 frames are missing from this"}, {"none"}}});
    EXPECT_THAT(page.html(), HasSubstr("<p class=\"verdict good\">fine</p>"));
    EXPECT_THAT(page.html(), HasSubstr("<td class=\"bad\">0.25</td>"));
    EXPECT_THAT(page.html(), HasSubstr("<td class=\"text\">flicker</td>"));
    EXPECT_THAT(page.html(), HasSubstr("<td>none</td>")) << "in a column of numbers";
    EXPECT_EQ(page.html(), page.html());
}

}  // namespace
}  // namespace dapple::report
