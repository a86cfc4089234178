#include "run/frame_loop.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <set>

#include "base/checked_file.h"
#include "base/hash.h"
#include "render/film.h"
#include "run/manifest.h"
#include "run/memory_budget.h"
#include "run/output_paths.h"
#include "run/preview.h"
#include "run/stats_file.h"
#include "run/temporal_figures.h"

namespace dapple::run {
namespace {

/// Keeps other processes of this machine out of a folder; the system lets go of it when the process ends.
class FolderLock {
public:
    explicit FolderLock(const std::string& folder)
        : folder_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
        // File systems that cannot lock say so with other codes; there the user has to take care.
        if (::flock(folder_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
            ::close(folder_);
            throw Error(ExitCode::usage, "another process is rendering into " + folder +
                                             ": wait for it, or choose another folder with -o");
        }
    }
    ~FolderLock() { ::close(folder_); }
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;

private:
    int folder_;
};

WrittenFile written(const image::WrittenExr& file) {
    return {file.bytes, file.content_hash};
}

std::string short_text(double number) {
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", number);
    return text;
}

/// One call of render_frames().
class FrameLoop {
public:
    FrameLoop(const Job& job, FrameSource& source, const LoopOptions& options,
              const Interruption& interruption, Reporter& reporter)
        : job_(job),
          source_(source),
          options_(options),
          interruption_(interruption),
          reporter_(reporter),
          paths_(options.folder, job.clip.name) {}

    ExitCode run() {
        open_manifest();  // only looks, so that a wrong call leaves no trace
        check_memory(source_, options_.frames, options_.max_memory);
        paths_.make_folders();
        const FolderLock lock(options_.folder);
        open_manifest();  // again, now that nobody else can change it
        for (const std::string& folder :
             {paths_.folder(), paths_.linear_folder(), paths_.graded_folder(), paths_.checkpoint_folder()}) {
            remove_stale_temporaries(folder);
        }
        // Before the manifest claims the folder: what another job left must never be taken up by this one.
        if (!resumes_) paths_.remove_checkpoints();
        save();  // shows that the folder can be written before time is spent
        tidy_stats(paths_.stats(), manifest_.frames);
        temporal_.emplace(paths_, manifest_.frames, options_.frames);
        if (!other_tools_.empty()) {
            reporter_.warning("frames in " + options_.folder + " were made with other versions (" +
                              other_tools_ + "); new ones may differ from them in the last bits");
        }
        warn_of_full_disk();
        reporter_.run_started(options_.folder, options_.frames.frames().size());
        try {
            render_all();
            if (complete_) measure_clip();
        } catch (...) {
            leave_tidy();
            throw;
        }
        tidy_stats(paths_.stats(), manifest_.frames, clip_ ? &*clip_ : nullptr);
        paths_.remove_checkpoint_folder_if_empty();
        return end();
    }

private:
    void open_manifest() {
        manifest_ = Manifest{};
        resumes_ = false;
        if (options_.existing == Existing::overwrite) {
            open_to_overwrite();
        } else if (std::optional<Manifest> known = read_manifest(paths_.manifest()); known) {
            resumes_ = known->job_hash == job_.hash();
            // A job that failed before its first frame claims nothing.
            if (!resumes_ && !known->frames.empty()) {
                throw Error(ExitCode::usage, options_.folder + " holds frames of another job (other: " +
                                                 differences(job_.parts, known->parts) +
                                                 "): choose another folder with -o, or replace them with "
                                                 "--existing overwrite");
            }
            if (!known->frames.empty()) manifest_ = std::move(*known);
        }
        other_tools_ = manifest_.frames.empty() ? "" : differences(job_.provenance, manifest_.provenance);
        manifest_.job_hash = job_.hash();
        manifest_.clip = job_.clip;
        manifest_.parts = job_.parts;
        manifest_.provenance = job_.provenance;
        manifest_.settled = job_.settled;
        if (options_.existing == Existing::error) refuse_existing_frames();
    }

