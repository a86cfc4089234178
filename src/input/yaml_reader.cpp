#include "input/yaml_reader.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <utility>

#include "base/error.h"
#include "base/suggest.h"

namespace dapple::input {
namespace {

constexpr std::size_t kMaxNodes = 1'000'000;
constexpr std::size_t kMaxDepth = 64;  // keeps every later recursion over the tree shallow

/// The text cannot be read on from here.
struct FatalFault {
    YamlFault fault;
};

/// Turns yaml-cpp's marks, which count bytes from 0, into places.
class LineTable {
public:
    LineTable(std::string_view text, int text_index) : text_(text), text_index_(text_index) {
        starts_.push_back(0);
        for (std::size_t i = 0; i < text.size(); ++i)
            if (text[i] == '\n') starts_.push_back(i + 1);
    }

    Place place(int line, int byte_column) const {
        const std::size_t index = std::min(static_cast<std::size_t>(line), starts_.size() - 1);
        const auto bytes = static_cast<std::size_t>(byte_column);
        // Marks mostly come in order, so counting on from the last one keeps very long lines cheap.
        if (index != counted_line_ || bytes < counted_bytes_) {
            counted_line_ = index;
            counted_bytes_ = characters_ = 0;
        }
        const std::string_view between =
            text_.substr(std::min(starts_[index] + counted_bytes_, text_.size()), bytes - counted_bytes_);
        characters_ += static_cast<std::size_t>(std::count_if(between.begin(), between.end(), [](char c) {
            return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U;  // not a continuation byte of UTF-8
        }));
        counted_bytes_ = bytes;
        return {text_index_, static_cast<int>(index) + 1, static_cast<int>(characters_) + 1};
    }
    Place place(const YAML::Mark& mark) const { return place(mark.line, mark.column); }
    /// Behind the last character that is no blank.
    Place end() const { return place_of_byte(text_.find_last_not_of(" \t\r\n") + 1); }
    /// The text from a mark on.
    std::string_view text_from(const YAML::Mark& mark) const {
        const std::size_t line =
            std::min(static_cast<std::size_t>(std::max(mark.line, 0)), starts_.size() - 1);
        return text_.substr(
            std::min(starts_[line] + static_cast<std::size_t>(std::max(mark.column, 0)), text_.size()));
    }
    /// Place of the first tab in the line's indentation, if there is one.
    std::optional<Place> tab_in_indentation(int line) const {
        if (line < 0 || static_cast<std::size_t>(line) >= starts_.size()) return std::nullopt;
        const std::string_view rest = text_.substr(starts_[static_cast<std::size_t>(line)]);
        const std::string_view indentation = rest.substr(0, rest.find_first_not_of(" \t"));
        const std::size_t tab = indentation.find('\t');
        if (tab == std::string_view::npos) return std::nullopt;
        return place(line, static_cast<int>(tab));
    }
    Place place_of_byte(std::size_t byte) const {
        const auto after = std::upper_bound(starts_.begin(), starts_.end(), byte);
        const auto line = static_cast<std::size_t>(after - starts_.begin()) - 1;
        return place(static_cast<int>(line), static_cast<int>(byte - starts_[line]));
    }

private:
    std::string_view text_;
    int text_index_;
    std::vector<std::size_t> starts_;  // byte of each line's first character
    // Characters in the first bytes of the line of the last place.
    mutable std::size_t counted_line_ = 0;
    mutable std::size_t counted_bytes_ = 0;
    mutable std::size_t characters_ = 0;
};

/// Length of the well-formed UTF-8 sequence at `text[i]` (Unicode 15, table 3-7), 0 where there is none.
std::size_t utf8_length(std::string_view text, std::size_t i) {
    const auto byte = [&](std::size_t k) {
        return i + k < text.size() ? static_cast<unsigned char>(text[i + k]) : 0U;
    };
    const auto follows = [&](std::size_t k) { return (byte(k) & 0xC0U) == 0x80U; };
    const unsigned first = byte(0);
    if (first < 0x80) return 1;
    if (first >= 0xC2 && first <= 0xDF) return follows(1) ? 2 : 0;
    if (first >= 0xE0 && first <= 0xEF) {
        const bool overlong = first == 0xE0 && byte(1) < 0xA0;
        const bool surrogate = first == 0xED && byte(1) > 0x9F;
        return follows(1) && follows(2) && !overlong && !surrogate ? 3 : 0;
    }
    if (first >= 0xF0 && first <= 0xF4) {
        const bool overlong = first == 0xF0 && byte(1) < 0x90;
        const bool beyond = first == 0xF4 && byte(1) > 0x8F;
        return follows(1) && follows(2) && follows(3) && !overlong && !beyond ? 4 : 0;
    }
    return 0;
}

std::optional<YamlFault> check_characters(std::string_view text, const LineTable& lines) {
    for (std::size_t i = 0; i < text.size();) {
        const auto c = static_cast<unsigned char>(text[i]);
        if (c == 0)
            return YamlFault{lines.place_of_byte(i), "", "the text holds a NUL byte; is this a YAML file?"};
        if (c < 0x20 && c != '\t' && c != '\n' && c != '\r')
            return YamlFault{lines.place_of_byte(i), "",
                             "control character " + std::to_string(c) + " in the text; remove it"};
        const std::size_t length = utf8_length(text, i);
        if (length == 0)
            return YamlFault{lines.place_of_byte(i), "",
                             "not valid UTF-8; save the file in the encoding UTF-8"};
        i += length;
    }
    return std::nullopt;
}

/// What yaml-cpp means, in words that help.
std::string clear_text(const std::string& message) {
    struct Translation {
        std::string_view from;
        std::string_view to;
    };
    static const std::array kTranslations{
        Translation{YAML::ErrorMsg::END_OF_MAP_FLOW, "'}' is missing, or a ',' before this"},
        Translation{YAML::ErrorMsg::END_OF_SEQ_FLOW, "']' is missing, or a ',' before this"},
        Translation{YAML::ErrorMsg::END_OF_MAP, "this does not fit the indentation of the keys above"},
        Translation{YAML::ErrorMsg::END_OF_SEQ, "this does not fit the indentation of the list above"},
        Translation{YAML::ErrorMsg::TAB_IN_INDENTATION,
                    "a tab in the indentation; YAML is indented by spaces"},
        Translation{YAML::ErrorMsg::MAP_VALUE,
                    "':' is not expected here; check the indentation, or put the value in quotes"},
        Translation{YAML::ErrorMsg::MAP_KEY, "a key is not expected here; check the indentation"},
        Translation{YAML::ErrorMsg::BLOCK_ENTRY, "'-' is not expected here; check the indentation"},
        Translation{YAML::ErrorMsg::FLOW_END, "a closing bracket without its opening one"},
        Translation{YAML::ErrorMsg::EOF_IN_SCALAR, "the closing quote is missing"},
        Translation{YAML::ErrorMsg::DOC_IN_SCALAR, "the closing quote is missing before '---' or '...'"},
        Translation{YAML::ErrorMsg::UNKNOWN_TOKEN,
                    "this character cannot start a value; put the value in quotes"},
        Translation{YAML::ErrorMsg::UNKNOWN_ANCHOR, "alias of an anchor ('&name') that is not defined above"},
    };
    for (const Translation& t : kTranslations)
        if (message == t.from) return std::string(t.to);
    return "not YAML: " + clipped(message);
}

/// Whether `text` starts with a quoted scalar (after its anchor or tag) that no quote closes. yaml-cpp takes
/// the end of the file for the end of such a scalar.
bool is_unclosed_quote(std::string_view text) {
    while (!text.empty() && (text[0] == '&' || text[0] == '!')) {
        text.remove_prefix(std::min(text.find_first_of(" \t\r\n"), text.size()));
        text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
    }
    if (text.empty() || (text[0] != '"' && text[0] != '\'')) return false;
    const char quote = text[0];
    for (std::size_t i = 1; i < text.size(); ++i) {
        const bool doubled = quote == '\'' && text.substr(i, 2) == "''";
        if ((quote == '"' && text[i] == '\\') || doubled)
            ++i;
        else if (text[i] == quote)
            return false;
    }
    return true;
}

/// Builds the tree from the parser's events.
class TreeBuilder final : public YAML::EventHandler {
public:
    TreeBuilder(const LineTable& lines, YamlDocument& document) : lines_(lines), document_(document) {}

