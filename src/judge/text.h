#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace dapple::judge {

/// A number by a format of printf for one double.
std::string formatted(const char* format, double value);

/// Hundredths of a percent, without the sign: "1.25".
std::string percent(double share);

/// Frame numbers as a set: "1-10x3". At least one.
std::string frames_text(const std::vector<std::int64_t>& frames);

/// A table for a terminal, a line a row; all columns but the first stand at the right. Widths are in bytes.
std::string aligned(const std::vector<std::vector<std::string>>& rows);

/// A field of a CSV file (RFC 4180).
std::string csv_quoted(const std::string& text);

}  // namespace dapple::judge
