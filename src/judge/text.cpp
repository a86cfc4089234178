#include "judge/text.h"

#include <algorithm>
#include <cstdio>

#include "base/frame_set.h"

namespace dapple::judge {

std::string formatted(const char* format, double value) {
    char text[64];
    std::snprintf(text, sizeof text, format, value);
    return text;
}

std::string percent(double share) {
    return formatted("%.2f", 100 * share);
}

std::string frames_text(const std::vector<std::int64_t>& frames) {
    std::string list;
    for (const std::int64_t frame : frames) list += (list.empty() ? "" : ",") + std::to_string(frame);
    return to_string(FrameSet::parse(list));
}

std::string aligned(const std::vector<std::vector<std::string>>& rows) {
    std::vector<std::size_t> widths;
    for (const auto& row : rows) {
        widths.resize(std::max(widths.size(), row.size()));
        for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
    }
    std::string text;
    for (const auto& row : rows) {
        for (std::size_t i = 0; i < row.size(); ++i) {
            const std::string space(widths[i] - row[i].size() + (i == 0 ? 0 : 2), ' ');
            text += i == 0 ? row[i] + space : space + row[i];
        }
        while (!text.empty() && text.back() == ' ') text.pop_back();
        text += "\n";
    }
    return text;
}

std::string csv_quoted(const std::string& text) {
    std::string safe = "\"";
    for (const char c : text) safe += c == '"' ? "\"\"" : std::string(1, c);
    return safe + "\"";
}

}  // namespace dapple::judge