    /// Frames of the same job that are not asked for stay in the manifest; what cannot be read is given up.
    void open_to_overwrite() {
        try {
            std::optional<Manifest> known = read_manifest(paths_.manifest());
            if (known && known->job_hash == job_.hash()) manifest_ = std::move(*known);
        } catch (const Error&) {
            manifest_ = Manifest{};
        }
    }

    void refuse_existing_frames() const {
        for (const std::int64_t frame : options_.frames.frames()) {
            std::error_code ignored;
            if (manifest_.frames.contains(frame) || std::filesystem::exists(paths_.linear(frame), ignored) ||
                std::filesystem::exists(paths_.graded(frame), ignored)) {
                throw Error(ExitCode::usage,
                            "frame " + std::to_string(frame) + " exists in " + options_.folder +
                                ": choose other frames or another folder, or another --existing");
            }
        }
    }

    void warn_of_full_disk() {
        struct statvfs disk {};
        if (::statvfs(options_.folder.c_str(), &disk) != 0) return;
        const double free = static_cast<double>(disk.f_bavail) * static_cast<double>(disk.f_frsize);
        std::size_t missing = 0;
        for (const std::int64_t frame : options_.frames.frames())
            missing += manifest_.frames.contains(frame) ? 0 : 1;
        const double needed = largest_frame_bytes(job_.clip) * static_cast<double>(missing);
        if (needed > free) {
            reporter_.warning("the disk of " + options_.folder + " has " + format_bytes(free) +
                              " free, and " + std::to_string(missing) + " frames may take " +
                              format_bytes(needed));
        }
    }

    void render_all() {
        for (const std::int64_t frame : options_.frames.frames()) {
            if (interruption_.requested()) return;
            if (keeps(frame)) {
                paths_.remove_checkpoint(frame);  // left by a kill just after the frame was entered
                temporal_->frame_done(frame, nullptr);
                reporter_.frame_kept(frame);
            } else if (!render(frame)) {
                return;
            }
        }
        complete_ = true;
    }

    void measure_clip() {
        complete_ = temporal_->complete([this] { return interruption_.requested(); });
        if (!complete_) return;
        if (const std::set<std::int64_t>& frames = temporal_->unreadable(); !frames.empty()) {
            reporter_.warning(std::to_string(frames.size()) +
                              " frames and their neighbours have no temporal "
                              "figures, as the linear picture is not what the manifest says, the first: " +
                              paths_.linear(*frames.begin()));
        }
        clip_ = temporal_->clip();
        if (clip_->worst_frame) {
            reporter_.clip_measured(*clip_);
        } else if (options_.max_flicker) {
            reporter_.warning("--max-flicker: no frame has both neighbours in " + options_.folder +
                              ", so none was held against it");
        }
    }

    bool keeps(std::int64_t frame) const {
        if (options_.existing == Existing::overwrite) return false;
        const auto entry = manifest_.frames.find(frame);
        if (entry == manifest_.frames.end()) return false;
        const bool content = options_.existing == Existing::verify;
        return matches(paths_.linear(frame), entry->second.linear, content) &&
               matches(paths_.graded(frame), entry->second.graded, content);
    }

