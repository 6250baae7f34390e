// The keys of beams of unequal spacing and width.
#include "catch.h"
#include "core/units.h"
#include "scenario_texts.h"

using namespace ensonify;
using namespace ensonify::testing;

namespace {

// Lines 1 to 3 of a scenario, with these beams.
std::string with_beams(const std::string& beams, const std::string& more = "") {
  return "ensonify: 1\nname: t\nsonar: {preset: blueview_p900_90, beams: {" + beams + "}" + more +
         "}\n";
}

}  // namespace

TEST_CASE("azimuths and widths of beams are read and written as they stand") {
  const auto scenario = value_of(parse(
      with_beams("count: 4, azimuths_deg: [-6, -1, 1.5, 8], receive_widths_deg: [2, 1, 1, 1.6]")));
  CHECK(scenario.sonar.beam_fov_deg == Approx(14 + 2.5 + 3.25));
  CHECK(scenario.sonar.beam_width_deg == Approx(1.4));
  const Sonar sonar = sonar_of(scenario);
  REQUIRE(sonar.azimuth_rad.size() == 4);
  REQUIRE(sonar.width_rad.size() == 4);
  CHECK(sonar.azimuth_rad[2] == Approx(radians(1.5)));
  CHECK(sonar.width_rad[3] == Approx(radians(1.6)));
  CHECK(sonar.beam_spacing_rad == Approx(radians(19.75 / 4)));
  CHECK(sonar.beam_width_rad == Approx(radians(1.4)));
  const std::string text = emit(scenario);
  CHECK(contains(text, "azimuths_deg: [-6, -1, 1.5, 8]"));
  CHECK(contains(text, "receive_widths_deg: [2, 1, 1, 1.6]"));
  CHECK_FALSE(contains(text, "fov_deg"));
  CHECK_FALSE(contains(text, "receive_width_deg"));
  const auto again = value_of(parse(text));
  CHECK(emit(again) == text);
  // Data sets of equal beams keep their scenario.yaml.
  CHECK_FALSE(contains(emit(*parse(kHead)), "azimuths_deg"));
  CHECK_FALSE(contains(emit(*parse(kHead)), "receive_widths_deg"));
}

TEST_CASE("a preset's azimuths give way to a fan, and a fan to azimuths") {
  const auto fan = value_of(parse(
      "ensonify: 1\nname: t\nsonar: {preset: aris_3000_hf, beams: {count: 64, fov_deg: 30}}\n"));
  CHECK(sonar_of(fan).azimuth_rad.empty());
  CHECK(sonar_of(fan).beam_spacing_rad == Approx(radians(30.0 / 64)));
  const auto azimuths = value_of(
      parse(kHead, {{"sonar.beams.azimuths_deg", "[-3, 0, 4]"}, {"sonar.beams.count", "3"}}));
  CHECK(sonar_of(azimuths).azimuth_rad.size() == 3);
}

TEST_CASE("the ARIS preset has the maker's azimuths") {
  const auto scenario = value_of(parse("ensonify: 1\nname: t\nsonar: {preset: aris_3000_lf}\n"));
  const Sonar sonar = sonar_of(scenario);
  REQUIRE(sonar.azimuth_rad.size() == 128);
  CHECK(degrees(sonar.azimuth_rad.front()) == Approx(-15.0068));
  CHECK(degrees(sonar.azimuth_rad.back()) == Approx(15.0156));
  // The edges of the same table.
  const std::vector<double> borders = beam_borders_rad(sonar);
  CHECK(degrees(borders.front()) == Approx(-15.1218).margin(1e-4));
  CHECK(degrees(borders[1]) == Approx(-14.8918).margin(1e-4));
  CHECK(degrees(borders[64]) == Approx(-0.0001).margin(1e-4));
  CHECK(degrees(borders.back()) == Approx(15.1306).margin(4e-4));
}

TEST_CASE("wrong azimuths and widths are reported at their place") {
  check_single_faults(
      {
          {"count: 3, azimuths_deg: [-3, 0]", "sonar.beams.azimuths_deg: ",
           "the number of values is 2, but count is 3; expected one for each beam"},
          {"count: 3, receive_widths_deg: [1, 1, 1, 1]",
           "sonar.beams.receive_widths_deg: ", "the number of values is 4, but count is 3"},
          {"count: 3, azimuths_deg: [-3, 4, 4]", "sonar.beams.azimuths_deg.2: ",
           "4 is not above the 4 before it; expected increasing azimuths"},
          {"count: 2, azimuths_deg: [-3, 91]", "sonar.beams.azimuths_deg.1: ", "expected"},
          {"count: 2, azimuths_deg: [20, 89]",
           "sonar.beams.azimuths_deg.1: ", "ends at 123.5 degrees; expected at most 90"},
          {"count: 2, azimuths_deg: [-85, -70]",
           "sonar.beams.azimuths_deg.0: ", "ends at -92.5 degrees"},
          {"count: 1, azimuths_deg: [3]", "sonar.beams.azimuths_deg: ", "expected 2 to 1024"},
          {"count: 2, receive_widths_deg: [1, 0]",
           "sonar.beams.receive_widths_deg.1: ", "expected a number > 0"},
          {"count: 2, azimuths_deg: [-3, 3], fov_deg: 12", "sonar.beams: ", "azimuths_deg"},
          {"count: 2, receive_width_deg: 1, receive_widths_deg: [1, 2]",
           "sonar.beams: ", "receive_widths_deg"},
      },
      [](const std::string& beams) { return with_beams(beams); });
  check_single_faults(
      {{"count: 2, receive_widths_deg: [1, 2]", "sonar.beams.receive_widths_deg: ",
        "expected receive_width_deg with sonar.receiver.mode: array"}},
      [](const std::string& beams) { return with_beams(beams, ", receiver: {mode: array}"); });
}
