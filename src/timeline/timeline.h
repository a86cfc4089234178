#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/error.h"
#include "scene/frame_state.h"

namespace dapple::timeline {

/// One fault of a timeline file.
struct Fault {
    std::string file;      ///< "--set" for an override
    int line = 0;          ///< from 1; 0: no line (an override)
    int column = 0;        ///< from 1, in characters; of an override's text where it is one
    std::string key_path;  ///< "water.surface.waves[2].length"
    std::string message;   ///< what is wrong and what would be right, with the nearest valid key or value
    std::string source;    ///< the offending line
};

/// `file:line:column: key.path: message`, then the source line with a caret below it.
std::string to_string(const Fault& fault);

/// All faults of a timeline, at most kMostFaults of them, in the order of their places.
class TimelineError : public Error {
public:
    static constexpr std::size_t kMostFaults = 50;

    TimelineError(std::vector<Fault> faults, std::size_t more);
    const std::vector<Fault>& faults() const noexcept { return faults_; }
    /// Faults beyond the cap.
    std::size_t more() const noexcept { return more_; }

private:
    std::vector<Fault> faults_;
    std::size_t more_;
};

/// All faults as a person reads them, one below the other, with a last line that counts them.
std::string to_string(const TimelineError& error);

/// A checked timeline. Paths inside it are resolved from the file's folder and absolute.
class Timeline {
public:
    /// Throws TimelineError with all faults of the file; Error(input_unreadable) where it cannot be read.
    /// `overrides` are "path=value" with value in YAML, applied before checking.
    static Timeline load(const std::string& path, const std::vector<std::string>& overrides = {});
    /// The same for a text; relative paths are resolved from `folder`.
    static Timeline parse(const std::string& text, const std::string& name, const std::string& folder,
                          const std::vector<std::string>& overrides = {});
    ~Timeline();
    Timeline(Timeline&&) noexcept;
    Timeline& operator=(Timeline&&) noexcept;

    const scene::Clip& clip() const;
    /// The state of one frame, also outside the clip's range (curves hold). Pure.
    scene::FrameState at(std::int64_t frame) const;
    /// Whether the timeline holds a key ("caustics.footprint"), rather than leave it to its default.
    bool gives(const std::string& key_path) const;
    /// All that decides the pictures, in a normal form in which comments, order of keys and ways of writing
    /// numbers do not show: equal text, equal clip. The last frame is left out: a clip made longer keeps its
    /// frames. The first one is in, because it sets the clock. Paths are relative to the timeline's folder.
    std::string fingerprint() const;
    /// Files that the frames of the clip need (textures, meshes, OCIO config), absolute, sorted, for checks
    /// up front and the job's hash. Whether they exist is not looked at, but where a sequence holds over
    /// missing files the files that stand in for them are listed; Error(input_unreadable) where there are
    /// none.
    std::vector<std::string> input_files() const;

private:
    struct State;
    explicit Timeline(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace dapple::timeline
