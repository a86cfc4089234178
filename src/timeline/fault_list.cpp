#include "timeline/fault_list.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "base/error.h"

namespace dapple::timeline {
namespace {

constexpr std::size_t kLongestSource = 240;  // bytes of a line that are shown
constexpr std::size_t kMostKept = 100'000;   // of a hostile file; far above what is shown

bool continues_character(char c) {
    return (static_cast<unsigned char>(c) & 0xC0U) == 0x80U;
}

/// The line as it stands, with blanks for characters that a terminal would act on; tabs stay.
std::string printable(std::string_view line) {
    std::string text(line);
    for (char& c : text)
        if ((static_cast<unsigned char>(c) < 0x20 && c != '\t') || c == 0x7F) c = ' ';
    return text;
}

std::string line_of(std::string_view text, int line) {
    for (int i = 1; i < line; ++i) text.remove_prefix(std::min(text.find('\n'), text.size() - 1) + 1);
    text = text.substr(0, text.find('\n'));
    if (!text.empty() && text.back() == '\r') text.remove_suffix(1);
    if (text.size() <= kLongestSource) return printable(text);
    std::size_t end = kLongestSource;
    while (end > 0 && continues_character(text[end])) --end;
    return printable(text.substr(0, end)) + "...";
}

std::string headline(const Fault& fault) {
    std::string text = fault.file;
    if (fault.line > 0) text += ':' + std::to_string(fault.line) + ':' + std::to_string(fault.column);
    text += ": ";
    if (!fault.key_path.empty()) text += fault.key_path + ": ";
    return text + fault.message;
}

std::string one_line(const std::vector<Fault>& faults, std::size_t more) {
    std::string text = headline(faults.front());
    const std::size_t others = faults.size() - 1 + more;
    if (others > 0)
        text += " (and " + std::to_string(others) + (others == 1 ? " more fault)" : " more faults)");
    return text;
}

}  // namespace

std::string to_string(const Fault& fault) {
    std::string text = headline(fault);
    if (fault.source.empty()) return text;
    text += "\n    " + fault.source;
    std::string caret = "\n    ";
    int column = 1;
    for (const char c : fault.source) {
        if (continues_character(c)) continue;
        if (column++ == fault.column) return text + caret + '^';
        caret += c == '\t' ? '\t' : ' ';
    }
    return column == fault.column ? text + caret + '^' : text;  // just behind the line's end
}

std::string to_string(const TimelineError& error) {
    std::string text;
    for (const Fault& fault : error.faults()) text += to_string(fault) + '\n';
    const std::size_t count = error.faults().size() + error.more();
    text += std::to_string(count) + (count == 1 ? " fault" : " faults");
    if (error.more() > 0) text += ", the first " + std::to_string(error.faults().size()) + " are shown";
    return text + '\n';
}

TimelineError::TimelineError(std::vector<Fault> faults, std::size_t more)
    : Error(ExitCode::timeline_invalid, one_line(faults, more)), faults_(std::move(faults)), more_(more) {}

FaultList::FaultList(const std::string& name, std::string_view text,
                     const std::vector<std::string>& overrides)
    : name_(name), text_(text), overrides_(overrides) {}

void FaultList::add(const input::Place& place, const std::string& key_path, const std::string& message) {
    if (faults_.size() < kMostKept)
        faults_.push_back({place, {{}, 0, 0, clipped(key_path), clipped(message), {}}});
}

void FaultList::raise() {
    std::stable_sort(faults_.begin(), faults_.end(), [](const Placed& a, const Placed& b) {
        return std::tie(a.place.text, a.place.line, a.place.column) <
               std::tie(b.place.text, b.place.line, b.place.column);
    });
    std::vector<Fault> shown;
    for (Placed& placed : faults_) {
        if (shown.size() == TimelineError::kMostFaults) break;
        const bool override_text = placed.place.text > 0;
        Fault& fault = placed.fault;
        fault.file = override_text ? "--set" : name_;
        fault.line = override_text ? 0 : placed.place.line;
        fault.column = placed.place.column;
        fault.source = override_text ? line_of(overrides_[static_cast<std::size_t>(placed.place.text) - 1], 1)
                                     : line_of(text_, placed.place.line);
        shown.push_back(std::move(fault));
    }
    const std::size_t more = faults_.size() - shown.size();
    throw TimelineError(std::move(shown), more);
}

}  // namespace dapple::timeline
