#include "formats/json.h"

#include "catch.h"
#include "formats/json.h"
#include "results.h"

using namespace ensonify;

// Protects coco.json, whose masks are passed on as annotations.jsonl has them.

TEST_CASE("JSON is taken apart into the texts that it was put together from") {
  const Json json = {{"counts", "a\\b\"]}{[,:\\"},
                     {"box", Json::array({1, 2.5, -3e-7})},
                     {"none", nullptr},
                     {"nested", {{"list", Json::array({Json::array(), Json::object(), "]"})}}},
                     {"empty", Json::array()}};
  for (const std::string& text : {json_line(json), json_text(json)}) {
    const auto members = value_of(json_members(text));
    REQUIRE(members.all.size() == json.size());
    for (const auto& [key, value] : json.items()) {
      CHECK(parse_json(members.at(key)) == value);
    }
    CHECK(members.at("box") == json_members(text)->at("box"));
    const auto list = value_of(json_elements(json_members(members.at("nested"))->at("list")));
    CHECK(list == std::vector<std::string_view>{"[]", "{}", "\"]\""});
    CHECK(json_elements(members.at("empty"))->empty());
  }
  CHECK(json_members("{}")->all.empty());
  CHECK(json_members("{\"a\": 1}")->at("b").empty());
}

TEST_CASE("text that is cut off or goes on is no JSON value") {
  const std::string whole = R"({"a": [1, {"b": "x\"y"}], "c": "z"})";
  REQUIRE(json_members(whole));
  for (std::size_t length = 0; length < whole.size(); ++length) {
    INFO(whole.substr(0, length));
    CHECK(!json_members(whole.substr(0, length)));
  }
  for (const char* wrong :
       {"[1]", "{1: 2}", "{\"a\" 1}", "{\"a\": 1} x", "{\"a\": 1,}", "{\"a\":}"}) {
    INFO(wrong);
    CHECK(!json_members(wrong));
  }
  for (const char* wrong : {"{}", "[1,]", "[,1]", "[1 2]", "[1] 2", "[\"a]", "[1"}) {
    INFO(wrong);
    CHECK(!json_elements(wrong));
  }
}
