#include "catch.h"
#include "dataset/damage.h"
#include "dataset/sample.h"

using namespace ensonify;
using damage::faults;
using damage::forge;
using damage::mentions;
using damage::reseal;

// Protects readers of annotations: each line is held against its schema, and named.
TEST_CASE("an annotation that is not as its schema says is found though its hash is right",
          "[serial]") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 1);
  std::string text = sample::read(folder.path() / "sequences/000000/annotations.jsonl");
  const auto second = text.find('\n') + 1;
  const auto change = [&](const std::string& from, const std::string& to) {
    const auto at = text.find(from, second);
    REQUIRE(at != std::string::npos);
    text.replace(at, from.size(), to);
    forge(folder.path(), "annotations.jsonl", text);
    return faults(folder.path());
  };
  const std::string place = "sequences/000000/annotations.jsonl: line 2: #/images/0";
  SECTION("missing") {
    CHECK(change("\"area\":", "\"aera\":").at(0) ==
          place +
              "/annotations/0 has the unknown key aera; #/images/0/annotations/0 lacks the key "
              "area");
  }
  SECTION("of the wrong type") {
    CHECK(change("\"width\":6", "\"width\":\"6\"").at(0) ==
          place + "/width is \"6\", which has the wrong type");
  }
}

// Protects readers of the manifest, entry by entry.
TEST_CASE("a manifest that is not as its schema says is found though its hash is right",
          "[serial]") {
  const sample::TemporaryFolder folder;
  sample::make_dataset(folder.path(), 1);
  const auto told = [&](const char* name, const char* from, const char* to) {
    reseal(folder.path(), name, from, to);
    return faults(folder.path());
  };
  SECTION("an entry with a key too many") {
    CHECK(mentions(
        told("dataset.json", "\"path\": \"coco.json\"", "\"mode\": 1, \"path\": \"coco.json\""),
        "dataset.json: #/files/1 has the unknown key mode"));
  }
  SECTION("a name that is none") {
    CHECK(mentions(told("dataset.json", "\"name\": \"", "\"name\": 1, \"nam\": \""),
                   "dataset.json: #/name is 1"));
  }
  SECTION("work.json") {
    CHECK(mentions(told("work.json", "\"simd\"", "\"sind\""),
                   "work.json: #/numerics has the unknown key sind"));
  }
  SECTION("coco: an annotation with a key too many") {
    CHECK(mentions(told("coco.json", "\"iscrowd\":0", "\"iscrowd\":0,\"x\":1"),
                   "coco.json: #/annotations/0 has the unknown key x"));
  }
  SECTION("coco: an image of the wrong type") {
    CHECK(mentions(told("coco.json", "\"view\":\"polar\"", "\"view\":\"side\""),
                   "coco.json: #/images/0/view is \"side\""));
  }
  SECTION("coco: a key missing at the top") {
    CHECK(mentions(told("coco.json", "\"licenses\"", "\"licences\""),
                   "coco.json: # has the unknown key licences; # lacks the key licenses"));
  }
}