    /// False where the source has broken the frame off to stop.
    bool render(std::int64_t frame) {
        const double wall_start = wall_seconds();
        const double cpu_start = cpu_seconds();
        check_memory(source_, FrameSet::range(frame, frame), options_.max_memory);
        FrameStats stats;
        std::optional<SourceFrame> rendered = ask_source(frame, stats);
        if (!rendered) return false;
        // As in the file, so that luminance is the same from here and from there.
        rendered->linear.chromaticities = options_.linear_exr.chromaticities;
        const SourceFrame& pictures = *rendered;
        FrameEntry entry;
        for (const render::PlanLine& line : pictures.plan) {
            if (line.decision == "partly") entry.partly.push_back(line.pass + ": " + line.reason);
        }
        entry.non_finite = pictures.non_finite.count;
        if (entry.non_finite > 0) {
            reporter_.warning("frame " + std::to_string(frame) + ": " + std::to_string(entry.non_finite) +
                              " values were NaN or infinite and are 0 now, the first at " +
                              pictures.non_finite.first);
        }
        {
            const ScopedPass pass(stats, "write");
            const image::WrittenExr linear =
                image::write_exr_verified(paths_.linear(frame), pictures.linear, options_.linear_exr);
            const image::WrittenExr graded =
                image::write_exr_verified(paths_.graded(frame), pictures.graded, options_.graded_exr);
            stats.count("clamped to half",
                        static_cast<double>(linear.counts.clamped + graded.counts.clamped));
            entry.linear = written(linear);
            entry.graded = written(graded);
            // The writer's own net; what render/ counts is replaced before.
            entry.non_finite += linear.counts.non_finite + graded.counts.non_finite;
        }
        manifest_.frames[frame] = entry;
        {
            const ScopedPass pass(stats, "temporal figures");
            temporal_->frame_done(frame, &pictures.linear);
        }
        const FrameCost cost{wall_seconds() - wall_start, cpu_seconds() - cpu_start, peak_memory_bytes()};
        // First what it cost, then the manifest: a frame that counts as finished always has its line.
        append_stats(paths_.stats(), stats_line(frame, cost, stats, entry));
        save();
        paths_.remove_checkpoint(frame);
        reporter_.frame_rendered(frame, cost.wall_s, cost.cpu_s, entry.linear.bytes + entry.graded.bytes,
                                 entry.non_finite);
        return true;
    }

    std::optional<SourceFrame> ask_source(std::int64_t frame, FrameStats& stats) {
        paths_.make_checkpoint_folder();
        try {
            return source_.render(frame, stats,
                                  {paths_.checkpoint(frame), [this] { return interruption_.requested(); }});
        } catch (const Error& error) {
            if (error.code() == ExitCode::interrupted) return std::nullopt;
            throw;
        }
    }

    ExitCode end() {
        if (complete_) update_preview();
        if (!complete_) {
            finish(ExitCode::interrupted, "interrupted; the same command goes on: ");
            return ExitCode::interrupted;
        }
        const std::string unfit =
            (options_.strict ? strict_failure() : "") + (options_.max_flicker ? flicker_failure() : "");
        if (!unfit.empty()) {
            finish(ExitCode::check_failed, unfit);
            return ExitCode::check_failed;
        }
        finish(ExitCode::done, "");
        return ExitCode::done;
    }

    /// Why the frames of the set do not satisfy --strict; empty where they do.
    std::string strict_failure() const {
        for (const std::int64_t frame : options_.frames.frames()) {
            const FrameEntry& entry = manifest_.frames.at(frame);
            const std::string where = "--strict: frame " + std::to_string(frame) + " ";
            if (entry.non_finite > 0) {
                return where + "had " + std::to_string(entry.non_finite) + " values that were not finite; ";
            }
            if (!entry.partly.empty()) return where + "was done partly (" + entry.partly.front() + "); ";
        }
        return "";
    }

    /// Which frames of the folder flicker more than --max-flicker; empty where none does.
    std::string flicker_failure() const {
        constexpr std::size_t most_named = 20;
        std::string named;
        std::size_t over = 0;
        for (const auto& [frame, figures] : clip_->frames) {
            if (figures.flicker <= *options_.max_flicker) continue;
            if (++over > most_named) continue;
            named +=
                (over > 1 ? ", " : "") + std::to_string(frame) + " (" + short_text(figures.flicker) + ")";
        }
        if (over == 0) return "";
        if (over > most_named) named += " and " + std::to_string(over - most_named) + " more";
        return "--max-flicker: more than " + short_text(*options_.max_flicker) + " in " +
               (over == 1 ? "frame " : "frames ") + named + "; ";
    }

