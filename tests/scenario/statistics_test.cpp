#include "catch.h"
#include "scenario_texts.h"

namespace ensonify {
namespace {

using testing::emit;
using testing::faults_of;
using testing::kHead;
using testing::parse;

}  // namespace

// Protects the bytes of data sets without statistics: their resolved scenario has no word of them.
TEST_CASE("statistics are off, and then nothing is said of them") {
  const auto scenario = parse(kHead);
  REQUIRE(scenario.ok());
  CHECK_FALSE(scenario->output.selection.statistics);
  CHECK(scenario->output.selection.pings);
  CHECK(emit(*scenario).find("statistics") == std::string::npos);
}

TEST_CASE("statistics go with the pings' files or stand for them") {
  const auto both = parse(kHead + "output: {statistics: true, layers: true}\n");
  REQUIRE(both.ok());
  CHECK(both->output.selection.statistics);
  CHECK(both->output.selection.timeseries);
  CHECK(emit(*parse(emit(*both))) == emit(*both));

  const auto alone =
      parse(kHead +
            "output: {statistics: true, pings: false, timeseries: both, polar: true, "
            "shadow: true, png: {scale: amplitude}, scatterers: true, points: true, "
            "layers: {targets: [object]}, pack: ping, polygons: true, "
            "sdf: {voxel_m: 0.1}}\n");
  REQUIRE(alone.ok());
  const OutputSelection& output = alone->output.selection;
  CHECK_FALSE((output.any_timeseries() || output.polar || output.cartesian || output.png));
  CHECK_FALSE((output.shadow || output.amodal || output.polygons || output.scatterers));
  CHECK_FALSE((output.points || output.layers || output.channels || output.packed));
  CHECK(alone->output.sdf);  // of the sequence, not of a ping
  const auto again = parse(emit(*alone));
  REQUIRE(again.ok());
  CHECK_FALSE(again->output.selection.pings);
  CHECK(emit(*again) == emit(*alone));
}

TEST_CASE("nothing at all cannot be asked for") {
  const auto faults = faults_of(kHead + "output: {pings: false}\n");
  REQUIRE(faults.size() == 1);
  CHECK(faults[0].find("output.pings: without statistics") != std::string::npos);
}

}  // namespace ensonify
