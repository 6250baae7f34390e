// Volumes with bounds and extinction, as the fan hears them.
#include <algorithm>
#include <cmath>
#include <complex>

#include "acoustics/pattern.h"
#include "acoustics/propagation.h"
#include "catch.h"
#include "core/units.h"
#include "sonar_fixture.h"
#include "temporary_folder.h"
#include "trace/plain_world.h"
#include "trace/volume.h"
#include "world/density.h"
#include "write_vdb.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

Sonar coarse_sonar() {
  Sonar sonar = test::fan_sonar(9, radians(18), 8, 40);
  sonar.bandwidth_hz = 30e3;  // cells of 0.025 m
  sonar.range_min_m = 0.5;
  return sonar;
}

VolumeEcho echo_of(const Sonar& sonar, const std::vector<Volume>& volumes, const Pose& pose = {},
                   std::vector<Hit> hits = {}, int threads = 2) {
  const Fan fan = make_fan(sonar);
  if (hits.empty()) hits.resize(fan.size());
  return volume_echoes(fan, hits, volumes, pose, sonar, kWater, make_record(sonar, kWater, 0),
                       Workers(threads))[0];
}

Volume posed_box(Vec3 half, double extinction_db_m = 0, Pose pose = {}) {
  return {1, 1e-4, extinction_db_m, DensityBox{half}, pose};
}

double elevation_pattern_square(Vec3 p) {
  const double pattern = line_pattern(std::asin(p.z / length(p)), radians(20));
  return pattern * pattern;
}

// What of the fan's rays ends on a sphere about the sonar: slabs of equal range for all.
std::vector<Hit> sphere_hits(const Sonar& sonar, double range_m) {
  return std::vector<Hit>(make_fan(sonar).size(), Hit{range_m, 1.0f, 1});
}

}  // namespace

// V14 from within a box: what a volume without end gives, to the last bit of a float but one.
TEST_CASE("V14: from inside, a uniform box is the uniform volume") {
  const Sonar sonar = coarse_sonar();
  const auto open = echo_of(sonar, {{1, 1e-4}});
  const Pose pose{{3, -2, 1}, from_roll_pitch_yaw(0.3, -0.2, 2)};
  const auto box = echo_of(sonar, {posed_box({20, 20, 20})}, pose);
  REQUIRE(box.energy.size() == open.energy.size());
  for (std::size_t i = 0; i < open.energy.size(); ++i) {
    REQUIRE(box.energy[i] == Approx(open.energy[i]).epsilon(1e-6));
    REQUIRE(box.elevation_rad[i] == Approx(open.elevation_rad[i]).margin(1e-7));
    REQUIRE(box.elevation_square[i] == Approx(open.elevation_square[i]).epsilon(1e-6));
  }
}

// A single ray through a box from 3 m to 5 m: s_v w r^2 loss^2 times the length within the cell,
// whole between 3.025 and 4.975, half at 3 and at 5, nothing elsewhere.
TEST_CASE("a ray hears a box over the box's own ranges") {
  Sonar sonar = coarse_sonar();
  sonar.beam_count = sonar.rays_elevation = 1;
  sonar.elevation_fan_rad = radians(0.5);
  const auto echo = echo_of(sonar, {posed_box({1, 5, 5})}, {{-4, 0, 0}, {}});
  const double weight = make_fan(sonar).solid_angle_sr[0];
  for (std::size_t n = 0; n < echo.energy.size(); ++n) {
    const double r = sample_range_m(sonar, kWater, static_cast<int>(n));
    const double length = std::max(0.0, std::min(r + 0.0125, 5.0) - std::max(r - 0.0125, 3.0));
    const double loss = r > 0 ? two_way_loss(r, 0.3) : 0;
    INFO(r);
    REQUIRE(echo.energy[n] ==
            Approx(1e-4 * weight * r * r * loss * loss * length).epsilon(1e-5).margin(1e-18));
  }
}

