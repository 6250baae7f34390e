// Protects the stack: what is nested deeper than anything of ours is no JSON of ours.
#include "formats/json.h"

#include <sstream>
#include <string>

#include "catch.h"

using namespace ensonify;

namespace {

std::string nested(int levels, char open, char close) {
  std::string inner = open == '[' ? "1" : "";
  std::string text;
  for (int i = 0; i < levels; ++i) text += open == '[' ? "[" : "{\"a\":";
  text += open == '[' ? inner : "1";
  return text + std::string(static_cast<std::size_t>(levels), close);
}

}  // namespace

TEST_CASE("JSON is read as deep as it may be nested") {
  for (const bool list : {true, false}) {
    const auto text = [&](int levels) {
      return list ? nested(levels, '[', ']') : nested(levels, '{', '}');
    };
    CHECK(parse_json(text(kMaxJsonDepth)).has_value());
    CHECK_FALSE(parse_json(text(kMaxJsonDepth + 1)).has_value());
    CHECK_FALSE(parse_json(text(200'000)).has_value());
    std::istringstream stream(text(200'000));
    const auto all = [](int, Json::parse_event_t, Json&) { return true; };
    CHECK(parse_shallow_with(all, stream).is_discarded());
  }
  // What follows the deep part does not bring it back.
  CHECK_FALSE(parse_json("{\"a\":" + nested(200'000, '[', ']') + ",\"b\":1}").has_value());
}

TEST_CASE("shallow JSON comes as it stands") {
  const char* text = R"({"b":[1,2.5,"x",null,true,{"c":[]}],"a":{}})";
  const auto json = parse_json(text);
  REQUIRE(json.has_value());
  CHECK(json->dump() == text);
  for (const char* broken : {"", "{", "[1,", "{\"a\":1}x", "nul"}) CHECK_FALSE(parse_json(broken));
}
