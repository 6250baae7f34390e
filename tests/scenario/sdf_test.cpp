#include "catch.h"
#include "scenario_texts.h"

namespace ensonify {
namespace {

using testing::emit;
using testing::faults_of;
using testing::kHead;
using testing::parse;

}  // namespace

TEST_CASE("the distance field is asked for by its voxels") {
  CHECK_FALSE(parse(kHead)->output.sdf);
  CHECK_FALSE(parse(kHead + "output: {sdf: false}\n")->output.sdf);
  const auto scenario = parse(kHead + "output: {sdf: {voxel_m: 0.05}}\n");
  REQUIRE(scenario.ok());
  REQUIRE(scenario->output.sdf);
  CHECK(scenario->output.sdf->voxel_m == 0.05);
  CHECK(scenario->output.sdf->band_voxels == 3);
  const auto again = parse(emit(*scenario));
  REQUIRE(again.ok());
  CHECK(emit(*again) == emit(*scenario));
  const auto drawn =
      parse(kHead + "output: {sdf: {voxel_m: 0.1, band_voxels: {uniform: [4, 4]}}}\n");
  REQUIRE(drawn.ok());
  CHECK(drawn->output.sdf->band_voxels == 4);
}

TEST_CASE("a distance field without a voxel size is a fault") {
  for (const char* text : {"true", "{}", "{band_voxels: 3}"}) {
    INFO(text);
    const auto faults = faults_of(kHead + "output: {sdf: " + text + "}\n");
    REQUIRE(faults.size() == 1);
    CHECK(faults[0].find("output.sdf.voxel_m: missing") != std::string::npos);
  }
  CHECK(faults_of(kHead + "output: {sdf: {voxel_m: 0}}\n").size() == 1);
  CHECK(faults_of(kHead + "output: {sdf: {voxel_m: 1, band_voxels: 0}}\n").size() == 1);
}

}  // namespace ensonify