    void OnDocumentStart(const YAML::Mark& mark) override {
        if (std::exchange(has_document_, true))
            throw FatalFault{{lines_.place(mark), "", "a second document starts here; a file holds one"}};
    }
    void OnDocumentEnd() override {}

    void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
        LocatedNode node = start(mark, "", LocatedNode::Kind::empty);
        // The mark is that of the next token, often lines below: the key, or the list, is where to look.
        if (!open_.empty()) node.place = open_.back().key ? open_.back().key_place : open_.back().node.place;
        finish(std::move(node), anchor);
    }

    void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  const std::string& value) override {
        LocatedNode node = start(mark, tag, LocatedNode::Kind::scalar);
        if (tag != "?" && is_unclosed_quote(lines_.text_from(mark)))
            throw FatalFault{{node.place, path(), "the closing quote is missing"}};
        node.scalar = value;
        finish(std::move(node), anchor);
    }

    void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
        const auto found = anchors_.find(anchor);
        if (found == anchors_.end())
            throw FatalFault{
                {lines_.place(mark), path(), "this alias stands inside the value that it repeats"}};
        count(found->second.size, mark);
        attach(LocatedNode(found->second.node));
        if (!open_.empty()) open_.back().size += found->second.size;
    }

    void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                         YAML::EmitterStyle::value /*style*/) override {
        open(start(mark, tag, LocatedNode::Kind::sequence), anchor, mark);
    }
    void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                    YAML::EmitterStyle::value /*style*/) override {
        open(start(mark, tag, LocatedNode::Kind::map), anchor, mark);
    }
    void OnSequenceEnd() override { close(); }
    void OnMapEnd() override { close(); }

