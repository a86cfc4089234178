// Files of claims: YAML, with the faults of all keys told at once.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>

#include "base/checked_file.h"
#include "base/frame_set.h"
#include "base/suggest.h"
#include "base/units.h"
#include "input/yaml_reader.h"
#include "judge/bench_claim.h"
#include "judge/bench_plan.h"
#include "timeline/fault_list.h"

namespace dapple::judge {
namespace {

using input::LocatedNode;
using Kind = LocatedNode::Kind;

constexpr std::string_view kVersion = "1";
constexpr std::string_view kAgainst = " against ";

std::vector<std::string_view> figure_names() {
    std::vector<std::string_view> names;
    for (const Figure& figure : claim_figures()) names.push_back(figure.name);
    return names;
}

bool is_plain(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
           std::string_view("_./%+- ").find(c) != std::string_view::npos;
}

/// A scalar as YAML has it within brackets.
std::string scalar_text(const std::string& scalar) {
    if (!scalar.empty() && scalar.front() != ' ' && scalar.back() != ' ' &&
        std::all_of(scalar.begin(), scalar.end(), is_plain))
        return scalar;
    std::string text = "\"";
    for (const char c : scalar) text += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
    return text + "\"";
}

/// A value in one line of YAML, as overrides take it.
std::string flow_text(const LocatedNode& node) {
    std::string text;
    switch (node.kind) {
        case Kind::empty:
            return "";
        case Kind::scalar:
            return scalar_text(node.scalar);
        case Kind::sequence:
            for (const LocatedNode& item : node.items) text += (text.empty() ? "" : ", ") + flow_text(item);
            return "[" + text + "]";
        case Kind::map:
            for (const auto& [key, value] : node.entries)
                text += (text.empty() ? "" : ", ") + scalar_text(key) + ": " + flow_text(value);
            return "{" + text + "}";
    }
    return text;
}

/// Path of a key.
std::string below(const std::string& path, const std::string& key) {
    std::string inner = path;
    if (!path.empty()) inner += ".";
    return inner += key;
}

/// Reads the tree of one file; goes on after a fault, so that all are found.
class Reader {
public:
    Reader(Claim& claim, timeline::FaultList& faults) : claim_(claim), faults_(faults) {}

    void read(const LocatedNode& root) {
        std::vector<std::string> settings;
        std::string version, frames, file;
        each(root, "",
             {{"dapple_claim", [&](auto& node, auto& path) { version = text(node, path); }},
              {"source", [&](auto& node, auto& path) { claim_.source = text(node, path); }},
              {"claim", [&](auto& node, auto& path) { claim_.claim = text(node, path); }},
              {"timeline", [&](auto& node, auto& path) { file = text(node, path); }},
              {"frames", [&](auto& node, auto& path) { claim_.frames = frame_numbers(node, path); }},
              {"layer", [&](auto& node, auto& path) { claim_.layer = text(node, path); }},
              {"settings", [&](auto& node, auto& path) { settings = overrides(node, path); }},
              {"reference",
               [&](auto& node, auto& path) {
                   claim_.reference = {kClaimReference, overrides(node, path)};
               }},
              {"runs", [&](auto& node, auto& path) { runs(node, path); }},
              {"regions", [&](auto& node, auto& path) { regions(node, path); }},
              {"rows", [](auto&, auto&) {}}},
             {"dapple_claim", "source", "claim", "timeline", "frames", "runs", "rows"});
        if (!version.empty() && version != kVersion)
            faults_.add(root.find("dapple_claim")->place, "dapple_claim", "this program reads version 1");
        claim_.timeline =
            (std::filesystem::path(claim_.file).parent_path() / file).lexically_normal().string();
        // What holds for all comes first, so that a run can change it.
        for (ClaimRun& run : claim_.runs)
            run.overrides.insert(run.overrides.begin(), settings.begin(), settings.end());
        if (claim_.reference)
            claim_.reference->overrides.insert(claim_.reference->overrides.begin(), settings.begin(),
                                               settings.end());
        if (const LocatedNode* list = root.find("rows")) rows(*list);
    }

private:
    using Read = std::function<void(const LocatedNode&, const std::string& path)>;
    struct Key {
        std::string_view name;
        Read read;
    };

    void fault(const LocatedNode& node, const std::string& path, const std::string& message) {
        faults_.add(node.place, path, message);
    }

    bool expect(const LocatedNode& node, const std::string& path, Kind kind, const char* what) {
        if (node.kind == kind) return true;
        fault(node, path, std::string("expected ") + what);
        return false;
    }

