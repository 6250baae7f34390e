// What is written: distance fields, statistics, masks of multipath.
#include "catch.h"
#include "core/units.h"
#include "scenario_texts.h"

namespace ensonify {
namespace {

using testing::emit;
using testing::faults_of;
using testing::is_one_fault;
using testing::kHead;
using testing::parse;
using testing::read_again;

TEST_CASE("the distance field is asked for by its voxels") {
  CHECK_FALSE(parse(kHead)->output.sdf);
  CHECK_FALSE(parse(kHead + "output: {sdf: false}\n")->output.sdf);
  const auto scenario = value_of(parse(kHead + "output: {sdf: {voxel_m: 0.05}}\n"));
  REQUIRE(scenario.output.sdf);
  CHECK(scenario.output.sdf->voxel_m == 0.05);
  CHECK(scenario.output.sdf->band_voxels == 3);
  read_again(scenario);
  const auto drawn =
      value_of(parse(kHead + "output: {sdf: {voxel_m: 0.1, band_voxels: {uniform: [4, 4]}}}\n"));
  CHECK(drawn.output.sdf->band_voxels == 4);
}

TEST_CASE("a distance field without a voxel size is a fault") {
  for (const char* text : {"true", "{}", "{band_voxels: 3}"}) {
    CHECK(
        is_one_fault(std::string("output: {sdf: ") + text + "}\n", "output.sdf.voxel_m: missing"));
  }
  CHECK(faults_of(kHead + "output: {sdf: {voxel_m: 0}}\n").size() == 1);
  CHECK(faults_of(kHead + "output: {height_map: {spacing_m: 0}}\n").size() == 1);
  CHECK(is_one_fault("output: {height_map: true}\n", "output.height_map.spacing_m: missing"));
  CHECK(faults_of(kHead + "output: {sdf: {voxel_m: 1, band_voxels: 0}}\n").size() == 1);
}

// Protects the bytes of data sets without planes that kOutputFlags offers, and the files that they
// need.
TEST_CASE("planes with a switch of their own are off, and go with the images that they need") {
  int switches = 0;
  for (const OutputFlag& flag : kOutputFlags) {
    if (flag.title == nullptr) continue;
    INFO(flag.name);
    ++switches;
    const std::string name = flag.name;
    const auto without = value_of(parse(kHead));
    CHECK_FALSE(without.output.selection.*flag.member);
    CHECK_FALSE(contains(emit(without), name + ": "));
    const auto with = value_of(parse(kHead + "output: {" + name + ": true}\n"));
    CHECK(with.output.selection.*flag.member);
    CHECK(emit(*parse(emit(with))) == emit(with));
    if (flag.needs == nullptr) continue;
    const std::string needed = flag_of(flag.needs)->name;
    CHECK(is_one_fault("output: {" + name + ": true, " + needed + ": false}\n",
                       "output." + name + ": there are no " + needed + " images"));
  }
  CHECK(switches >= 1);
}

// Protects the bytes of data sets without it, and its steps.
TEST_CASE("echoes over elevation are off, and have steps of half a degree") {
  CHECK_FALSE(contains(emit(*parse(kHead)), "elevation: {step"));
  const auto plain = value_of(parse(kHead + "output: {elevation: true}\n"));
  CHECK(plain.output.selection.elevation);
  CHECK(plain.output.selection.elevation_step_rad == Approx(radians(0.5)));
  CHECK_FALSE(plain.output.selection.elevation_volumes);
  const auto fine =
      value_of(parse(kHead + "output: {elevation: {step_deg: 0.1, volumes: true}}\n"));
  CHECK(fine.output.selection.elevation_step_rad == Approx(radians(0.1)));
  CHECK(fine.output.selection.elevation_volumes);
  CHECK(emit(*parse(emit(fine))) == emit(fine));
  CHECK(faults_of(kHead + "output: {elevation: {step_deg: 0}}\n").size() == 1);
}

// Protects the bytes of data sets without motion, its number of pings, and the cases in which
// points do not move along straight lines between fixed poses.
TEST_CASE("motion and covisibility are off, and need straight rays and fixed poses") {
  const auto without = value_of(parse(kHead));
  CHECK_FALSE(contains(emit(without), "motion:"));
  CHECK_FALSE(contains(emit(without), "covisibility"));
  const auto next = value_of(parse(kHead + "output: {motion: true, covisibility: true}\n"));
  CHECK(next.output.selection.motion);
  CHECK(next.output.selection.motion_pings == 1);
  CHECK(next.output.selection.covisibility);
  const auto earlier = value_of(parse(kHead + "output: {motion: {pings: -3}}\n"));
  CHECK(earlier.output.selection.motion_pings == -3);
  CHECK(emit(*parse(emit(earlier))) == emit(earlier));

  CHECK(is_one_fault("output: {motion: {pings: 0}}\n", "output.motion.pings: 0 is the ping"));
  CHECK(
      is_one_fault("output: {motion: true, polar: false}\n", "output.motion: there are no polar"));
  CHECK(is_one_fault("motion_within_ping: true\noutput: {motion: true}\n",
                     "output.motion: points are followed along straight lines"));
  CHECK(is_one_fault("motion_within_ping: true\noutput: {covisibility: true}\n",
                     "output.covisibility: points are followed"));
  CHECK(is_one_fault("output: {covisibility: true, statistics: true}\n",
                     "expected covisibility or statistics, but not both"));
}

// Protects the bytes of data sets without statistics: their resolved scenario has no word of them.
TEST_CASE("statistics are off, and then nothing is said of them") {
  const auto scenario = value_of(parse(kHead));
  CHECK_FALSE(scenario.output.selection.statistics);
  CHECK(scenario.output.selection.pings);
  CHECK_FALSE(contains(emit(scenario), "statistics"));
}

TEST_CASE("statistics go with the pings' files or stand for them") {
  const auto both = value_of(parse(kHead + "output: {statistics: true, layers: true}\n"));
  CHECK(both.output.selection.statistics);
  CHECK(both.output.selection.timeseries);
  CHECK(emit(*parse(emit(both))) == emit(both));

  const auto alone = value_of(
      parse(kHead +
            "output: {statistics: true, pings: false, timeseries: both, polar: true, "
            "shadow: true, png: {scale: amplitude}, cartesian: {exr: true}, scatterers: true, "
            "points: true, "
            "layers: {targets: [object]}, one_file_per: ping, polygons: true, "
            "sdf: {voxel_m: 0.1}, world: true, height_map: {spacing_m: 0.1}}\n"));
  const OutputSelection& output = alone.output.selection;
  CHECK_FALSE((output.any_timeseries() || output.polar || output.cartesian || output.png));
  CHECK_FALSE(output.cartesian_exr);
  CHECK_FALSE((output.shadow || output.amodal || output.polygons || output.scatterers));
  CHECK_FALSE((output.points || output.layers || output.channels || output.packed));
  CHECK(alone.output.sdf);  // of the sequence, not of a ping
  CHECK(alone.output.height_map);
  CHECK(alone.output.selection.world);
  const Scenario again = read_again(alone);
  CHECK_FALSE(again.output.selection.pings);
}

TEST_CASE("lags and pooled pixels of statistics are kept with and without pings") {
  for (const char* pings : {"true", "false"}) {
    const auto scenario = value_of(
        parse(kHead + "output: {statistics: {lags: 8, within_db: 12}, pings: " + pings + "}\n"));
    const OutputSelection again = read_again(scenario).output.selection;
    CHECK(again.statistics);
    CHECK(again.statistics_lags == 8);
    CHECK(again.statistics_within_db == 12);
  }
  CHECK(contains(emit(value_of(parse(kHead + "output: {statistics: {}}\n"))), "statistics: true"));
}

TEST_CASE("nothing at all cannot be asked for") {
  CHECK(is_one_fault("output: {pings: false}\n",
                     "output.pings: false without statistics leaves nothing to write"));
}

const std::string kSurface = "multipath: {surface: {z_m: 2, reflection: -1}}\n";

TEST_CASE("multipath is read with its defaults and written back") {
  CHECK_FALSE(parse(kHead)->multipath);
  CHECK_FALSE(contains(emit(*parse(kHead)), "multipath"));
  const auto scenario = value_of(parse(kHead + kSurface));
  const Multipath& plain = *scenario.multipath;
  CHECK(plain.surface->z_m == 2);
  CHECK(plain.surface->reflection == -1);
  CHECK(plain.surface->roughness_rms_m == 0);
  CHECK_FALSE(plain.bottom);
  CHECK_FALSE(plain.objects);
  CHECK(plain.bounces == 2);
  const auto full = value_of(
      parse(kHead + "multipath: {surface: {z_m: 2, reflection: -0.9, roughness_rms_m: 0.01}, "
                    "bottom: {z_m: -7.5, reflection: 0.25}, objects: true, bounces: 4}\n"
                    "output: {multipath: false}\n"));
  const Scenario again = read_again(full);
  CHECK(again.multipath->surface->roughness_rms_m == 0.01);
  CHECK(again.multipath->bottom->z_m == -7.5);
  CHECK(again.multipath->objects);
  CHECK(again.multipath->bounces == 4);
  CHECK_FALSE(again.output.selection.multipath);
}

TEST_CASE("numbers of multipath may be drawn") {
  const auto drawn =
      value_of(parse(kHead + "multipath: {surface: {z_m: {uniform: [4, 4]}, reflection: -1}}\n"));
  CHECK(drawn.multipath->surface->z_m == 4);
  CHECK(drawn.has_draws);
  CHECK(parse(emit(drawn))->multipath->surface->z_m == 4);
}

TEST_CASE("the mask of bounced echoes goes with multipath and pictures") {
  const auto has_mask = [](const std::string& text) {
    const auto scenario = value_of(parse(kHead + text));
    return scenario.output.selection.multipath;
  };
  CHECK_FALSE(has_mask(""));
  CHECK_FALSE(has_mask("output: {multipath: false}\n"));
  CHECK(has_mask(kSurface));
  CHECK(has_mask(kSurface + "output: {multipath: on}\n"));
  CHECK(has_mask(kSurface + "output: {polar: false}\n"));
  CHECK_FALSE(has_mask(kSurface + "output: {multipath: false}\n"));
  CHECK_FALSE(has_mask(kSurface + "output: {polar: false, cartesian: false}\n"));
  CHECK(is_one_fault("output: {multipath: true}\n",
                     "output.multipath: the scenario has no multipath"));
  CHECK(is_one_fault(kSurface + "output: {multipath: true, polar: false, cartesian: false}\n",
                     "output.multipath: there are no images to label"));
}

TEST_CASE("mirrors that cannot be are faults") {
  CHECK(is_one_fault("multipath: {}\n", "multipath: there is no specular reflector"));
  CHECK(is_one_fault("multipath: {objects: false}\n", "multipath: there is no specular reflector"));
  CHECK(is_one_fault("multipath: {surface: {z_m: 1}}\n", "multipath.surface.reflection: missing"));
  CHECK(is_one_fault("multipath: {bottom: {reflection: 1}}\n", "multipath.bottom.z_m: missing"));
  CHECK(is_one_fault("multipath: {surface: {z_m: 1, reflection: -1.5}}\n",
                     "multipath.surface.reflection"));
  CHECK(is_one_fault("multipath: {objects: true, bounces: 5}\n", "multipath.bounces"));
  CHECK(is_one_fault("multipath: {objects: true, bounces: 0}\n", "multipath.bounces"));
  CHECK(is_one_fault(
      "multipath: {surface: {z_m: -3, reflection: -1}, bottom: {z_m: -3, reflection: 1}}\n",
      "multipath.bottom.z_m: the bottom is not below the surface"));
}

}  // namespace
}  // namespace ensonify