private:
    struct Open {
        LocatedNode node;
        YAML::anchor_t anchor = 0;
        std::size_t size = 1;            // nodes in it
        std::optional<std::string> key;  // read, its value not yet
        Place key_place;
        bool drop = false;  // the value of this key has no place in the tree
        std::set<std::string, std::less<>> keys;
    };
    struct Anchored {
        LocatedNode node;
        std::size_t size;
    };

    LocatedNode start(const YAML::Mark& mark, const std::string& tag, LocatedNode::Kind kind) {
        count(1, mark);
        LocatedNode node;
        node.kind = kind;
        node.place = node.key_place = lines_.place(mark);
        if (!tag.empty() && tag != "?" && tag != "!")
            fault(node.place, path(),
                  "tags such as " + in_quotes(clipped(tag)) + " are not used; write the value alone");
        return node;
    }

    void open(LocatedNode node, YAML::anchor_t anchor, const YAML::Mark& mark) {
        if (open_.size() >= kMaxDepth)
            throw FatalFault{
                {lines_.place(mark), path(), "nested deeper than " + std::to_string(kMaxDepth) + " levels"}};
        open_.emplace_back();
        open_.back().node = std::move(node);
        open_.back().anchor = anchor;
    }

    void close() {
        Open done = std::move(open_.back());
        open_.pop_back();
        if (!open_.empty()) open_.back().size += done.size;
        if (done.anchor != 0) anchors_[done.anchor] = {done.node, done.size};
        attach(std::move(done.node));
    }

    void finish(LocatedNode node, YAML::anchor_t anchor) {
        if (anchor != 0) anchors_[anchor] = {node, 1};
        if (!open_.empty()) ++open_.back().size;
        attach(std::move(node));
    }

    void attach(LocatedNode node) {
        if (open_.empty()) {
            document_.root = std::move(node);
            return;
        }
        Open& parent = open_.back();
        if (parent.node.kind == LocatedNode::Kind::sequence) {
            parent.node.items.push_back(std::move(node));
        } else if (!parent.key) {
            take_key(parent, node);
        } else {
            node.key_place = parent.key_place;
            if (node.kind == LocatedNode::Kind::empty) node.place = parent.key_place;
            if (!parent.drop) parent.node.entries.push_back({std::move(*parent.key), std::move(node)});
            parent.key.reset();
        }
    }

    void take_key(Open& parent, const LocatedNode& node) {
        const std::string parent_path = path();
        parent.key = node.scalar;
        parent.key_place = node.place;
        parent.drop = true;
        if (node.kind == LocatedNode::Kind::empty) {
            fault(node.place, parent_path, "a key is missing before ':'");
        } else if (node.kind != LocatedNode::Kind::scalar) {
            fault(node.place, parent_path, "a key must be a single word, not a list or map");
        } else if (node.scalar == "<<") {
            fault(node.place, parent_path, "merge keys ('<<') are not supported; write the keys out");
        } else if (!parent.keys.insert(node.scalar).second) {
            fault(node.place, path(),
                  "this key stands here twice; it was first given in line " +
                      std::to_string(std::as_const(parent.node).find(node.scalar)->key_place.line));
        } else {
            parent.drop = false;
        }
    }

    /// The key path of the value that is being read.
    std::string path() const {
        std::string text;
        for (const Open& level : open_) {
            if (level.node.kind == LocatedNode::Kind::sequence)
                text += '[' + std::to_string(level.node.items.size()) + ']';
            else if (level.key)
                text += (text.empty() ? "" : ".") + *level.key;
        }
        return text;
    }

    void count(std::size_t nodes, const YAML::Mark& mark) {
        nodes_ += nodes;
        if (nodes_ > kMaxNodes)
            throw FatalFault{{lines_.place(mark), path(),
                              "more than " + std::to_string(kMaxNodes) +
                                  " values, aliases unfolded; write bulk data to a file of its own"}};
    }

    void fault(Place place, std::string key_path, std::string message) {
        document_.faults.push_back({place, std::move(key_path), std::move(message)});
    }

    const LineTable& lines_;
    YamlDocument& document_;
    std::vector<Open> open_;
    std::map<YAML::anchor_t, Anchored>
        anchors_;  // of finished values only, so an alias of its own parent is absent
    std::size_t nodes_ = 0;
    bool has_document_ = false;
};

}  // namespace