// A slab of 2 dB/m: at depth d the energy is 10^(-2 . 2 d/10) of that without, meaned over the
// cell; behind it a thin sheet of another volume has lost 8 dB over the 2 m.
TEST_CASE("a volume hides itself and what is behind it") {
  Sonar sonar = coarse_sonar();
  sonar.beam_count = sonar.rays_elevation = 1;
  sonar.elevation_fan_rad = radians(0.5);
  const Pose pose{{-4, 0, 0}, {}};
  const auto clear = echo_of(sonar, {posed_box({1, 5, 5})}, pose);
  const auto dense = echo_of(sonar, {posed_box({1, 5, 5}, 2)}, pose);
  for (std::size_t n = 0; n < clear.energy.size(); ++n) {
    const double r = sample_range_m(sonar, kWater, static_cast<int>(n));
    if (r < 3.02 || r > 4.98) continue;
    const double x = 0.025 * 4 * std::log(10) / 10;  // two-way nepers in a cell
    const double mean = std::sinh(x / 2) / (x / 2);
    REQUIRE(dense.energy[n] / clear.energy[n] ==
            Approx(std::pow(10, -4 * (r - 3) / 10) * mean).epsilon(1e-5));
  }
  const Volume sheet = posed_box({0.2, 5, 5}, 0, {{2, 0, 0}, {}});
  const auto alone = echo_of(sonar, {sheet}, pose);
  const auto behind = echo_of(sonar, {sheet, posed_box({1, 5, 5}, 2)}, pose);
  int heard = 0;
  for (std::size_t n = 0; n < alone.energy.size(); ++n) {
    if (alone.energy[n] == 0) continue;
    REQUIRE(behind.energy[n] / alone.energy[n] == Approx(std::pow(10, -0.8)).epsilon(1e-5));
    ++heard;
  }
  CHECK(heard >= 16);
}

// Surfaces, mirrors, targets and fish alike: whatever is in the list, behind 2 m of 3 dB/m, has
// lost 12 dB; before it, nothing; in the middle of it, half.
TEST_CASE("a slab dims what is behind it by its extinction") {
  const Sonar sonar = coarse_sonar();
  const Pose pose{{-4, 1, 2}, from_roll_pitch_yaw(0.1, 0, 0)};
  const std::vector<Volume> slab = {posed_box({1, 50, 50}, 3)};
  std::vector<Scatterer> scatterers;
  for (const double range : {2.0, 4.0, 5.0, 5.7}) {
    Scatterer s;
    s.beam = 4;
    s.delay_s = range;
    s.position_m = {range, 0, 0};
    s.gain = 0.5f;
    scatterers.push_back(s);
  }
  ScattererList list = sorted_by_beam_and_delay(scatterers, 9);
  attenuate(list, slab, pose, sonar, kWater, Workers(2));
  CHECK(list.items[0].gain == 0.5f);
  CHECK(list.items[1].gain == Approx(0.5 * std::pow(10, -6.0 / 20)));
  CHECK(list.items[2].gain == Approx(0.5 * std::pow(10, -12.0 / 20)));
  CHECK(list.items[3].gain == Approx(0.5 * std::pow(10, -12.0 / 20)));
  ScattererList same = sorted_by_beam_and_delay(scatterers, 9);
  attenuate(same, {posed_box({1, 50, 50}), {1, 1e-4}}, pose, sonar, kWater, Workers(2));
  for (const Scatterer& s : same.items) CHECK(s.gain == 0.5f);
}

// Haze without end takes from everything as absorption does.
TEST_CASE("extinction without bounds is absorption") {
  const Sonar sonar = coarse_sonar();
  const Fan fan = make_fan(sonar);
  const std::vector<Hit> hits(fan.size());
  const Record record = make_record(sonar, kWater, 0);
  const auto haze =
      volume_echoes(fan, hits, {{1, 1e-4, 0.4, {}, {}}}, {}, sonar, kWater, record, Workers(2))[0];
  const auto absorbed =
      volume_echoes(fan, hits, {{1, 1e-4}}, {}, sonar, {1500, 0.7}, record, Workers(2))[0];
  for (std::size_t i = 0; i < haze.energy.size(); ++i) {
    REQUIRE(haze.energy[i] == Approx(absorbed.energy[i]).epsilon(1e-4));
  }
}

TEST_CASE("a bounded volume ends at each ray's surface") {
  const Sonar sonar = coarse_sonar();
  const auto open = echo_of(sonar, {posed_box({20, 20, 20})});
  const auto walled = echo_of(sonar, {posed_box({20, 20, 20})}, {}, sphere_hits(sonar, 4));
  for (std::size_t i = 0; i < open.energy.size(); ++i) {
    const double r = sample_range_m(sonar, kWater, static_cast<int>(i % (open.energy.size() / 9)));
    const double share = r < 3.98 ? 1 : r > 4.02 ? 0 : 0.5;  // 4 m is the middle of a cell
    REQUIRE(walled.energy[i] == Approx(share * open.energy[i]).epsilon(1e-5));
  }
}

