// Water that is described in one place or in several.
#include "acoustics/propagation.h"

#include "catch.h"
#include "scenario_texts.h"

namespace ensonify {
namespace {

using testing::emit;
using testing::faults_of;
using testing::kHead;
using testing::parse;
using testing::read_again;
using testing::tells;

Scenario with_water(const std::string& keys) {
  return value_of(parse(kHead + "water: {" + keys + "}\n"));
}

std::array<double, 4> sea_of(const Scenario& scenario) {
  const auto& sea = std::get<SeaAbsorptionSpec>(scenario.water.absorption);
  return {sea.temperature_c, sea.salinity_psu, sea.ph, sea.depth_m};
}

using Sea = std::array<double, 4>;

}  // namespace

// Protects fresh water in a tank: its absorption at 2.1 MHz is a third below that of the sea.
TEST_CASE("the water of the sound speed is that of the absorption") {
  const std::string from =
      "sound_speed_m_s: {from: {temperature_c: 20, salinity_psu: 0, depth_m: 2}}";
  for (const char* absorption : {"", ", absorption: {model: francois_garrison}"}) {
    const Scenario scenario = with_water(from + absorption);
    CHECK(sea_of(scenario) == Sea{20, 0, 8, 2});
    CHECK(scenario.water.density_kg_m3 == 1025);
    CHECK(sea_of(read_again(scenario)) == Sea{20, 0, 8, 2});
  }
  CHECK(sea_of(with_water(from + ", absorption: {model: ainslie_mccolm, ph: 7, depth_m: 9}")) ==
        Sea{20, 0, 7, 9});
  CHECK(sea_of(with_water(from + ", absorption: {model: ainslie_mccolm, temperature_c: 12}")) ==
        Sea{12, 0, 8, 2});
  // A description of its own.
  CHECK(sea_of(with_water(
            from + ", absorption: {model: ainslie_mccolm, temperature_c: 12, salinity_psu: 1}")) ==
        Sea{12, 1, 8, 0});
  CHECK(std::get<FixedAbsorptionSpec>(
            with_water(from + ", absorption: {fixed_db_m: 0.5}").water.absorption)
            .db_m == 0.5);
}

// Protects the one description: everything that it implies follows, unless it is given.
TEST_CASE("one description of the water gives sound speed, absorption and density") {
  const Scenario whole = with_water("temperature_c: 20, salinity_psu: 0, ph: 7.5, depth_m: 3");
  REQUIRE(whole.water.sound_speed_from);
  CHECK(whole.water.sound_speed_from->temperature_c == 20);
  CHECK(whole.water.sound_speed_from->salinity_psu == 0);
  CHECK(whole.water.sound_speed_from->depth_m == 3);
  CHECK(sea_of(whole) == Sea{20, 0, 7.5, 3});
  CHECK(whole.water.density_kg_m3 == Approx(998.2).margin(0.05));
  const Scenario again = read_again(whole);
  CHECK(again.water.density_kg_m3 == whole.water.density_kg_m3);
  CHECK(sea_of(again) == sea_of(whole));
  CHECK(sea_of(with_water("temperature_c: 4, salinity_psu: 35")) == Sea{4, 35, 8, 0});

  const Scenario mixed = with_water(
      "temperature_c: 20, salinity_psu: 0, sound_speed_m_s: 1481, density_kg_m3: 1000, "
      "absorption: {model: ainslie_mccolm, temperature_c: 18, salinity_psu: 1}");
  CHECK_FALSE(mixed.water.sound_speed_from);
  CHECK(mixed.water.sound_speed_m_s == 1481);
  CHECK(mixed.water.density_kg_m3 == 1000);
  CHECK(sea_of(mixed) == Sea{18, 1, 8, 0});
}

TEST_CASE("half a description of the water, or two of them, are refused") {
  const auto faults = [](const std::string& keys) {
    return faults_of(kHead + "water: {" + keys + "}\n");
  };
  CHECK(tells(faults("temperature_c: 20"), "t.yaml:4:", "water.salinity_psu: missing"));
  CHECK(tells(faults("depth_m: 20, salinity_psu: 0"), "t.yaml:4:", "water.temperature_c: missing"));
  CHECK(tells(faults("temperature_c: 20, salinity_psu: 0, sound_speed_m_s: {from: {temperature_c: "
                     "20, salinity_psu: 0, depth_m: 0}}"),
              "t.yaml:4:", "describes the water a second time"));
}

// The check values of UNESCO's algorithm, at 0 and at 1000 bar (a depth of 9945 m of the column).
TEST_CASE("the density of water is that of the equation of state") {
  const double deep_m = 1000 / (1025 * 9.81e-5);
  CHECK(water_density_kg_m3({5, 0, 8, 0}) == Approx(999.96675).epsilon(1e-8));
  CHECK(water_density_kg_m3({5, 35, 8, 0}) == Approx(1027.67547).epsilon(1e-8));
  CHECK(water_density_kg_m3({25, 35, 8, 0}) == Approx(1023.34306).epsilon(1e-8));
  CHECK(water_density_kg_m3({5, 0, 8, deep_m}) == Approx(1044.12802).epsilon(1e-8));
  CHECK(water_density_kg_m3({5, 35, 8, deep_m}) == Approx(1069.48914).epsilon(1e-8));
  CHECK(water_density_kg_m3({25, 35, 8, deep_m}) == Approx(1062.53817).epsilon(1e-8));
}

}  // namespace ensonify