    /// Reads a map by its keys.
    void each(const LocatedNode& node, const std::string& path, const std::vector<Key>& keys,
              const std::vector<std::string_view>& required) {
        if (!expect(node, path, Kind::map, "a map")) return;
        std::vector<std::string_view> names;
        names.reserve(keys.size());
        for (const Key& key : keys) names.push_back(key.name);
        for (const LocatedNode::Entry& entry : node.entries) {
            const std::string inner = below(path, entry.key);
            const auto known =
                std::find_if(keys.begin(), keys.end(), [&](const Key& key) { return key.name == entry.key; });
            if (known == keys.end())
                faults_.add(entry.value.key_place, inner, "unknown key" + suggestion(entry.key, names));
            else
                known->read(entry.value, inner);
        }
        for (const std::string_view name : required)
            if (node.find(name) == nullptr) fault(node, path, "the key " + in_quotes(name) + " is missing");
    }

    std::string text(const LocatedNode& node, const std::string& path) {
        return expect(node, path, Kind::scalar, "a text") ? node.scalar : "";
    }

    double number(const LocatedNode& node, const std::string& path, Dimension dimension, double least,
                  double most) {
        if (!expect(node, path, Kind::scalar, "a number")) return least;
        const Quantity quantity = parse_quantity(node.scalar, dimension);
        if (!quantity.error.empty()) {
            fault(node, path, quantity.error);
        } else if (!(quantity.value >= least && quantity.value <= most)) {
            fault(node, path,
                  "must be " + format_quantity(least, dimension) +
                      (std::isinf(most) ? " or more" : " to " + format_quantity(most, dimension)));
        }
        return quantity.value;
    }
    double number(const LocatedNode& node, const std::string& path) {
        return number(node, path, Dimension::number, 0, std::numeric_limits<double>::infinity());
    }

    std::vector<std::string> texts(const LocatedNode& node, const std::string& path) {
        if (node.kind == Kind::scalar) return {node.scalar};
        std::vector<std::string> list;
        if (!expect(node, path, Kind::sequence, "a text, or a list of texts")) return list;
        for (const LocatedNode& item : node.items) list.push_back(text(item, path));
        return list;
    }

    std::vector<std::int64_t> frame_numbers(const LocatedNode& node, const std::string& path) {
        std::vector<std::int64_t> frames;
        try {
            frames = FrameSet::parse(text(node, path)).frames();
        } catch (const Error& error) {
            fault(node, path, error.what());
        }
        std::sort(frames.begin(), frames.end());
        return frames;
    }

    std::vector<std::string> overrides(const LocatedNode& node, const std::string& path) {
        std::vector<std::string> list;
        if (!expect(node, path, Kind::map, "a map of keys of the timeline")) return list;
        for (const auto& [key, value] : node.entries) list.push_back(key + "=" + flow_text(value));
        return list;
    }

    void runs(const LocatedNode& node, const std::string& path) {
        if (!expect(node, path, Kind::map, "a map of runs by name")) return;
        for (const auto& [name, value] : node.entries) {
            const std::string inner = below(path, name);
            if (!std::all_of(name.begin(), name.end(), is_plain) ||
                name.find_first_of("/ ") != std::string::npos)
                fault(value, inner, "a run's name is that of a folder: letters, digits, '_', '-' and '.'");
            if (name == kClaimReference) fault(value, inner, "'reference' is a key of its own beside 'runs'");
            claim_.runs.push_back({name, overrides(value, inner)});
        }
    }

    void regions(const LocatedNode& node, const std::string& path) {
        if (!expect(node, path, Kind::map, "a map of regions by name")) return;
        constexpr double kInfinity = std::numeric_limits<double>::infinity();
        for (const auto& [name, value] : node.entries) {
            ClaimRegion region{name};
            each(
                value, below(path, name),
                {{"farther_than",
                  [&](auto& n, auto& p) { region.nearest = number(n, p, Dimension::length, 0, kInfinity); }},
                 {"nearer_than",
                  [&](auto& n, auto& p) { region.farthest = number(n, p, Dimension::length, 0, kInfinity); }},
                 {"box",
                  [&](auto& n, auto& p) {
                      if (n.kind != Kind::sequence || n.items.size() != 4)
                          return fault(n, p, "expected [left, top, right, bottom], shares of the picture");
                      for (std::size_t i = 0; i < 4; ++i)
                          region.box[i] = number(n.items[i], p, Dimension::number, 0, 1);
                  }}},
                {});
            claim_.regions.push_back(region);
        }
    }

