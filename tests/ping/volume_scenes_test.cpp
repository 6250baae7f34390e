// The scenes of volumes, through the whole chain, by number.
#include <algorithm>
#include <cmath>
#include <set>

#include "acoustics/pattern.h"
#include "acoustics/propagation.h"
#include "catch.h"
#include "core/random.h"
#include "core/units.h"
#include "run_scene.h"
#include "world/volumes.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

struct Extent {
  double low = 1e9, high = -1e9;
  void add(double x) {
    low = std::min(low, x);
    high = std::max(high, x);
  }
};

struct PolarExtent {
  Extent range_m, azimuth_rad;
};

std::uint16_t id_of(const SceneRun& run, const std::string& name) {
  for (const Instance& instance : run.info().instances) {
    if (instance.name == name) return instance.id;
  }
  return 0;
}

// Whether the sonar's fan holds a point of its own frame.
bool in_fan(const Sonar& sonar, Vec3 p) {
  return std::abs(std::asin(p.z / length(p))) <= sonar.elevation_fan_rad / 2 &&
         sector_of(sonar, std::atan2(p.y, p.x)).has_value();
}

// Of the cone that the scenario says, where the fan sees it, with a share of its radius.
PolarExtent extent_of_cone(const SceneRun& run, const Pose& sonar, double share) {
  const VolumeSpec& spec = run.session().scenario.volumes[0];
  const auto& plume = std::get<PlumeSpec>(spec.kind);
  PolarExtent extent;
  for (double z = 0; z < plume.height_m; z += 0.005) {
    for (double turn = 0; turn < 2 * kPi; turn += 0.02) {
      const double radius = share * plume_radius_m(plume, z);
      const Vec3 local{radius * std::cos(turn), radius * std::sin(turn), z};
      const Vec3 p = inverse_transform_point(sonar, transform_point(pose_of(spec.pose), local));
      if (!in_fan(run.session().sonar, p)) continue;
      extent.range_m.add(length(p));
      extent.azimuth_rad.add(std::atan2(p.y, p.x));
    }
  }
  return extent;
}

}  // namespace

// Protects the plume's place and size in the masks: all of them within the cone that the fan sees,
// but for the reach of a pixel, and at least as far as the cone's inner three fifths.
TEST_CASE("the plume's mask is as large as its cone", "[figure]") {
  const SceneRun run("bubble_plume");
  const auto plume = id_of(run, "plume");
  REQUIRE(plume > 0);
  const PingResult ping = run.ping(4);
  const Sonar& sonar = run.session().sonar;
  PolarExtent mask;
  int pixels = 0;
  for (int n = 0; n < ping.polar->rows; ++n) {
    for (int j = 0; j < ping.polar->columns; ++j) {
      if (ping.polar->instance[std::size_t(n) * ping.polar->columns + j] != plume) continue;
      mask.range_m.add(sample_range_m(sonar, run.session().water, n));
      mask.azimuth_rad.add(beam_azimuth_rad(sonar, j));
      ++pixels;
    }
  }
  const PolarExtent whole = extent_of_cone(run, ping.sonar_in_world, 1);
  const PolarExtent inner = extent_of_cone(run, ping.sonar_in_world, 0.6);
  const double cell = 3 * sample_range_m(sonar, run.session().water, 1);
  const double beam = 2 * sonar.beam_spacing_rad + 0.05 / 5;  // a voxel's blur
  CHECK(pixels > 500);
  CHECK(mask.range_m.low > whole.range_m.low - cell);
  CHECK(mask.range_m.low < inner.range_m.low);
  CHECK(mask.range_m.high < whole.range_m.high + cell);
  CHECK(mask.range_m.high > inner.range_m.high);
  CHECK(mask.azimuth_rad.low > whole.azimuth_rad.low - beam);
  CHECK(mask.azimuth_rad.low < inner.azimuth_rad.low);
  CHECK(mask.azimuth_rad.high < whole.azimuth_rad.high + beam);
  CHECK(mask.azimuth_rad.high > inner.azimuth_rad.high);
}

