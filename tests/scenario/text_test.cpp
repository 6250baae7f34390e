#include "scenario/text.h"
#include "catch.h"

namespace ensonify {
namespace {

// Protects the strictness of the contract: a number that readers disagree about must not be taken
// for a number, nor for text.
TEST_CASE("plain scalars are told apart as any YAML reader might take them") {
  for (const char* text : {"0", "-0", "+1", "10", "0.5", ".5", "5.", "0e3", "1e-3", "-1.5E+10"}) {
    INFO(text);
    CHECK(classify_plain(text) == PlainKind::number);
  }
  for (const char* text : {"010", "-010", "+007", "0o17", "-0o7", "00", "00.5", "01e3"}) {
    INFO(text);
    CHECK(classify_plain(text) == PlainKind::octal_looking);
  }
  for (const char* text :
       {"0x1F", "0b101", "1_000", "1:30", ".inf", "-.INF", ".nan", "nan", "Inf"}) {
    INFO(text);
    CHECK(classify_plain(text) == PlainKind::other_number);
  }
  for (const char* text : {"yes", "No", "ON", "off"}) {
    INFO(text);
    CHECK(classify_plain(text) == PlainKind::switch_word);
  }
  for (const char* text : {"true", "False"}) {
    INFO(text);
    CHECK(classify_plain(text) == PlainKind::boolean);
  }
  for (const char* text : {"steel", "e5", "1e", "-", ".", "", "1.2.3a", "0123abc", "yesterday"}) {
    INFO(text);
    CHECK(classify_plain(text) == PlainKind::text);
  }
}

// Protects the messages: a suggestion that is far off misleads more than none.
TEST_CASE("the nearest word is suggested only where it is near") {
  const std::vector<std::string_view> words = {"range_min_m", "range_max_m", "pulse", "ph"};
  CHECK(nearest("range_mxa_m", words) == "range_max_m");
  CHECK(nearest("range_mn_m", words) == "range_min_m");
  CHECK(nearest("pluse", words) == "pulse");
  CHECK(nearest("Pulse", words) == "pulse");
  CHECK_FALSE(nearest("frequency", words));
  CHECK_FALSE(nearest("xy", words));
  CHECK_FALSE(nearest("", words));
}

// Protects the check for UTF-8 against the classical holes: overlong forms, surrogates, beyond the
// last plane, cut sequences.
TEST_CASE("malformed UTF-8 is found at its first byte") {
  CHECK_FALSE(first_invalid_utf8("a\xC2\xB5\xE2\x82\xAC\xF0\x9F\x90\x9F"));
  CHECK(first_invalid_utf8("ab\xC0\xAF") == 2u);
  CHECK(first_invalid_utf8("\xE0\x80\x80") == 0u);
  CHECK(first_invalid_utf8("a\xED\xA0\x80") == 1u);
  CHECK(first_invalid_utf8("\xF4\x90\x80\x80") == 0u);
  CHECK(first_invalid_utf8("abc\xE2\x82") == 3u);
  CHECK(first_invalid_utf8("\x80") == 0u);
}

// Protects the rule that one fault is one line, whatever a stranger's key holds.
TEST_CASE("foreign text in a message is escaped and cut") {
  CHECK(shown("a\nb") == "`a\\x0ab`");
  CHECK(one_line("\xC2\x85 \xFF \xE2\x80\xA8") == "\\xc2\\x85 \\xff \\xe2\\x80\\xa8");
  CHECK(shown(std::string(100, 'x')) == "`" + std::string(60, 'x') + "...`");
  CHECK(shown("\xC2\xB5") == "`\xC2\xB5`");
}

}  // namespace
}  // namespace ensonify
