#include "dataset/sequence_json.h"

#include <limits>

#include "catch.h"
#include "dataset/json.h"
#include "dataset/layout.h"
#include "dataset/sample.h"
#include "dataset/tables.h"

using namespace ensonify;

// Protects readers that work the series out again: every number of the formula is there, in SI
// units and radians.
TEST_CASE("sequence.json has the numbers of the beam model") {
  const auto info = sample::sequence_info(0);
  const Json head = sequence_head(info, {"timeseries/{ping}.npy"}, 10);
  CHECK(head["sonar"]["frequency_hz"] == 900e3);
  CHECK(head["sonar"]["bandwidth_hz"] == 29.9e3);
  CHECK(head["sonar"]["source_pressure_pa_m"].get<double>() == Approx(1e5));
  CHECK(head["sonar"]["beams"]["count"] == sample::kBeams);
  CHECK(head["sonar"]["beams"]["first_azimuth_rad"].get<double>() == Approx(-0.25));
  CHECK(head["sonar"]["beams"]["width_rad"] == 0.02);
  CHECK(head["record"]["samples"] == sample::kSamples);
  CHECK(head["record"]["transform"] == 128);
  CHECK(head["record"]["sample_interval_s"] == 1 / 29.9e3);
  CHECK(head["noise"]["spectrum_level_db"] == 30);
  CHECK(head["noise"]["power_pa2"] == 2.99e-5);
  CHECK(head["noise"]["snr_db"].is_null());
  CHECK(head["instances"][1]["target_strength_db"] == -40);
  CHECK(head["instances"][0]["material"] == "concrete");
  CHECK(head["cartesian"]["metres_per_pixel"] == 0.03);
  CHECK(head["png"]["db"] == Json({60.0, 120.0}));
  CHECK(head["seed"] == 18446744073709551615u);
}

// Protects the piecewise writing: opening, lines and closing make one JSON document.
TEST_CASE("sequence.json written in pieces is JSON with its files") {
  const Json head = sequence_head(sample::sequence_info(0), {}, 3);
  const std::string text = files_opening(head) + file_line({"a", 1, "x"}, true) +
                           file_line({"b", 2, "y"}, false) + files_closing();
  std::vector<FileEntry> entries;
  const auto json = parse_manifest(text, [&](FileEntry entry) { entries.push_back(entry); });
  REQUIRE(json);
  REQUIRE(entries.size() == 2);
  CHECK(entries[1].path == "b");
  CHECK(entries[1].bytes == 2);
  CHECK((*json)["files"].empty());
  CHECK((*json)["instances"].size() == 2);
  CHECK((*json)["sonar"] == head["sonar"]);
}

// Protects JSON from numbers it has no word for.
TEST_CASE("what is not a number becomes null") {
  CHECK(number_or_null(std::numeric_limits<double>::quiet_NaN()).is_null());
  CHECK(number_or_null(std::numeric_limits<double>::infinity()).is_null());
  CHECK(json_line(number_or_null(0.1)) == "0.1");
}

// Protects readers of manifests from foreign content: nothing of the wrong kind may throw.
TEST_CASE("members of the wrong kind are none") {
  const Json json = *parse_json(R"({"text": 1, "count": -1, "number": "x", "list": []})");
  CHECK_FALSE(text_at(json, "text"));
  CHECK_FALSE(count_at(json, "count"));
  CHECK_FALSE(number_at(json, "number"));
  CHECK_FALSE(text_at(json["list"], "a"));
  CHECK_FALSE(parse_json("{"));
  CHECK_FALSE(parse_manifest("[]", [](const FileEntry&) {}));
  bool empty = false;
  CHECK(parse_manifest(R"({"files": [{"path": 3}]})",
                       [&](const FileEntry& entry) { empty = entry.path.empty(); }));
  CHECK(empty);
}

// Protects names: templates and file names turn into each other, also beyond six digits.
TEST_CASE("names of ping files go both ways") {
  for (const std::uint32_t ping : {0u, 42u, 999999u, 1000000u, 4294967295u}) {
    const std::string name = layout::ping_file(layout::kPolarInstance, ping);
    const auto file = layout::parse_ping_file(name);
    REQUIRE(file);
    CHECK(file->name_template == layout::kPolarInstance);
    CHECK(file->ping == ping);
  }
  CHECK(layout::ping_file(layout::kPolarGrey, 7) == "png/000007_polar.png");
  CHECK_FALSE(layout::parse_ping_file("poses.csv"));
  CHECK_FALSE(layout::parse_ping_file("polar/0000007.exr"));
  CHECK_FALSE(layout::parse_ping_file("polar/99999999999.exr"));
}

// Protects strangers' files: only names that a data set can have are in its way.
TEST_CASE("names of the layout are told from others") {
  for (const char* name :
       {"work.json", "dataset.json", "splits", "splits/val.txt", "assets/x", ".work", "sequences",
        "sequences/000012", "sequences/000000/sequence.json", "sequences/000000/polar",
        "sequences/000000/polar/000123_instance.png", "sequences/000000/png/1000000_polar.png"}) {
    INFO(name);
    CHECK(layout::is_layout_name(name));
  }
  for (const char* name : {"notes.txt", "splits/mine.txt", "sequences/notes", "sequences/12",
                           "sequences/000000/notes", "sequences/000000/polar/000123.pdf"}) {
    INFO(name);
    CHECK_FALSE(layout::is_layout_name(name));
  }
}

// Protects tables from lost digits and locale: shortest form that reads back to the same double.
TEST_CASE("tables hold the shortest form of a number") {
  const Pose pose{{0.1, 1e-9, 123456789.125}, {1, 0, 0, 0}};
  CHECK(poses_row(3, 0.30000000000000004, pose) ==
        "3,0.30000000000000004,0.1,1e-09,123456789.125,1,0,0,0\n");
  CHECK(index_row(2, 3, 0.5, "val") == "2,3,0.5,val,000002/000003\n");
}