// Protects what is behind: the wall keeps its scatterers and loses level behind the plume alone.
TEST_CASE("the plume dims the wall behind it and nothing else", "[figure]") {
  const SceneRun dim("bubble_plume"),
      clear("bubble_plume", {{"volumes.0.plume.extinction_db_m", "0"}});
  const PingResult a = dim.ping(4), b = clear.ping(4);
  const PolarExtent cone = extent_of_cone(dim, a.sonar_in_world, 1);
  REQUIRE(a.scatterers.size() == b.scatterers.size());
  double most_db = 0;
  for (std::size_t i = 0; i < a.scatterers.size(); ++i) {
    const Scatterer &x = a.scatterers.items[i], &y = b.scatterers.items[i];
    const double loss_db = 20 * std::log10(y.gain / x.gain);
    const double azimuth = x.arrival.azimuth_rad;
    const bool aside =
        azimuth < cone.azimuth_rad.low - 0.02 || azimuth > cone.azimuth_rad.high + 0.02;
    if (aside || length(x.position_m) < cone.range_m.low) REQUIRE(x.gain == y.gain);
    REQUIRE(loss_db >= 0);
    most_db = std::max(most_db, loss_db);
  }
  // Twice 4 dB/m over at most 0.9 m, of a density about 1 and, in its turbulence, several.
  CHECK(most_db > 1);
  CHECK(most_db < 8 * 0.9 * 4);
}

// Every fish is heard once, with the school's id and the energy of its strength and place. That the
// mean over the ellipsoid comes out too is checked against other random places, 200,000 of them.
TEST_CASE("the school echoes fish by fish", "[figure]") {
  const SceneRun run("fish_school");
  const auto school = id_of(run, "school");
  const PingResult ping = run.ping(4);
  const auto& spec = std::get<SchoolSpec>(run.session().scenario.volumes[0].kind);
  const Pose pose = pose_of(run.session().scenario.volumes[0].pose);
  const auto energy_of = [&](Vec3 world_m) {
    const Vec3 p = inverse_transform_point(ping.sonar_in_world, world_m);
    REQUIRE(in_fan(run.session().sonar, p));
    const double pattern = elevation_pattern(run.session().sonar, std::asin(p.z / length(p)));
    const double loss = two_way_loss(length(p), run.session().water.absorption_db_m);
    return std::pow(10, spec.target_strength_db / 10) * loss * loss * pattern * pattern;
  };
  double heard = 0;
  int count = 0;
  for (const Scatterer& s : ping.scatterers.items) {
    if (s.instance != school) continue;
    heard += std::norm(std::complex<double>(s.mean)) * s.gain * s.gain;
    ++count;
  }
  CHECK(count == 400);
  double sum = 0, square = 0;
  SchoolSpec many = spec;
  many.fish = 200'000;
  for (const Vec3& fish : fish_of(many, pose, 12345)) {
    const double energy = energy_of(fish);
    sum += energy / many.fish;
    square += energy * energy / many.fish;
  }
  const double error = std::sqrt((square - sum * sum) * (1.0 / 400 + 1.0 / many.fish));
  CHECK(std::abs(heard / 400 - sum) < 4 * error);
  CHECK(error < 0.1 * sum);
}

// Protects the masks: a fish has the two samples beside it in its own sector, unless something else
// is stronger there, and nothing more; where the haze is alone, the haze.
TEST_CASE("school and plankton share the picture", "[figure]") {
  const SceneRun run("fish_school");
  const auto school = id_of(run, "school"), plankton = id_of(run, "plankton");
  const PingResult ping = run.ping(0);
  int fish = 0, haze = 0;
  for (const std::uint16_t id : ping.polar->instance) {
    fish += id == school;
    haze += id == plankton;
  }
  std::set<std::pair<std::uint32_t, int>> near_fish;
  for (const Scatterer& s : ping.scatterers.items) {
    if (s.instance != school) continue;
    const int before = static_cast<int>(s.delay_s * run.session().sonar.bandwidth_hz);
    near_fish.insert({s.beam, before});
    near_fish.insert({s.beam, before + 1});
  }
  CHECK(fish <= static_cast<int>(near_fish.size()));
  CHECK(fish > 0.95 * static_cast<double>(near_fish.size()));
  CHECK(haze > 1000);
}
