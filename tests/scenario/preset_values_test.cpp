// Values of a preset that follow from one that the scenario has changed.
#include "acoustics/pattern.h"

#include "catch.h"
#include "core/units.h"
#include "scenario_texts.h"

namespace ensonify {
namespace {

using testing::parse;
using testing::read_again;

Scenario scenario_with(const std::string& sonar) {
  INFO(sonar);
  return value_of(parse("ensonify: 1\nname: t\nsonar: {" + sonar + "}\n"));
}

struct FanRays {
  double fan_deg = 0;
  int rays = 0;
  bool operator==(const FanRays&) const = default;
};

FanRays fan_of(const std::string& sonar) {
  const Scenario scenario = scenario_with(sonar);
  const SonarSpec again = read_again(scenario).sonar;
  CHECK(again.elevation_fan_deg == scenario.sonar.elevation_fan_deg);
  CHECK(again.rays_elevation == scenario.sonar.rays_elevation);
  return {scenario.sonar.elevation_fan_deg, scenario.sonar.rays_elevation};
}

}  // namespace

// Protects the near seabed: a wider pattern is traced to its first zero, as densely as the preset.
TEST_CASE("the fan of a preset follows its pattern in elevation") {
  const std::string oculus = "preset: oculus_m750d_hf, ";
  CHECK(fan_of(oculus + "range_max_m: 8") == FanRays{33.8, 192});
  CHECK(fan_of(oculus + "elevation: {width_deg: 12}") == FanRays{33.8, 192});
  CHECK(fan_of(oculus + "elevation: {shading: hann}") == FanRays{33.8, 192});
  CHECK(fan_of(oculus + "elevation: {width_deg: 20}") == FanRays{57.9, 329});
  CHECK(fan_of(oculus + "elevation: {width_deg: 6}") == FanRays{16.7, 192});
  CHECK(fan_of(oculus + "elevation: {width_deg: 120}") == FanRays{180, 1022});
  // As other presets of that width and shading have it.
  CHECK(fan_of("preset: blueview_p900_90, elevation: {width_deg: 12}").fan_deg == 33.8);
  for (const char* shading : {"uniform", "taylor", "chebyshev"}) {
    const Scenario shaded = scenario_with(oculus + "elevation: {shading: " + shading + "}");
    const ShadedLine line = make_shaded_line(shaded.sonar.elevation_shading, radians(12));
    // To the tenth of a degree below it.
    const double half_deg = shaded.sonar.elevation_fan_deg / 2;
    CHECK(shaded_pattern(line, radians(half_deg)) >= 0);
    CHECK(shaded_pattern(line, radians(half_deg + 0.051)) < 0);
  }
}

TEST_CASE("a fan or rays that are given stay") {
  const std::string oculus = "preset: oculus_m750d_hf, ";
  CHECK(fan_of(oculus + "elevation: {width_deg: 20, fan_deg: 30}") == FanRays{30, 192});
  CHECK(fan_of(oculus + "elevation: {fan_deg: 24}") == FanRays{24, 192});
  CHECK(fan_of(oculus + "elevation: {fan_deg: 67.6}") == FanRays{67.6, 192});
  CHECK(fan_of(oculus + "elevation: {width_deg: 20}, rays: {elevation: 100}") ==
        FanRays{57.9, 100});
  // This preset's fan ends at the width of its pattern.
  CHECK(fan_of("preset: paper_table1, elevation: {width_deg: 30}") == FanRays{30, 171});
  const Scenario none = scenario_with(
      "frequency_hz: 9e5, bandwidth_hz: 3e4, source_level_db: 200, range_max_m: 5, beams: {count: "
      "4, "
      "fov_deg: 40, receive_width_deg: 10}, elevation: {width_deg: 20}, rays: {elevation: 9}");
  CHECK(none.sonar.elevation_fan_deg == 20);
  CHECK(none.sonar.rays_elevation == 9);
}

// Protects from widths of another frequency: the aperture is that of the device.
TEST_CASE("another frequency than that of the preset is told with its widths") {
  const auto notices = [](const std::string& sonar) { return scenario_with(sonar).notices; };
  const std::string head = "preset: blueview_p900_90, frequency_hz: ";
  CHECK(notices("preset: blueview_p900_90").empty());
  CHECK(notices(head + "9.2e5").empty());
  CHECK(notices(head + "4.5e5, beams: {receive_width_deg: 2}, elevation: {width_deg: 40}").empty());
  const auto both = notices(head + "4.5e5");
  REQUIRE(both.size() == 1);
  CHECK(
      both[0].starts_with("sonar.frequency_hz: 450000 is not the 900000 of preset "
                          "blueview_p900_90"));
  CHECK(contains(both[0],
                 "beams.receive_width_deg 1 (its aperture would have 2) and "
                 "elevation.width_deg 20 (its aperture would have 40)"));
  const auto one = notices(head + "4.5e5, beams: {receive_width_deg: 2}");
  REQUIRE(one.size() == 1);
  CHECK_FALSE(contains(one[0], "receive_width_deg"));
}

}  // namespace ensonify