YamlDocument read_yaml(std::string_view text, int text_index) {
    YamlDocument document;
    document.root.place = document.root.key_place = {text_index, 1, 1};
    if (text.size() > kMaxYamlBytes) {
        document.faults.push_back({document.root.place, "",
                                   "the text is larger than " + std::to_string(kMaxYamlBytes >> 20U) +
                                       " MiB; write bulk data to a file of its own"});
        document.broken_off = true;
        return document;
    }
    if (text.substr(0, 3) == "\xEF\xBB\xBF") text.remove_prefix(3);  // a byte order mark

    const LineTable lines(text, text_index);
    if (auto fault = check_characters(text, lines)) {
        document.faults.push_back(std::move(*fault));
        document.broken_off = true;
        return document;
    }
    TreeBuilder builder(lines, document);
    document.broken_off = true;
    try {
        std::istringstream stream{std::string(text)};
        YAML::Parser parser(stream);
        while (parser.HandleNextDocument(builder)) {
        }
        document.broken_off = false;
    } catch (const FatalFault& fatal) {
        document.faults.push_back(fatal.fault);
    } catch (const YAML::Exception& error) {
        const auto tab = lines.tab_in_indentation(error.mark.line);
        Place place = tab ? *tab : lines.place(error.mark);
        // A bracket that is still open at the end of the text is found there, with a mark at the line's
        // begin.
        const bool open_bracket =
            error.msg == YAML::ErrorMsg::END_OF_SEQ_FLOW || error.msg == YAML::ErrorMsg::END_OF_MAP_FLOW;
        if (const Place end = lines.end(); open_bracket && place.line >= end.line && place.column == 1)
            place = end;
        document.faults.push_back(
            {place, "", clear_text(tab ? YAML::ErrorMsg::TAB_IN_INDENTATION : error.msg)});
    } catch (const std::exception& error) {
        document.faults.push_back({document.root.place, "", "not YAML: " + clipped(error.what())});
    }
    return document;
}

}  // namespace dapple::input