    /// "RUN" or "RUN against RUN"; errors and their `against` need the runs that they name.
    ClaimTerm term(const LocatedNode& node, const std::string& path) {
        const std::string written = text(node, path);
        ClaimTerm term;
        const std::size_t cut = written.find(kAgainst);
        term.run = written.substr(0, cut);
        if (cut != std::string::npos) term.against = written.substr(cut + kAgainst.size());
        std::vector<std::string_view> known;
        for (const ClaimRun& run : claim_.runs) known.push_back(run.name);
        if (claim_.reference) known.push_back(kClaimReference);
        const auto check_known = [&](const std::string& name) {
            if (std::find(known.begin(), known.end(), name) == known.end())
                fault(node, path, "there is no run " + in_quotes(clipped(name)) + suggestion(name, known));
        };
        check_known(term.run);
        if (cut != std::string::npos) check_known(term.against);
        return term;
    }

    void rows(const LocatedNode& list) {
        if (!expect(list, "rows", Kind::sequence, "a list of rows")) return;
        for (std::size_t i = 0; i < list.items.size(); ++i)
            row(list.items[i], "rows[" + std::to_string(i) + "]");
        if (claim_.rows.empty()) fault(list, "rows", "a claim has one row at least");
    }

    void row(const LocatedNode& node, const std::string& path) {
        ClaimRow row;
        each(node, path,
             {{"says", [&](auto& n, auto& p) { row.says = text(n, p); }},
              {"figure", [&](auto& n, auto& p) { row.figure = figure(n, p); }},
              {"region", [&](auto& n, auto& p) { row.region = region(n, p); }},
              {"count", [&](auto& n, auto& p) { row.count = text(n, p); }},
              {"passes", [&](auto& n, auto& p) { row.passes = texts(n, p); }},
              {"of", [&](auto& n, auto& p) { row.of = term(n, p); }},
              {"over",
               [&](auto& n, auto& p) {
                   if (n.kind != Kind::sequence) return row.over.push_back(term(n, p));
                   for (const LocatedNode& item : n.items) row.over.push_back(term(item, p));
               }},
              {"claimed",
               [&](auto& n, auto& p) {
                   each(n, p,
                        {{"at_least", [&](auto& m, auto& q) { row.at_least = number(m, q); }},
                         {"at_most", [&](auto& m, auto& q) { row.at_most = number(m, q); }}},
                        {});
               }},
              {"expected", [&](auto& n, auto& p) { row.expected = range(n, p); }},
              {"because", [&](auto& n, auto& p) { row.because = text(n, p); }}},
             {"says", "figure", "of"});
        if (row.figure == nullptr) return;
        check(row, node, path);
        claim_.rows.push_back(std::move(row));
    }

    /// What keys of a row ask of each other.
    void check(const ClaimRow& row, const LocatedNode& node, const std::string& path) {
        const Figure& figure = *row.figure;
        const std::string name(figure.name);
        const bool error = figure.kind == Figure::Kind::error;
        const bool timed = figure.kind == Figure::Kind::cpu || figure.kind == Figure::Kind::wall;
        if (figure.repeats() && (!row.expected || row.because.empty()))
            fault(node, path, "the figure " + name + " repeats: it needs 'expected' and 'because'");
        if (!figure.repeats() && row.expected)
            fault(node, path + ".expected",
                  "the figure " + name + " is another on every machine; leave it out");
        for (const std::optional<double>& limit : {row.at_least, row.at_most})
            if (limit && row.expected && row.expected->first < *limit && *limit < row.expected->second)
                fault(node, path + ".expected",
                      "the verdict would turn within it unseen; end it at what is claimed");
        if ((figure.kind == Figure::Kind::count) == row.count.empty())
            fault(node, path, "'count' names what the figure count is of, and of no other figure");
        if (!timed && !row.passes.empty())
            fault(node, path + ".passes", "only cpu and wall are those of passes");
        if (!error && !row.region.empty()) fault(node, path + ".region", "only errors are those of a region");
        if (name == "flip" && !row.region.empty())
            fault(node, path + ".region", "FLIP is that of whole pictures");
        std::vector<ClaimTerm> terms = row.over;
        terms.push_back(row.of);
        for (const ClaimTerm& term : terms) {
            if (error && term.against == kClaimReference && !claim_.reference)
                fault(node, path, "an error needs the key 'reference', or 'RUN against RUN'");
            if (!error && term.against != kClaimReference)
                fault(node, path, "only errors are against another run");
            if (term.run == kClaimReference && figure.noise == nullptr)
                fault(node, path,
                      "of the reference itself there is its noise only, by l1, l1_inside and rmse");
        }
        if (row.over.size() > 1 && figure.noise == nullptr)
            fault(node, path + ".over", "only l1, l1_inside and rmse add in squares");
    }

