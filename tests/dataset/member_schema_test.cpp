#include "dataset/member_schema.h"

#include "catch.h"

namespace ensonify {
namespace {

enum class Wheel { round, square };
const char* name_of(Wheel wheel) { return wheel == Wheel::round ? "round" : "square"; }

struct Cart {
  Wheel wheel = Wheel::round;
  double radius_m = 1;
  int corners = 4, wheels = 2;
  std::uint32_t seats = 2;
  double load_kg = 0;
  std::vector<std::string> goods = {};
  std::optional<Vec3> place = {};
};

template <class Io, class Value>
void cart_members(Io& io, Value& cart) {
  io.word("wheel", cart.wheel, Wheel::square);
  if (cart.wheel == Wheel::round) {
    io.number({"radius_m", "Radius", "Of the wheel"}, cart.radius_m, kLength);
  } else {
    io("corners", cart.corners);
  }
  io("seats", cart.seats);
  io.null_if(cart.load_kg == 0, "load_kg", cart.load_kg);
  io.optional("place", cart.place, [](Io& at, auto& place) { at("xyz", place); });
  io.said("made_of", "wood");
  io.together_if(!cart.goods.empty(), [&](Io& load) { load("goods", cart.goods); });
  io("wheels", cart.wheels);
}

Json cart_schema() {
  Cart cart;
  return MemberSchema::object_of([&](MemberSchema& io) { cart_members(io, cart); });
}

Json json_from(const char* text) { return *parse_json(text); }

}  // namespace

// Protects the schema of files: each word has the members that the writer writes with it.
TEST_CASE("an object whose members depend on a word is one of its variants") {
  const Json variants = cart_schema().at("oneOf");
  REQUIRE(variants.size() == 2);
  CHECK(variants[0].at("required") ==
        json_from(R"(["wheel", "radius_m", "seats", "load_kg", "place", "made_of", "wheels"])"));
  CHECK(variants[1].at("required") ==
        json_from(R"(["wheel", "corners", "seats", "load_kg", "place", "made_of", "wheels"])"));
  CHECK(variants[1].at("properties").at("wheel") == json_from(R"({"const": "square"})"));
  CHECK_FALSE(variants[1].at("properties").contains("radius_m"));
  CHECK(variants[0].at("additionalProperties") == false);
}

// Protects types, null and texts; kLength has a largest value, which is no rule of files.
TEST_CASE("a member has the type of its value and the text of its key") {
  const Json members = cart_schema().at("oneOf")[0].at("properties");
  CHECK(members.at("radius_m") == json_from(R"({"type": "number", "exclusiveMinimum": 0,
                                                "title": "Radius", "description": "Of the wheel"})"));
  CHECK(members.at("seats") == json_from(R"({"type": "integer", "minimum": 0})"));
  CHECK(members.at("load_kg") == json_from(R"({"anyOf": [{"type": "number"}, {"type": "null"}]})"));
  CHECK(members.at("goods") == json_from(R"({"type": "array", "items": {"type": "string"}})"));
  CHECK(members.at("made_of") == json_from(R"({"type": "string"})"));
  CHECK(
      members.at("place").at("anyOf")[0].at("properties").at("xyz") ==
      json_from(R"({"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3})"));
}

// Protects both ways: what the list describes is what the same list writes and reads.
TEST_CASE("the same list writes and reads") {
  const Cart cart{.wheel = Wheel::square, .corners = 5, .goods = {"hay"}, .place = Vec3{1, 2, 3}};
  Json json = Json::object();
  MemberWriter writer(json);
  cart_members(writer, cart);
  CHECK(json == json_from(R"({"wheel": "square", "corners": 5, "seats": 2, "load_kg": null,
                              "place": {"xyz": [1.0, 2.0, 3.0]}, "made_of": "wood",
                              "goods": ["hay"], "wheels": 2})"));
  Cart again;
  std::string fault;
  MemberReader reader(json, fault);
  cart_members(reader, again);
  CHECK(fault == "");
  CHECK((again.wheel == Wheel::square && again.corners == 5 && again.goods == cart.goods));
  CHECK(again.place == cart.place);
}

namespace {

// A struct of a version that has gained a number and a part.
struct Grown {
  double old = 1;
  std::optional<double> number = {};
  std::optional<double> part = {};
};

template <class Io, class Value>
void grown_keys(Io& io, Value& grown) {
  io.number({"old", "Old", "."}, grown.old, kLength);
  io.number({"number", "Number", "."}, grown.number, kLength, written_if(grown.number.has_value()));
  io.part(
      {"part", "Part", "."}, grown.part,
      [](auto& part, auto& value) {
        part.number({"value", "Value", "."}, value, kLength);
      },
      written_if(grown.part.has_value()));
}

Json grown_json(const Grown& grown) {
  Json json = Json::object();
  MemberWriter writer(json);
  grown_keys(writer, grown);
  return json;
}

}  // namespace

// Protects the bytes and the validity of older data sets when scenarios and sequence.json gain a
// key: without it the file is what it was, the reader takes either, and the schema demands neither.
TEST_CASE("a new key that is written only where it is given changes no older file") {
  CHECK(grown_json({}) == Json({{"old", 1.0}}));
  const Json whole = {{"old", 1.0}, {"number", 2.0}, {"part", {{"value", 3.0}}}};
  CHECK(grown_json({1, 2, 3}) == whole);
  for (const Json& json : {Json({{"old", 1.0}}), whole}) {
    std::string fault;
    Grown read;
    MemberReader reader(json, fault);
    grown_keys(reader, read);
    CHECK(fault.empty());
    CHECK(grown_json(read) == json);
  }
  const Json schema = MemberSchema::object_of([](MemberSchema& io) {
    Grown grown;
    grown_keys(io, grown);
  });
  CHECK(schema["required"] == Json({"old"}));
  CHECK(schema["properties"]["number"]["title"] == "Number");
  CHECK(schema["properties"].contains("part"));
}

}  // namespace ensonify
