#include "trace/adaptive.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "acoustics/pulse.h"
#include "catch.h"
#include "core/units.h"
#include "sonar_fixture.h"
#include "trace/echo.h"
#include "trace/piece_echoes.h"
#include "trace/plain_world.h"
#include "trace/scatter.h"

using namespace ensonify;

namespace {

// A level sea bed 2 m below the sonar: cells of the fan pass ever more range as it recedes.
World sea_bed() {
  Material sand;
  sand.reflectivity = 1e-3;
  return world_with(PlaneShape{}, {{0, 0, -2}, {}}, sand);
}

Sonar grazing_sonar(int rays_elevation) {
  return test::fan_sonar(24, radians(6), 20, rays_elevation);
}

const Pose kPose{{0, 0, 0}, from_roll_pitch_yaw(0, radians(12), 0)};

// What one sonar sees of one world.
struct View {
  Sonar sonar;
  World bed = sea_bed();
  Tracer tracer{bed};
  Fan fan;
  std::vector<Hit> hits;
  ResolutionCell cell;
  SurfaceScattering scattering;

  explicit View(const Sonar& s) : View(s, sea_bed()) {}
  View(const Sonar& s, World world)
      : sonar(s),
        bed(std::move(world)),
        fan(make_fan(s)),
        hits(tracer.trace_fan(fan, kPose, s.range_max_m, Workers(1))),
        cell(resolution_cell(s, kWater, make_record(s, kWater, 0).transform)),
        scattering(make_surface_scattering(s, kWater, bed)) {}

  FanMet met() const { return {fan, hits, kPose}; }
  std::vector<std::uint16_t> pieces() const {
    return adaptive_pieces(scattering, cell, met(), Workers(1));
  }
  ScattererList by_need(const Workers& workers) const {
    return adaptive_surface_scatterers(fan, {hits}, cell, tracer, kPose, scattering, workers);
  }
};

double range_of(const Scatterer& s) { return s.delay_s * kWater.sound_speed_m_s / 2; }

// Scatterers within half a cell of a place, beams counted by their own azimuth.
int count_about(const ScattererList& list, const ResolutionCell& cell, double azimuth_rad,
                double range_m) {
  return static_cast<int>(std::ranges::count_if(list.items, [&](const Scatterer& s) {
    return std::abs(s.arrival.azimuth_rad - azimuth_rad) < cell.width_rad / 2 &&
           std::abs(range_of(s) - range_m) < cell.range_m / 2;
  }));
}

}  // namespace

TEST_CASE("a resolution cell is the beam's width by the pulse's half-power width, V3") {
  const Sonar sonar = grazing_sonar(8);
  const ResolutionCell cell = resolution_cell(sonar, kWater, 900);
  CHECK(cell.range_m == Approx(0.0330).epsilon(0.01));
  CHECK(cell.width_rad == sonar.beam_width_rad);
  // A burst is as long as its duration.
  Sonar burst = sonar;
  burst.pulse = {PulseShape::cw, 2e-3, 0.1, {}};
  CHECK(resolution_cell(burst, kWater, 1600).range_m == Approx(1.5).epsilon(0.02));
}

TEST_CASE("the slant of a surface is the slope of a plane's range over the angles") {
  const Vec3 normal = normalized(Vec3{-0.5, 0.3, 0.8});
  const double azimuth = 0.3, elevation = -0.2, range = 7;
  const double height = dot(normal, range * unit_vector(azimuth, elevation));
  const auto plane = [&](double a, double e) { return height / dot(normal, unit_vector(a, e)); };
  const double h = 1e-5;
  const Slant slant = slant_of(normal, range, azimuth, elevation);
  CHECK(slant.azimuth_m ==
        Approx((plane(azimuth + h, elevation) - plane(azimuth - h, elevation)) / (2 * h)));
  CHECK(slant.elevation_m ==
        Approx((plane(azimuth, elevation + h) - plane(azimuth, elevation - h)) / (2 * h)));
}