// The same room as a file and as a box: cells whose rays are inside both agree; the file's outer
// voxels blur the rest by half of one, which leaves the sum over all ranges.
TEST_CASE("an OpenVDB grid of one density is a box") {
  const TemporaryFolder folder;
  VdbGrid grid;  // 40 x 60 x 60 voxels of 0.05 m, centred
  grid.voxel_m = 0.05;
  grid.offset_m = {-0.975, -1.475, -1.475};
  grid.boxes = {{{0, 0, 0}, {39, 59, 59}, 1}};
  write_vdb(folder.path() / "a.vdb", {grid});
  const auto density = load_density_vdb(folder.path() / "a.vdb", "density");
  REQUIRE(density.ok());
  const Sonar sonar = coarse_sonar();
  const Pose pose{{-4, 0, 0}, {}}, turned{{0, 0, 0}, from_roll_pitch_yaw(0, 0, radians(180))};
  const std::shared_ptr<const DensityGrid> shared = std::make_shared<DensityGrid>(*density);
  for (const double extinction : {0.0, 2.0}) {
    const auto file = echo_of(sonar, {{1, 1e-4, extinction, shared, turned}}, pose);
    const auto box = echo_of(sonar, {posed_box({1, 1.5, 1.5}, extinction)}, pose);
    const std::size_t samples = box.energy.size() / 9;
    double of_file = 0, of_box = 0;
    for (std::size_t i = 0; i < box.energy.size(); ++i) {
      const double r = sample_range_m(sonar, kWater, static_cast<int>(i % samples));
      if (r > 3.2 && r < 4.9) REQUIRE(file.energy[i] == Approx(box.energy[i]).epsilon(1e-4));
      if (r < 2.95 || r > 5.3) REQUIRE(file.energy[i] == 0);
      of_file += file.energy[i];
      of_box += box.energy[i];
    }
    CHECK(of_file == Approx(of_box).epsilon(2e-3));
  }
}

// Protects determinism, and all sectors from one bad ray.
TEST_CASE("threads and bad rays change nothing for the others") {
  const Sonar sonar = coarse_sonar();
  const Fan fan = make_fan(sonar);
  const std::vector<Volume> volumes = {posed_box({1, 5, 5}, 2), {2, 1e-5}};
  const Pose pose{{-4, 0, 0}, {}};
  const auto one = echo_of(sonar, volumes, pose, {}, 1);
  const auto four = echo_of(sonar, volumes, pose, {}, 4);
  CHECK(one.energy == four.energy);
  CHECK(one.elevation_rad == four.elevation_rad);
  std::vector<Hit> hits(fan.size());
  for (int e = 0; e < fan.rays_elevation; ++e) {
    hits[ray_index(fan, 2, 0, e)] = {std::nan(""), 1, 1};
    hits[ray_index(fan, 3, 0, e)] = {-1, 1, 1};
  }
  const auto bad = echo_of(sonar, volumes, pose, hits);
  const std::size_t samples = one.energy.size() / 9;
  for (std::size_t i = 0; i < one.energy.size(); ++i) {
    const std::size_t beam = i / samples;
    REQUIRE(bad.energy[i] == (beam == 2 || beam == 3 ? 0.0f : one.energy[i]));
  }
}

// As point targets: the sum over fish of gain^2 ts, each once, none behind a wall.
TEST_CASE("fish echo as points before the first surface") {
  Sonar sonar = coarse_sonar();
  World world;
  SchoolSpec spec{{1, 0.3, 0.2}, 300, -40};
  world.schools.push_back({1, fish_of(spec, {{4, 0, 0}, {}}, 3), -40});
  world.instances.resize(1);
  const auto fish = school_scatterers(world, Tracer(world), {}, sonar, kWater, Workers(2));
  REQUIRE(fish.size() == 300);
  double energy = 0, expected = 0;
  std::vector<std::uint64_t> keys;
  for (const Scatterer& s : fish) {
    CHECK(s.instance == 1);
    CHECK(s.standard_deviation == 0);
    energy += std::norm(std::complex<double>(s.mean)) * s.gain * s.gain;
    keys.push_back(s.key);
    const double pattern = elevation_pattern_square(s.position_m);
    const double loss = two_way_loss(length(s.position_m), 0.3);
    expected += 1e-4 * loss * loss * pattern;
  }
  CHECK(energy == Approx(expected).epsilon(1e-5));
  std::sort(keys.begin(), keys.end());
  CHECK(std::adjacent_find(keys.begin(), keys.end()) == keys.end());
  world.objects.push_back({1, BoxShape{{0.01, 5, 5}, false}, {{4, 0, 0}, {}}, {}});
  const auto before = school_scatterers(world, Tracer(world), {}, sonar, kWater, Workers(2));
  std::size_t nearer = 0;
  for (const Vec3& p : world.schools[0].fish_m) nearer += p.x < 3.99;
  CHECK(before.size() == nearer);
  CHECK(nearer > 100);
  CHECK(nearer < 200);
}
