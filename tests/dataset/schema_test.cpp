#include "dataset/schema.h"

#include "catch.h"
#include "dataset/schema.h"
#include "results.h"

namespace ensonify {
namespace {

Json work() {
  return *parse_json(R"({
    "ensonify_work": 1, "name": "t", "seed": 18446744073709551615, "pings": [0, 3],
    "scenario_sha256": "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855",
    "program": {"version": "1", "commit": "c"},
    "numerics": {"backend": "cpu", "simd": "avx2", "embree_isa": "avx2"}})");
}

std::string fault(const Json& json) { return SchemaCheck("work").fault(json); }

}  // namespace

// Protects what users are told: the place as a JSON pointer, and what is wrong there.
TEST_CASE("faults against a schema name place and trouble") {
  CHECK(fault(work()) == "");
  Json json = work();
  SECTION("missing") {
    json["numerics"].erase("simd");
    CHECK(fault(json) == "#/numerics lacks the key simd");
  }
  SECTION("missing at the top") {
    json.erase("seed");
    CHECK(fault(json) == "# lacks the key seed");
  }
  SECTION("unknown") {
    json["program"]["colour"] = "red";
    CHECK(fault(json) == "#/program has the unknown key colour");
  }
  SECTION("of the wrong type") {
    json["pings"][1] = "3";
    CHECK(fault(json) == "#/pings/1 is \"3\", which has the wrong type");
  }
  SECTION("out of range") {
    json["pings"][0] = -1;
    CHECK(fault(json) == "#/pings/0 is -1; expected at least 0");
  }
  SECTION("another version") {
    json["ensonify_work"] = 2;
    CHECK(fault(json) == "#/ensonify_work is 2, which is not allowed here");
  }
  SECTION("no hash") {
    json["scenario_sha256"] = "abc";
    CHECK(fault(json) == "#/scenario_sha256 is \"abc\", which is not allowed here");
  }
  SECTION("two at once, and a key that a pointer has to escape") {
    json["a/b"] = 1;
    json.erase("name");
    const std::string told = fault(json);
    INFO(told);
    CHECK(contains(told, "# has the unknown key a/b"));
    CHECK(contains(told, "# lacks the key name"));
  }
  SECTION("no object at all") {
    CHECK(fault(Json::array()) == "# is [], which has the wrong type");
  }
}

// Protects parts that are checked one by one: the pointer is that of the whole.
TEST_CASE("a part of a schema is told with the place of its value") {
  const SchemaCheck file("dataset", "file");
  Json entry = {{"path", "a"}, {"bytes", 1}, {"sha256", work()["scenario_sha256"]}};
  CHECK(file.fault(entry, "/files/7") == "");
  entry["bytes"] = -1;
  CHECK(file.fault(entry, "/files/7") == "#/files/7/bytes is -1; expected at least 0");
}

// Protects from an object of a kind of its own: each kind of instance has its keys and no others.
TEST_CASE("instances have the keys of their kind") {
  const SchemaCheck instance("sequence", "instance");
  Json target = {{"id", 1},
                 {"name", "t"},
                 {"class_id", 1},
                 {"class", "c"},
                 {"kind", "point_target"},
                 {"target_strength_db", -40},
                 {"box", nullptr}};
  CHECK(instance.fault(target) == "");
  target["kind"] = "volume";
  const std::string told = instance.fault(target);
  CHECK(contains(told, "# has the unknown key target_strength_db"));
  target["kind"] = "fish";
  CHECK(instance.fault(target) == "#/kind is \"fish\", which is not allowed here");
}

// Protects readers of the tables: columns and types are those of tables.json.
TEST_CASE("rows are held against their table") {
  const auto table = value_of(table_schema("poses.csv"));
  CHECK(header_fault(table, "ping,time_s,x,y,z,qw,qx,qy,qz") == "");
  CHECK(header_fault(table, "ping,time,x,y,z,qw,qx,qy,qz") ==
        "does not begin with ping,time_s,x,y,z,qw,qx,qy,qz");
  CHECK(row_fault(table, "0,0.5,1,2,3,1,0,0,-1e-17") == "");
  CHECK(row_fault(table, "0,0.5,1,2,3,1,0,0") == "has 8 columns, not 9");
  CHECK(row_fault(table, "0.5,0.5,1,2,3,1,0,0,0") == "ping `0.5` is not an integer");
  CHECK(row_fault(table, "-1,0.5,1,2,3,1,0,0,0") == "ping `-1` is below 0");
  CHECK(row_fault(table, "0,0.5,1,2,3,one,0,0,0") == "qw `one` is not a number");
  CHECK(row_fault(*table_schema("index.csv"), "0,1,0,valid,000000/000001") ==
        "split `valid` is not one of train, val, test");
  CHECK_FALSE(table_schema("poses.tum"));
}

// Protects the build: what is embedded is readable, and the program's own format is its version.
TEST_CASE("every schema that verify needs is built in") {
  for (const char* name : {"annotations.schema", "coco.schema", "dataset.schema", "render.schema",
                           "rig.schema", "sequence.schema", "work.schema", "tables"}) {
    const auto json = value_of(parse_json(schema_text(name)));
    const std::string stem = std::string(name).substr(0, std::string(name).find('.'));
    CHECK(text_at(json, "$id") == "urn:ensonify:" + stem + ":1");
    CHECK(count_at(json, "ensonify_schema") == 1);
  }
  CHECK(schema_files().size() == 8);
}

}  // namespace ensonify
