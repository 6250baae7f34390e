// Scatterers on even ground, whose places follow a pattern: the pattern, its level, its coherence.
#include "trace/even_points.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "catch.h"
#include "surface_fixture.h"
#include "synthesis/backend.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

// Of the pattern's density at integer frequencies per period, relative to independent places.
double power_at(int x, int y) {
  std::complex<double> sum = 0;
  for (const EvenPlace& p : even_pattern().places) {
    sum += std::polar(1.0, -2 * kPi * (x * p.x + y * p.y) / EvenPattern::kSide);
  }
  return std::norm(sum) / static_cast<double>(even_pattern().places.size());
}

// Nearly six beam cells to a beam, as the shipped sonar of the paper has.
Sonar dense_sonar(double range_max_m) {
  Sonar sonar = fan_sonar(170, radians(30), range_max_m, 20, radians(40));
  sonar.elevation_width_rad = radians(30);
  return sonar;
}

// Pings over a plane or a terrain, with and without the pattern.
struct Ground {
  SurfaceScene scene;
  Workers workers{2};
  std::unique_ptr<Backend> backend =
      make_cpu_backend({scene.sonar, scene.water, make_record(scene.sonar, scene.water, 0)});

  Ground(World world, Sonar sonar, std::vector<Pose> poses, bool even)
      : scene{std::move(world), std::move(sonar), std::move(poses)} {
    if (even) scene.tiles = tiles(2);
  }

  SurfaceTiles tiles(int threads) const {
    const auto seen_by = [&](std::size_t object) {
      std::vector<Pose> all;
      for (const Pose& pose : scene.poses) all.push_back(pose_in(scene.objects[object], pose));
      return all;
    };
    return surface_tiles(scene.world, {{scene.sonar, kResolution_m, seen_by, spacing()}},
                         Workers(threads));
  }
  EvenSpacing spacing() const {
    return even_spacing(scene.sonar, scene.water,
                        make_record(scene.sonar, scene.water, 0).transform);
  }
  PingSeries series(const ScattererList& list, std::uint64_t key) const {
    const PingTask task{&list, {key, 0, 0, 0, 0}, 0, {}, true};
    PingSeries series;
    backend->synthesize({&task, 1}, {&series, 1}, workers);
    return series;
  }
  int samples() const { return make_record(scene.sonar, scene.water, 0).samples; }
};

World floor_world(double depth_m) {
  return world_of({{1, PlaneShape{}, {{0, 0, -depth_m}, {}}, diffuse()}});
}