TEST_CASE("scatterers of a cell are as many as its area of angles holds rays") {
  // So dense that counting them one by one is exact to a few percent.
  View dense(grazing_sonar(40'000));
  const ScattererList list =
      surface_scatterer_list(dense.fan, dense.hits, dense.scattering, Workers(1));
  for (const double range : {8.0, 12.0, 18.0}) {
    const double elevation = -std::asin(2 / range) + radians(12);
    const Vec3 up = rotate(conjugate(kPose.rotation), Vec3{0, 0, 1});
    const double worked_out =
        scatterers_per_cell(dense.sonar, dense.cell, slant_of(up, range, 0, elevation));
    // Four sectors a beam's width, each with its middle half a sector off.
    CHECK(count_about(list, dense.cell, 0, range) == Approx(worked_out).epsilon(0.03));
  }
}

TEST_CASE("rays by need give every resolution cell of a grazing sea bed its scatterers") {
  Sonar sonar = grazing_sonar(60);
  const View plain(sonar);
  const ScattererList few =
      surface_scatterer_list(plain.fan, plain.hits, plain.scattering, Workers(1));
  sonar.rays_per_cell = 20;
  const View view(sonar);
  const ScattererList list = view.by_need(Workers(1));
  for (double range = 6; range < 19.5; range += 0.5) {
    CAPTURE(range);
    // An edge of a cell takes or leaves one ray of each of its four columns.
    CHECK(count_about(list, view.cell, 0, range) >= 16);
  }
  CHECK(count_about(few, view.cell, 0, 15) < 10);
  CHECK(gapped_share(plain.scattering, plain.cell, plain.met()) > 0.5);
  CHECK(gapped_share(view.scattering, view.cell, view.met(), view.pieces()) == 0);
}

TEST_CASE("rays by need keep the expected energy of every stretch of range") {
  Sonar sonar = grazing_sonar(60);
  const auto energy = [](const ScattererList& list, double near, double far) {
    double sum = 0;
    for (const Scatterer& s : list.items) {
      const double amplitude = static_cast<double>(s.standard_deviation) * s.gain;
      if (range_of(s) >= near && range_of(s) < far) sum += amplitude * amplitude;
    }
    return sum;
  };
  const View dense(grazing_sonar(20'000));
  const ScattererList exact =
      surface_scatterer_list(dense.fan, dense.hits, dense.scattering, Workers(2));
  sonar.rays_per_cell = 20;
  const View view(sonar);
  const ScattererList list = view.by_need(Workers(2));
  for (const double near : {6.0, 9.0, 13.0, 17.0, 19.0}) {
    CAPTURE(near);
    CHECK(energy(list, near, near + 0.5) == Approx(energy(exact, near, near + 0.5)).epsilon(0.04));
  }
  CHECK(energy(list, 0, 20) == Approx(energy(exact, 0, 20)).epsilon(2e-3));
}

TEST_CASE("rays by need are the same for any workers, each with a key of its own") {
  Sonar sonar = grazing_sonar(40);
  sonar.rays_azimuth = 2;
  sonar.rays_per_cell = 12;
  const View view(sonar);
  const ScattererList one = view.by_need(Workers(1)), three = view.by_need(Workers(3));
  REQUIRE(one.size() == three.size());
  std::set<std::uint64_t> keys;
  for (std::size_t i = 0; i < one.size(); ++i) {
    REQUIRE(one.items[i].key == three.items[i].key);
    REQUIRE(one.items[i].delay_s == three.items[i].delay_s);
    keys.insert(one.items[i].key);
  }
  CHECK(keys.size() == one.size());
}

TEST_CASE("where rays suffice none is added and the fan's stay as they are") {
  Sonar sonar = grazing_sonar(400);
  sonar.range_max_m = 6;
  sonar.rays_per_cell = 1;
  const View view(sonar);
  const auto pieces = view.pieces();
  CHECK(std::ranges::count(pieces, 1) == std::ssize(pieces));
  const ScattererList plain =
      surface_scatterer_list(view.fan, view.hits, view.scattering, Workers(1));
  const ScattererList list = view.by_need(Workers(1));
  REQUIRE(list.size() == plain.size());
  for (std::size_t i = 0; i < list.size(); ++i) {
    REQUIRE(list.items[i].key == plain.items[i].key);
    REQUIRE(list.items[i].delay_s == plain.items[i].delay_s);
    REQUIRE(list.items[i].standard_deviation ==
            Approx(plain.items[i].standard_deviation).epsilon(1e-6));
  }
}

namespace {

// |s(t)|^2 of a sonar's pulse against range, at steps of c/16b.
struct Envelope {
  std::vector<double> squared;
  double step_m;

  explicit Envelope(const Sonar& sonar)
      : squared(envelope_squared(pulse_spectrum(sonar, 900), 8)),
        step_m(kWater.sound_speed_m_s / (16 * sonar.bandwidth_hz)) {}

  double at(double range_m) const {
    const double place = std::abs(range_m) / step_m, part = place - std::floor(place);
    const auto first = static_cast<std::size_t>(place);
    return (1 - part) * squared[first] + part * squared[first + 1];
  }
};

// The expected power of a beam cell at a range.
double power_at(const ScattererList& list, std::uint32_t beam, double range_m,
                const Envelope& pulse) {
  double sum = 0;
  for (std::size_t i = list.beam_offset[beam]; i < list.beam_offset[beam + 1]; ++i) {
    const Scatterer& s = list.items[i];
    const double amplitude = static_cast<double>(s.standard_deviation) * s.gain;
    sum += amplitude * amplitude * pulse.at(range_of(s) - range_m);
  }
  return sum;
}

// A ball and a thin wire across the fan that lie on the sea bed.
World bed_with_things() {
  World world = sea_bed();
  Material sand;
  sand.reflectivity = 1e-3;
  add_object(world, SphereShape{0.3}, {{9, 0.2, -1.7}, {}}, sand);
  add_object(world, CylinderShape{0.012, 1.5}, {{13, 0, -1.99}, from_roll_pitch_yaw(kPi / 2, 0, 0)},
             sand);
  return world;
}

}  // namespace

TEST_CASE("without a number, rays keep the expected level within its bound") {
  Sonar sonar = grazing_sonar(60);
  sonar.rays_per_cell.reset();
  const View view(sonar), dense(grazing_sonar(20'000));
  const ScattererList list = view.by_need(Workers(2));
  const ScattererList exact =
      surface_scatterer_list(dense.fan, dense.hits, dense.scattering, Workers(2));
  const Envelope pulse(sonar);
  double squares = 0;
  int count = 0;
  for (double range = 6; range < 19; range += 0.011, ++count) {
    const double error_db =
        10 * std::log10(power_at(list, 12, range, pulse) / power_at(exact, 12, range, pulse));
    squares += error_db * error_db;
  }
  CHECK(std::sqrt(squares / count) < kLevelErrorDb);
  sonar.rays_per_cell = 20;
  CHECK(list.size() < View(sonar).by_need(Workers(2)).size() * 0.6);
  CHECK(gapped_share(view.scattering, view.cell, view.met(), view.pieces()) == 0);
}

TEST_CASE("without a number, a ball and a wire are seen in the same beams as with one") {
  Sonar sonar = grazing_sonar(60);
  sonar.rays_per_cell.reset();
  const View view(sonar, bed_with_things());
  const ScattererList list = view.by_need(Workers(3));
  sonar.rays_per_cell = kFineScatterers;
  const View counted(sonar, bed_with_things());
  const ScattererList fine = counted.by_need(Workers(1));
  const auto of = [](const ScattererList& l, std::uint32_t instance) {
    std::set<std::uint32_t> beams;
    double energy = 0;
    for (const Scatterer& s : l.items) {
      if (s.instance != instance) continue;
      beams.insert(s.beam);
      energy += std::pow(static_cast<double>(s.standard_deviation) * s.gain, 2);
    }
    return std::pair(beams, energy);
  };
  // The ball's outline and the wire, which few rays of the fan meet, are as well seen.
  for (const std::uint32_t thing : {2u, 3u}) {
    CAPTURE(thing);
    CHECK(of(list, thing).first == of(fine, thing).first);
    CHECK(of(list, thing).second == Approx(of(fine, thing).second).epsilon(0.1));
  }
  CHECK(list.size() < fine.size() / 2);
}

TEST_CASE("cells at an edge are cut for the surface that needs the most") {
  Sonar sonar = grazing_sonar(60);
  sonar.rays_per_cell = kFineScatterers;
  const View counted(sonar, bed_with_things());
  const std::vector<std::uint16_t> fine = counted.pieces();
  sonar.rays_per_cell.reset();
  const View view(sonar, bed_with_things());
  // As if no cell was cut before.
  const std::vector<std::uint16_t> one(view.hits.size(), 1);
  const std::vector<PieceHits> none(24);
  const auto finer = finer_pieces(view.scattering, view.cell, view.met(), one, none, Workers(2));
  int edges = 0;
  for (std::size_t ray = 60; ray + 60 < one.size(); ++ray) {
    const std::size_t row = ray % 60;
    if (row == 0 || row == 59) continue;
    const auto meets = [&](std::size_t other) {
      return is_usable(view.hits[other], sonar) ? view.hits[other].instance : 0;
    };
    bool differs = false;
    for (const std::size_t beside : {ray - 60, ray - 1, ray + 1, ray + 60}) {
      differs |= meets(beside) != meets(ray);
    }
    if (!differs) continue;
    ++edges;
    std::uint16_t most = 1;
    for (std::size_t at = ray - 1; at <= ray + 1; ++at) {
      if (meets(at) != 0) most = std::max(most, fine[at]);
    }
    CAPTURE(ray);
    CHECK(finer[ray] == most);
  }
  CHECK(edges > 10);
}

TEST_CASE("without a number, a material whose level counts rays keeps their number") {
  Sonar sonar = grazing_sonar(60);
  sonar.rays_per_cell.reset();
  Material sand;
  sand.reflectivity = 1e-3;
  sand.coherent = CoherentModel::rician;
  const auto bed = [&] { return world_with(PlaneShape{}, {{0, 0, -2}, {}}, sand); };
  const View free(sonar, bed());
  sonar.rays_per_cell = kFineScatterers;
  CHECK(free.pieces() == View(sonar, bed()).pieces());
}
