#include "timeline/timeline.h"

#include <filesystem>
#include <fstream>
#include <string_view>
#include <system_error>
#include <utility>

#include "input/yaml_reader.h"
#include "timeline/checks.h"
#include "timeline/fault_list.h"
#include "timeline/fingerprint.h"
#include "timeline/overrides.h"
#include "timeline/program.h"
#include "timeline/reader.h"

namespace dapple::timeline {
namespace {

/// At most one byte more than a timeline may have, so that larger files fail by size and are not read.
std::string read_text(const std::string& path) {
    std::error_code error;
    const bool folder = std::filesystem::is_directory(path, error);
    std::ifstream file(path, std::ios::binary);
    if (folder || !file)
        throw Error(ExitCode::input_unreadable, path + ": " +
                                                    (folder ? "is a folder; expected a timeline, a YAML file"
                                                            : "cannot open the timeline"));
    std::string text(input::kMaxYamlBytes + 1, '\0');
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    if (file.bad()) throw Error(ExitCode::input_unreadable, path + ": cannot read the timeline");
    text.resize(static_cast<std::size_t>(file.gcount()));
    return text;
}

std::string absolute_folder(const std::string& folder) {
    return std::filesystem::absolute(folder.empty() ? "." : folder).lexically_normal().string();
}

}  // namespace

struct Timeline::State {
    Program program;
    std::string folder;
};

Timeline Timeline::load(const std::string& path, const std::vector<std::string>& overrides) {
    return parse(read_text(path), path, std::filesystem::path(path).parent_path().string(), overrides);
}

Timeline Timeline::parse(const std::string& text, const std::string& name, const std::string& folder,
                         const std::vector<std::string>& overrides) {
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    std::string_view shown = text;
    if (shown.substr(0, kByteOrderMark.size()) == kByteOrderMark) shown.remove_prefix(kByteOrderMark.size());

    FaultList faults(name, shown, overrides);
    input::YamlDocument document = input::read_yaml(shown);
    for (const input::YamlFault& fault : document.faults)
        faults.add(fault.place, fault.key_path, fault.message);
    // A tree that broke off would seem to lack all that was not read.
    if (document.broken_off) faults.raise();
    apply_overrides(overrides, document.root, faults);

    auto state = std::make_unique<State>();
    state->folder = absolute_folder(folder);
    if (document.root.kind == input::LocatedNode::Kind::empty)
        faults.add(document.root.place, "", "the file is empty; a timeline starts with 'dapple: 1'");
    else
        state->program = read_program(document.root, state->folder, faults);
    // Faulty values would only be found again, as something else.
    if (faults.empty()) check_program(state->program, document.root, faults);
    if (!faults.empty()) faults.raise();
    return Timeline(std::move(state));
}

Timeline::Timeline(std::unique_ptr<State> state) : state_(std::move(state)) {}
Timeline::~Timeline() = default;
Timeline::Timeline(Timeline&&) noexcept = default;
Timeline& Timeline::operator=(Timeline&&) noexcept = default;

const scene::Clip& Timeline::clip() const {
    return state_->program.base.clip;
}
scene::FrameState Timeline::at(std::int64_t frame) const {
    return evaluate(state_->program, frame);
}
bool Timeline::gives(const std::string& key_path) const {
    return state_->program.given.count(key_path) > 0;
}
std::string Timeline::fingerprint() const {
    return timeline::fingerprint(state_->program, state_->folder);
}
std::vector<std::string> Timeline::input_files() const {
    return timeline::input_files(state_->program);
}

}  // namespace dapple::timeline
