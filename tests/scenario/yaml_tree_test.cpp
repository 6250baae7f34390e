#include "scenario/yaml_tree.h"

#include "catch.h"
#include "results.h"
#include "scenario/yaml_text.h"

namespace ensonify {
namespace {

struct Reading {
  std::optional<Node> root;
  std::string message;  // of the faults; empty: none
};

Reading tree_of(const std::string& text) {
  Faults faults;
  const int source = add_source(faults, "f");
  Reading reading;
  reading.root = read_yaml_map(text, source, faults);
  if (!faults.empty()) reading.message = to_error(faults).message;
  return reading;
}

bool begins_with(const std::string& text, const std::string& begin) {
  return text.compare(0, begin.size(), begin) == 0;
}

void check_fault(const std::string& text, const std::string& begin) {
  const Reading reading = tree_of(text);
  INFO(text.substr(0, 100) << "\n" << reading.message);
  CHECK(begins_with(reading.message, begin));
}

// Protects every message that points into a file: places count from 1, and in characters, not in
// the bytes that yaml-cpp counts.
TEST_CASE("nodes and keys remember their places") {
  const Reading reading = tree_of("a: 1\nµ: {b: [x, \"y\"], ü: 2}\n");
  REQUIRE(reading.root);
  CHECK(reading.message.empty());
  const Node& map = *find(*reading.root, "µ");
  CHECK(reading.root->keys[1].place.line == 2);
  CHECK(reading.root->keys[1].place.column == 1);
  CHECK(map.place.column == 4);
  const Node& list = *find(map, "b");
  CHECK(list.items[1].place.line == 2);
  CHECK(list.items[1].place.column == 12);
  CHECK(map.keys[1].place.column == 18);
  CHECK(find(map, "ü")->place.column == 21);
}

// Protects the difference between 5 and "5", on which the type checks rest.
TEST_CASE("quoted and block scalars are known as text") {
  const Reading reading = tree_of("a: 5\nb: \"5\"\nc: '5'\nd: |\n  5\n\"e\": 1\n");
  REQUIRE(reading.root);
  CHECK_FALSE(find(*reading.root, "a")->quoted);
  for (const char* key : {"b", "c", "d"}) CHECK(find(*reading.root, key)->quoted);
  CHECK(reading.root->keys[4].quoted);
  CHECK_FALSE(reading.root->keys[0].quoted);
}

// Protects the place of an empty value, which yaml-cpp reports as that of the next token.
TEST_CASE("an empty value is placed at its key or dash") {
  const Reading reading =
      tree_of("a:\n\nb:\n  - 1\n  -   # nothing\n  - 2\nc: ~\nd: [1, , null]\n");
  REQUIRE(reading.root);
  CHECK(find(*reading.root, "a")->place.line == 1);
  CHECK(find(*reading.root, "a")->place.column == 1);
  CHECK(find(*reading.root, "b")->items[1].kind == NodeKind::null);
  CHECK(find(*reading.root, "c")->place.column == 4);
  const Node& list = *find(*reading.root, "d");
  REQUIRE(list.items.size() == 3);
  CHECK(list.items[1].place.line == 8);
  CHECK(list.items[1].place.column == 6);
  CHECK(list.items[2].place.column == 10);
  const Reading dash = tree_of("b:\n  - 1\n  -\n  - 2\n");
  REQUIRE(dash.root);
  CHECK(find(*dash.root, "b")->items[1].place.line == 3);
  CHECK(find(*dash.root, "b")->items[1].place.column == 3);
}

// Protects against yaml-cpp's silent choice of one of two equal keys, at any depth.
TEST_CASE("keys given twice are faults with both places") {
  check_fault("a: 1\nb: 2\na: 3\n", "f:3:1: a: the key is given twice, first at 1:1");
  check_fault("a: {b: [{c: 1, d: 2, c: 3}]}\n",
              "f:1:22: a.b.0.c: the key is given twice, first at 1:10");
  check_fault("a: 1\n\"a\": 2\n", "f:2:1: a: the key is given twice");
  const Reading reading = tree_of("a: 1\na: 2\nb: 3\n");
  REQUIRE(reading.root);
  CHECK(find(*reading.root, "a")->text == "1");
  CHECK(reading.root->keys.size() == 2);
}

// Protects against files that are no single map.
TEST_CASE("only one document with a map at the top is read") {
  check_fault("", "f:1:1: the text is empty");
  check_fault("# only a remark\n\n", "f:1:1: the text is empty");
  check_fault("a: 1\n---\nb: 2\n", "f:2:1: a second document");
  check_fault("{a: 1} {b: 2}\n", "f:1:8: a second document");
  check_fault("- a\n", "f:1:1: the top level is not a map");
  check_fault("\"a\" \"b\"\n", "f:1:1: the top level is not a map");
  check_fault("\n\n5\n", "f:3:1: the top level is not a map");
  check_fault("~\n", "f:1:1: the top level is not a map");
  // yaml-cpp hands out empty documents for this one without end.
  check_fault(",\n", "f:1:1: the top level is not a map");
  CHECK(tree_of("%YAML 1.2\n---\na: 1\n...\n").message.empty());
  CHECK(tree_of("\xEF\xBB\xBF"
                "a: 1\n")
            .message.empty());
}

// Protects the place of a syntax error; an open quote is one that yaml-cpp lets pass.
TEST_CASE("broken YAML is a fault with a place") {
  check_fault("a: 1\nb: c: d\n", "f:2:5: not valid YAML");
  check_fault("a: 1\n]\n", "f:2:1: not valid YAML");
  check_fault("a: [1, 2\n", "f:2:1: not valid YAML");
  check_fault("a: *b\n", "f:1:4: not valid YAML");
  check_fault("a: \"x\nb: 1\n", "f:1:4: not valid YAML: the quote that opens here");
  check_fault("a: &q 'it''s\nb: 1\n", "f:1:4: not valid YAML: the quote that opens here");
  CHECK(tree_of("a: &q 'it''s'\nb: \"x\\\"y\"\n").message.empty());
  CHECK(tree_of("a: 'x'  # don't\n").message.empty());
}

// Protects against constructs that would be read in a way the user does not expect.
TEST_CASE("tags and keys that are no text are refused") {
  check_fault("a: !!int 1\n", "f:1:4: a: YAML tags");
  check_fault("a: {b: !x {c: 1}}\n", "f:1:8: a.b: YAML tags");
  check_fault("? [a]\n: 1\n", "f:1:3: ?: a key is not text");
  check_fault("a: {~: 1}\n", "f:1:5: a.?: a key is not text");
}

// Protects against bytes that end yaml-cpp's input early (0x04), turn into other text or hide.
TEST_CASE("text that is no clean UTF-8 is refused where it begins") {
  using namespace std::string_literals;
  check_fault("a: 1\nb: x\0y\n"s, "f:2:5: a NUL byte");
  check_fault("a: caf\xE9\n", "f:1:7: the text is not UTF-8");
  check_fault("a: \"no\\_break\"\n", "f:1:4: this text has an escape that is not understood");
  check_fault("a: \"x\x04\"\nb: 1\n", "f:1:6: a control character");
  check_fault("a: µ\x7F\n", "f:1:5: a control character");
  check_fault("a: 1\rb: 2\r", "f:1:5: a carriage return");
  check_fault(
      "\xFF\xFE"
      "a\0:\0"s,
      "f:1:4: a NUL byte");
  CHECK(tree_of("a: 1\r\nb: 2\r\n").message.empty());
  check_fault(std::string(kMaxYamlBytes + 1, '#'), "f:1:1: larger than 16 MiB");
}

// Protects the use of anchors for what they are good for.
TEST_CASE("anchors and aliases are expanded") {
  const Reading reading = tree_of("a: &p {x: 1, y: [2, 3]}\nb: *p\nc: [*p, *p]\n");
  REQUIRE(reading.root);
  CHECK(reading.message.empty());
  CHECK(find(*find(*reading.root, "b"), "x")->text == "1");
  CHECK(find(find(*reading.root, "c")->items[1], "y")->items[1].text == "3");
}

std::string repeated(const std::string& text, std::size_t count) {
  std::string result;
  for (std::size_t i = 0; i < count; ++i) result += text;
  return result;
}

// Protects the process: each of these would use up stack, memory or hours (ctest ends it then).
TEST_CASE("hostile text ends in a fault") {
  std::string laughs = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 12; ++i) {
    const std::string alias = std::string("*a").append(std::to_string(i - 1));
    const std::string name = std::string("a").append(std::to_string(i));
    laughs += name + ": &" + name + " [" + repeated(alias + ", ", 9) + alias + "]\n";
  }
  std::string chain = "a0: &a0 " + std::string(40, '[') + std::string(40, ']') + "\n";
  chain += "a1: &a1 " + std::string(40, '[') + "*a0" + std::string(40, ']') + "\n";
  const struct {
    std::string text, expected;
  } cases[] = {
      {std::string(1'000'000, '['), "nested more than 64 levels deep"},
      {std::string(1'000'000, '{'), "nested more than 64 levels deep"},
      {repeated("{a: ", 100'000), "nested more than 64 levels deep"},
      {repeated("- ", 200'000), "the top level is not a map"},
      {"a:\n" + repeated("? ", 200'000), "nested more than 64 levels deep"},
      {laughs, "anchors and aliases stand for more than"},
      {chain, "nested more than 64 levels deep"},
      {"a: &x [1, *x]\n", "refers to a value that contains it"},
      {"a: &x {b: {c: *x}}\n", "refers to a value that contains it"},
      {"a: [" + std::string(200'000, ',') + "}", "not valid YAML"},
      {std::string(200'000, ',') + "a: 1", "the top level is not a map"},
  };
  for (const auto& c : cases) {
    const Reading reading = tree_of(c.text);
    INFO(c.text.substr(0, 60) << "\n" << reading.message);
    CHECK_FALSE(reading.root);
    CHECK(contains(reading.message, c.expected));
  }
}

// Protects the limit on values as such, which keeps a file of 16 MiB from taking gigabytes.
TEST_CASE("more values than any scenario holds are refused", "[figure]") {
  check_fault("a: [" + repeated("1,", ReadLimits().values + 1) + "]\n", "f:1:");
  CHECK(tree_of("a: [" + repeated("1,", 1000) + "]\n").message.empty());
}

// Protects beginners from the parser's own words: what stops most of them is a tab or a column.
TEST_CASE("wrong indentation is named as such") {
  check_fault("a:\n\tb: 1\n", "f:2:");
  CHECK(contains(tree_of("a:\n\tb: 1\n").message, "indented with a tab; expected spaces"));
  const auto deeper = tree_of("a:\n  b: 1\n   c: 2\n").message;
  CHECK(contains(deeper,
                 "indented by 3 spaces, but the key above, indented by 2, already has a value"));
  const auto between = tree_of("# first\na:\n  - b: 1\n    c: 2\n\n   d: 3\n").message;
  CHECK(contains(between, "indented by 3 spaces; expected an indentation of 4, 2, 0"));
  CHECK(tree_of("a:\n  b:\n    c: 1\n  d: 2\ne: 3\n").message.empty());
  CHECK_FALSE(contains(tree_of("a: {b: 1\n").message, "indented"));
}

}  // namespace
}  // namespace ensonify