// A terrain of small triangles, without its own rise where `rise_m` is 0.
World terrain_world(double rise_m) {
  constexpr int kSide = 100;
  constexpr double kCell_m = 0.15;
  auto mesh = std::make_shared<Mesh>();
  for (int j = 0; j <= kSide; ++j) {
    for (int i = 0; i <= kSide; ++i) {
      const double x = i * kCell_m, y = (j - kSide / 2) * kCell_m;
      mesh->vertices.push_back({static_cast<float>(x), static_cast<float>(y),
                                static_cast<float>(rise_m * std::sin(x) * std::cos(y))});
    }
  }
  const auto at = [](int i, int j) { return static_cast<std::uint32_t>(j * (kSide + 1) + i); };
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) {
      mesh->triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
      mesh->triangles.push_back({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return world_of({{1, MeshShape{std::move(mesh), true}, {{0, 0, -2}, {}}, diffuse()}});
}

const Pose kDown{{0, 0.1, 0}, from_roll_pitch_yaw(0, radians(18), 0)};

struct LevelError {
  double rms_db = 0;
  std::size_t scatterers = 0;
};

// Against 300 scatterers in each cell, where the floor is within 20 dB of its maximum.
LevelError level_error(const World& world, bool even) {
  Sonar many = dense_sonar(9);
  many.rays_per_cell = 300;
  const Ground exact(world, many, {kDown}, false), ground(world, dense_sonar(9), {kDown}, even);
  const ScattererList list = ground.scene.at(kDown);
  const auto truth = exact.series(exact.scene.at(kDown), 1).clean_power_pa2,
             power = ground.series(list, 1).clean_power_pa2;
  const float least = *std::ranges::max_element(truth) / 100;
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    // The pulse and the beams reach beyond the outermost cells, which have none beside them.
    const auto beam = static_cast<int>(i / static_cast<std::size_t>(ground.samples()));
    if (truth[i] < least || beam < 20 || beam >= 150) continue;
    const double error = 10 * std::log10(power[i] / truth[i]);
    sum += error * error;
    ++count;
  }
  CHECK(count > 20'000);
  return {std::sqrt(sum / count), list.size()};
}

}  // namespace

// Protects the level: no noise at the frequencies that beams and pulse let through. Protects
// coherence: no peak, as a lattice of as many points would have 1,024.
TEST_CASE("the pattern has neither slow changes of density nor a lattice") {
  double slow = 0, highest = 0;
  for (int x = 0; x <= 40; ++x) {
    for (int y = -40; y <= 40; ++y) {
      if (x == 0 && y == 0) continue;
      const double power = power_at(x, y);
      if (std::hypot(x, y) < 0.5 * EvenPattern::kSide) slow = std::max(slow, power);
      highest = std::max(highest, power);
    }
  }
  CHECK(slow < 0.05);
  CHECK(highest < 100);
}

TEST_CASE("the places of the pattern are found in their cells") {
  const EvenPattern& pattern = even_pattern();
  std::size_t count = 0;
  for (std::int64_t y = 0; y < EvenPattern::kSide; ++y) {
    for (std::int64_t x = 0; x < EvenPattern::kSide; ++x) {
      for (const EvenPlace& place : pattern.cell(x, y)) {
        ++count;
        REQUIRE(std::floor(place.x) == static_cast<double>(x));
        REQUIRE(std::floor(place.y) == static_cast<double>(y));
      }
    }
  }
  CHECK(count == pattern.places.size());
}

// Protects the density: longer pulses and wider beams need fewer scatterers.
TEST_CASE("places are further apart for wider beams and longer pulses") {
  const Water water{1500, 0};
  Sonar sonar = dense_sonar(6);
  const EvenSpacing even = even_spacing(sonar, water, 300);
  CHECK(even.at(0.3) > 1.3 * even.at(0.1));
  CHECK(even.at(1e3) == even.at(1e2));
  CHECK(even.at(0) == even.spacing_m.front());
  sonar.bandwidth_hz /= 4;
  CHECK(even_spacing(sonar, water, 300).at(0.4) == Approx(4 * even.at(0.1)).epsilon(0.02));
  for (const double spacing_m : {0.003, 0.02, 1.0, 1.5}) {
    const double discrete = even_spacing_of(even_scale(spacing_m));
    CHECK(discrete <= spacing_m * (1 + 1e-12));
    CHECK(discrete > 0.84 * spacing_m);
  }
}

// Protects the expected level, which is off by 0.086 dB with twenty or more independent places in a
// cell. The pattern leaves 0.046 dB, most of it from the steps of beam
// cells.
TEST_CASE("the level of a floor is more even with fewer scatterers", "[figure]") {
  const LevelError even = level_error(floor_world(2), true),
                   leaves = level_error(floor_world(2), false);
  INFO(even.scatterers << " of " << leaves.scatterers << ", " << even.rms_db << " dB of "
                       << leaves.rms_db);
  CHECK(even.rms_db < 0.05);
  CHECK(leaves.rms_db > 1.3 * even.rms_db);
  CHECK(static_cast<double>(even.scatterers) < 0.75 * static_cast<double>(leaves.scatterers));
}

// The pattern continues from triangle to triangle, of which most hold less than ten places.
TEST_CASE("the level of a terrain is as even as that of a plane", "[figure]") {
  CHECK(level_error(terrain_world(0), true).rms_db < 0.06);
  CHECK(level_error(terrain_world(0.3), true).rms_db < 0.06);
}

// Protects the level of every part: areas add up on terrain of any slope, and keys are unique.
TEST_CASE("the leaves of the pattern add up to the surface") {
  const Ground ground(terrain_world(0.3), dense_sonar(8), {{{1, 0, 0}, kDown.rotation}}, true);
  double leaves = 0, surface = 0;
  std::set<std::uint64_t> keys;
  std::size_t count = 0;
  for (const SurfaceTile& tile : ground.scene.tiles.tiles) {
    REQUIRE(tile.axis == 2);
    surface += area_m2(std::get<TrianglePatch>(tile.patch));
    leaves_of(tile, 7, [&](const SurfaceLeaf& leaf) {
      leaves += leaf.area_m2;
      keys.insert(leaf.key);
      ++count;
    });
  }
  CHECK(surface > 10);
  CHECK(leaves == Approx(surface).epsilon(2e-3));
  CHECK(keys.size() == count);
}

// Protects identity and reproducibility: scatterers stay on the ground while the sonar moves,
// whichever ping comes first and however many threads there are, and other keys move them.
TEST_CASE("places of the pattern depend on neither threads nor the order of pings") {
  const Pose first = kDown, second{{0.3, 0.4, 0.1}, from_roll_pitch_yaw(0.02, 0.3, 0.1)};
  Ground ground(floor_world(1.5), dense_sonar(5), {first, second}, true);
  const SurfaceScene& scene = ground.scene;
  const auto places = [](const ScattererList& list, const Pose& pose) {
    std::vector<std::pair<std::uint64_t, Vec3>> all;
    for (const Scatterer& s : list.items) {
      all.emplace_back(s.key, transform_point(pose, s.position_m));
    }
    std::ranges::sort(all, {}, [](const auto& place) { return place.first; });
    return all;
  };
  const auto same = [](const ScattererList& a, const ScattererList& b) {
    return std::ranges::equal(a.items, b.items, [](const Scatterer& x, const Scatterer& y) {
      return x.key == y.key && x.position_m == y.position_m && x.gain == y.gain;
    });
  };
  const ScattererList before = scene.at(second, 1, 1), list = scene.at(first, 1, 1);
  CHECK(list.size() > 10'000);
  CHECK(same(list, scene.at(first, 1, 3)));
  CHECK(same(before, scene.at(second, 1, 2)));
  ground.scene.tiles = ground.tiles(1);
  CHECK(same(list, scene.at(first, 1, 1)));

  const auto a = places(list, first), b = places(before, second);
  std::size_t both = 0;
  for (const auto& [key, place] : a) {
    const auto found = std::ranges::lower_bound(b, key, {}, [](const auto& p) { return p.first; });
    if (found == b.end() || found->first != key) continue;
    ++both;
    REQUIRE(length(found->second - place) < 1e-9);
  }
  CHECK(both > a.size() / 2);
  std::size_t moved = 0;
  const auto other = places(scene.at(first, 2, 1), first);
  for (const auto& [key, place] : other) {
    const Vec3 here = place;
    moved += std::ranges::none_of(a, [&](const auto& p) { return length(p.second - here) < 1e-6; });
    if (moved > 100) break;
  }
  CHECK(moved > 100);
}

// What speckle on surfaces is for, by (S1): the coherence of two pings falls with the overlap of
// the apertures, and none returns further away, as it would with a lattice.
TEST_CASE("pings over even ground are as coherent as their apertures overlap") {
  const double wavelength = 1500 / 900e3, aperture = 0.884 * wavelength / radians(1);
  const auto at = [](double side_m) { return Pose{{0, side_m, 0}, kDown.rotation}; };
  const std::vector<double> shifts{0.25, 0.5, 0.75, 1.3, 2, 2.6, 3.3};  // of half an aperture
  std::vector<Pose> poses;
  for (const double shift : shifts) {
    poses.push_back(at(-shift * aperture / 4));
    poses.push_back(at(shift * aperture / 4));
  }
  const Ground ground(floor_world(1.5), dense_sonar(6.5), poses, true);
  const int samples = ground.samples();
  for (std::size_t i = 0; i < shifts.size(); ++i) {
    const auto series = [&](const Pose& pose) {
      return ground.series(ground.scene.at(pose, 1), 1).pressure_pa;
    };
    const auto first = series(poses[2 * i]), second = series(poses[2 * i + 1]);
    std::complex<double> product = 0;
    double power_first = 0, power_second = 0;
    for (int beam = 20; beam < 150; ++beam) {
      const double azimuth =
          (beam + 0.5 - ground.scene.sonar.beam_count / 2.0) * ground.scene.sonar.beam_spacing_rad;
      for (int n = 180; n < 255; ++n) {
        const double range = n * 1500 / (2 * ground.scene.sonar.bandwidth_hz);
        // The angle of the floor from the horizontal, less that of the sonar.
        const double elevation = radians(18) - std::asin(1.5 / range);
        const double turn = 4 * kPi / wavelength * shifts[i] * aperture / 2 * std::cos(elevation) *
                            std::sin(azimuth);
        const auto pixel = static_cast<std::size_t>(beam) * static_cast<std::size_t>(samples) +
                           static_cast<std::size_t>(n);
        const std::complex<double> a = first[pixel],
                                   b = std::complex<double>(second[pixel]) * std::polar(1.0, -turn);
        product += a * std::conj(b);
        power_first += std::norm(a);
        power_second += std::norm(b);
      }
    }
    INFO("shift " << shifts[i]);
    const double coherence = std::abs(product) / std::sqrt(power_first * power_second);
    CHECK(coherence == Approx(std::max(0.0, 1 - shifts[i])).margin(0.07));
  }
}