    void update_preview() {
        PreviewRequest request{paths_.preview(), {}, job_.clip.fps, options_.encoder};
        std::string hashes;
        for (std::int64_t frame = job_.clip.first_frame; frame <= job_.clip.last_frame; ++frame) {
            const auto entry = manifest_.frames.find(frame);
            // Frames outside this run's set have not been looked at yet.
            if (entry == manifest_.frames.end() ||
                !matches(paths_.graded(frame), entry->second.graded, false)) {
                return;
            }
            request.pictures.push_back(paths_.graded(frame));
            hashes += entry->second.graded.content_hash;
        }
        const std::string source_hash = content_hash(hashes);
        if (manifest_.preview && manifest_.preview->source_hash == source_hash &&
            matches(request.path, manifest_.preview->file, true)) {
            return;
        }
        const PreviewResult result = make_preview(request, [&] { return interruption_.requested(); });
        switch (result.state) {
            case PreviewResult::State::made:
                manifest_.preview = {result.file, source_hash};
                save();
                reporter_.preview_made(request.path, result.file.bytes);
                break;
            case PreviewResult::State::failed:
                reporter_.warning("no preview: " + result.reason + "; the frames are complete");
                break;
            case PreviewResult::State::stopped:
                complete_ = false;
                break;
        }
    }

    void finish(ExitCode code, const std::string& remark) {
        reporter_.run_ended(static_cast<int>(code),
                            remark + std::to_string(reporter_.rendered()) + " frames rendered, " +
                                std::to_string(reporter_.kept()) + " kept, in " +
                                format_duration(reporter_.seconds()) + ": " + options_.folder);
    }

    void save() const { write_manifest(paths_.manifest(), manifest_); }

    /// After a failure the first message counts, also where the disk has no room for the statistics.
    void leave_tidy() const {
        paths_.remove_checkpoint_folder_if_empty();
        try {
            tidy_stats(paths_.stats(), manifest_.frames);
        } catch (const std::exception&) {
            return;
        }
    }

    const Job& job_;
    FrameSource& source_;
    const LoopOptions& options_;
    const Interruption& interruption_;
    Reporter& reporter_;
    const OutputPaths paths_;
    Manifest manifest_;
    std::optional<TemporalFigures> temporal_;
    std::optional<metrics::ClipFlicker> clip_;  ///< once all frames are done
    std::string
        other_tools_;  ///< in which the machine differs from the one that made the frames in the manifest
    bool resumes_ = false;  ///< the folder is this job's and its frames are not made anew
    bool complete_ = false;
};

}  // namespace

double largest_frame_bytes(const scene::Clip& clip) {
    // Float channels and 4 half ones, as if nothing were compressed.
    constexpr double channels{render::Film::kOwnChannels + render::Film::kMostMethodChannels};
    return static_cast<double>(clip.width) * static_cast<double>(clip.height) * (channels * 4 + 8);
}

void check_memory(const FrameSource& source, const FrameSet& frames, std::uint64_t max_memory) {
    constexpr std::size_t most = 1000;
    const std::vector<std::int64_t>& all = frames.frames();
    const std::size_t stride = (all.size() + most - 1) / most;
    for (std::size_t i = 0; i < all.size(); i += stride) {
        const std::uint64_t needed = source.bytes(all[i]);
        if (needed <= max_memory) continue;
        throw Error(ExitCode::out_of_memory_budget,
                    "frame " + std::to_string(all[i]) + " needs about " +
                        format_bytes(static_cast<double>(needed)) + " of memory, more than the " +
                        format_bytes(static_cast<double>(max_memory)) +
                        " of --max-memory: lower the resolution, or allow more");
    }
}

ExitCode render_frames(const Job& job, FrameSource& source, const LoopOptions& options,
                       const Interruption& interruption, Reporter& reporter) {
    return FrameLoop(job, source, options, interruption, reporter).run();
}

}  // namespace dapple::run