    const Figure* figure(const LocatedNode& node, const std::string& path) {
        const std::string name = text(node, path);
        for (const Figure& figure : claim_figures())
            if (figure.name == name) return &figure;
        fault(node, path,
              "there is no figure " + in_quotes(clipped(name)) + suggestion(name, figure_names()));
        return nullptr;
    }

    std::string region(const LocatedNode& node, const std::string& path) {
        std::string name = text(node, path);
        std::vector<std::string_view> known;
        for (const ClaimRegion& region : claim_.regions) known.push_back(region.name);
        if (std::find(known.begin(), known.end(), name) == known.end())
            fault(node, path, "there is no region " + in_quotes(clipped(name)) + suggestion(name, known));
        return name;
    }

    std::pair<double, double> range(const LocatedNode& node, const std::string& path) {
        if (node.kind != Kind::sequence || node.items.size() != 2) {
            fault(node, path, "expected [least, most]");
            return {};
        }
        const double least = number(node.items[0], path), most = number(node.items[1], path);
        if (least > most) fault(node, path, "the least comes first");
        return {least, most};
    }

    Claim& claim_;
    timeline::FaultList& faults_;
};

}  // namespace

const std::vector<Figure>& claim_figures() {
    using enum Figure::Kind;
    using Errors = const ClipErrors&;
    static const std::vector<Figure> figures{
        {"l1", "mean |difference| over the mean of what it is against", error, [](Errors e) { return e.l1; },
         &ReferenceNoise::l1},
        {"l1_inside", "l1 of pixels whose neighbours show the same surface", error,
         [](Errors e) { return e.l1_inside; }, &ReferenceNoise::l1},
        {"rmse", "root of the mean squared difference, less the reference's noise, over the mean", error,
         [](Errors e) { return e.rmse_less_noise; }, &ReferenceNoise::rmse},
        {"bias", "size of the mean difference, over the mean", error,
         [](Errors e) { return std::abs(e.bias); }},
        {"excess", "light where there should be less: mean of what is too bright, over the mean", error,
         [](Errors e) { return 0.5 * (e.l1 + e.bias); }},
        {"missing", "light where there should be more: mean of what is too dark, over the mean", error,
         [](Errors e) { return 0.5 * (e.l1 - e.bias); }},
        {"energy", "size of the difference of all light in the picture, over all light", error,
         [](Errors e) { return std::abs(e.energy); }},
        {"largest", "largest |difference| of a pixel's channel, over the mean", error,
         [](Errors e) { return e.largest; }},
        {"dark", "share of the pixels with light that have none in the run", error,
         [](Errors e) { return e.dark; }},
        {"detail", "contrast between neighbouring pixels, over that of what it is against", error,
         [](Errors e) { return e.detail; }},
        {"flip", "HDR-FLIP of R, G, B", error, [](Errors e) { return e.flip; }},
        {"flicker", "of the difference, as --max-flicker has it of pictures", error,
         [](Errors e) { return e.flicker_less_noise.value_or(e.flicker.value_or(std::nan(""))); }},
        {"count", "what the stats count by a name, over all frames", count},
        {"cpu", "CPU seconds a frame, of all passes but writing or of those named", cpu},
        {"wall", "seconds a frame by the clock, the same", wall},
        {"memory", "bytes, peak of the process", memory},
    };
    return figures;
}

Claim read_claim(const std::string& path) {
    Claim claim;
    claim.file = path;
    claim.name = std::filesystem::path(path).stem().string();
    const std::vector<std::byte> bytes = read_whole_file(path, input::kMaxYamlBytes);
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const std::vector<std::string> none;
    timeline::FaultList faults(path, text, none);
    const input::YamlDocument document = input::read_yaml(text);
    for (const input::YamlFault& fault : document.faults)
        faults.add(fault.place, fault.key_path, fault.message);
    if (!document.broken_off) Reader(claim, faults).read(document.root);
    if (!faults.empty()) faults.raise();
    return claim;
}

std::vector<std::string> claim_files(const std::string& path) {
    std::error_code fault;
    if (!std::filesystem::is_directory(path, fault)) return {path};
    return yaml_files(path, "--claims");
}

}  // namespace dapple::judge
