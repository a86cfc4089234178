#include "input/yaml_reader.h"

#include <gtest/gtest.h>

#include <string>

namespace dapple::input {
namespace {

std::string at(const Place& place) {
    return std::to_string(place.line) + ":" + std::to_string(place.column);
}

TEST(YamlReader, KeepsPlacesOfKeysAndValues) {
    const YamlDocument document = read_yaml("a: 1\nb:\n  - x\n  - {c: 'two words'}\nd: {}\n", 3);
    ASSERT_TRUE(document.faults.empty());
    const LocatedNode& root = document.root;
    ASSERT_EQ(root.kind, LocatedNode::Kind::map);
    EXPECT_EQ(root.place.text, 3);
    EXPECT_EQ(root.find("a")->scalar, "1");
    EXPECT_EQ(at(root.find("a")->key_place), "1:1");
    EXPECT_EQ(at(root.find("a")->place), "1:4");
    const LocatedNode& list = *root.find("b");
    EXPECT_EQ(list.kind, LocatedNode::Kind::sequence);
    EXPECT_EQ(at(list.key_place), "2:1");
    EXPECT_EQ(at(list.items[0].place), "3:5");
    EXPECT_EQ(list.items[1].find("c")->scalar, "two words");
    EXPECT_EQ(at(list.items[1].find("c")->place), "4:9");
    EXPECT_EQ(root.find("d")->kind, LocatedNode::Kind::map);
    EXPECT_EQ(root.find("e"), nullptr);
}

TEST(YamlReader, EmptyValuesStandAtTheirKey) {
    const YamlDocument document = read_yaml("a:\n\n\nb: ~\nc: [1, ]\n");
    EXPECT_EQ(document.root.find("a")->kind, LocatedNode::Kind::empty);
    EXPECT_EQ(at(document.root.find("a")->place), "1:1");
    EXPECT_EQ(document.root.find("b")->kind, LocatedNode::Kind::empty);
    EXPECT_EQ(document.root.find("c")->items.size(), 1U);
}

TEST(YamlReader, ColumnsCountCharacters) {
    const YamlDocument document = read_yaml("{ä: ☀, b: 2}\n");
    EXPECT_EQ(at(document.root.find("b")->place), "1:11");
}

TEST(YamlReader, AliasesBecomeCopies) {
    const YamlDocument document = read_yaml("a: &x {b: [1, 2]}\nc: *x\nd: &y word\ne: *y\n");
    ASSERT_TRUE(document.faults.empty());
    EXPECT_EQ(document.root.find("c")->find("b")->items[1].scalar, "2");
    EXPECT_EQ(at(document.root.find("c")->key_place), "2:1");
    EXPECT_EQ(at(document.root.find("c")->place), "1:4");  // where the value is written
    EXPECT_EQ(document.root.find("e")->scalar, "word");
}

TEST(YamlReader, GoesOnAfterFaultsOfKeys) {
    const YamlDocument document = read_yaml("a: 1\na: 2\n<<: {b: 3}\n[4]: 5\nc: !x 6\nd: 7\n");
    ASSERT_EQ(document.faults.size(), 4U);
    EXPECT_EQ(document.faults[0].key_path, "a");
    EXPECT_EQ(at(document.faults[0].place), "2:1");
    EXPECT_FALSE(document.broken_off);
    EXPECT_EQ(document.root.find("a")->scalar, "1");  // the first counts, if only for further faults
    EXPECT_EQ(document.root.find("b"), nullptr);
    EXPECT_EQ(document.root.find("d")->scalar, "7");
}

TEST(YamlReader, TellsWhereItBrokeOff) {
    const YamlDocument document = read_yaml("a: 1\nb: 'open\n");
    EXPECT_TRUE(document.broken_off);
    ASSERT_EQ(document.faults.size(), 1U);
    EXPECT_EQ(document.faults[0].message, "the closing quote is missing");
    EXPECT_EQ(at(document.faults[0].place), "2:4");
}

TEST(YamlReader, KnowsClosedQuotes) {
    for (const char* text : {"a: 'it''s'", "a: \"say \\\"so\\\"\"", "a: &x 'b'", "a: \"b\n  c\"",
                             "a: |\n  'b\n", "a: it's", "'a b': c", "a: ''", "a: \"\\\\\""})
        EXPECT_TRUE(read_yaml(text).faults.empty()) << text;
}

TEST(YamlReader, AcceptsOneDocumentWithMarkers) {
    EXPECT_TRUE(read_yaml("%YAML 1.2\n---\na: 1\n...\n").faults.empty());
    EXPECT_EQ(read_yaml("a: 1\n---\nb: 2\n").faults.size(), 1U);
}

TEST(YamlReader, EmptyTextsAreEmpty) {
    for (const char* text : {"", "\n", "# only a comment\n", "---\n"}) {
        const YamlDocument document = read_yaml(text);
        EXPECT_TRUE(document.faults.empty()) << text;
        EXPECT_EQ(document.root.kind, LocatedNode::Kind::empty) << text;
    }
}

}  // namespace
}  // namespace dapple::input
