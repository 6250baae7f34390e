// What moves while the sound is under way, against constant velocities solved by hand.
#include "trace/motion.h"

#include <cmath>

#include "acoustics/pattern.h"
#include "acoustics/propagation.h"
#include "catch.h"
#include "core/random.h"
#include "core/units.h"
#include "sonar_fixture.h"
#include "trace/echo.h"
#include "trace/plain_world.h"

using namespace ensonify;

namespace {

constexpr double kC = 1500;
constexpr double kSpan_s = 0.09;

// Straight on from p, turning about z.
PoseTrack straight(Vec3 p, Vec3 v, double turn_rad_s = 0, double yaw_rad = 0) {
  return PoseTrack(
      [=](double t) {
        return Pose{p + t * v, from_roll_pitch_yaw(0, 0, yaw_rad + t * turn_rad_s)};
      },
      0, kSpan_s);
}

Vec3 random_vec(std::uint64_t i, std::uint32_t d, double size) {
  const auto draw = [&](std::uint32_t k) { return size * (2 * uniform(61, 0, i, d + k) - 1); };
  return {draw(0), draw(1), draw(2)};
}

// The larger root of a t^2 - 2 b t - d = 0.
double root(double a, double b, double d) { return (b + std::sqrt(b * b + a * d)) / a; }

// From x, seen from the sonar, which moves at v while the target moves at V: |x + V s| = c s, then
// |y - v tau| = c (tau - s) with y = x + V s.
struct Solved {
  double out_s, delay_s;
};
Solved solved(Vec3 x, Vec3 v, Vec3 target_v) {
  const double c2 = kC * kC;
  const double s = root(c2 - dot(target_v, target_v), dot(x, target_v), dot(x, x));
  const Vec3 y = x + s * target_v;
  return {s, root(c2 - dot(v, v), c2 * s - dot(y, v), dot(y, y) - c2 * s * s)};
}

Sonar moved_sonar(int beams, double fov_rad) { return test::fan_sonar(beams, fov_rad, 60, 1); }

Scatterer echo_at(const Sonar& sonar, double range_m, double azimuth_rad, double elevation_rad) {
  Scatterer s =
      echo_from(range_m, azimuth_rad, elevation_rad, *sector_of(sonar, azimuth_rad), sonar, kWater);
  s.mean = 1;
  s.instance = 1;
  return s;
}

ScattererList one_after(const Sonar& sonar, const std::vector<Scatterer>& echoes,
                        const Movement& movement) {
  return move_echoes(sorted_by_beam_and_delay(echoes, sonar.beam_count), movement, sonar, kWater,
                     Workers(2))
      .list;
}

}  // namespace

TEST_CASE("delays of constant velocities are those of the quadratic equations") {
  double largest = 0;
  for (std::uint64_t i = 0; i < 300; ++i) {
    const Vec3 p = random_vec(i, 0, 100), x = random_vec(i, 3, 30);
    const Vec3 v = random_vec(i, 6, i % 3 == 0 ? 0 : 8);
    const Vec3 target_v = random_vec(i, 9, i % 3 == 1 ? 0 : 8);
    const Movement movement{straight(p, v), {}};
    const PoseTrack object = straight(p + x, target_v, 0.7, 1);
    const Flight flight = direct_flight(movement, &object, x, kC);
    const Solved right = solved(x, v, target_v);
    REQUIRE(std::abs(flight.delay_s - right.delay_s) < 1e-12);
    REQUIRE(flight.out_m == Approx(kC * right.out_s).epsilon(1e-12));
    REQUIRE(flight.out_m + flight.in_m == Approx(kC * right.delay_s).epsilon(1e-12));
    largest = std::max(largest, std::abs(right.delay_s - 2 * length(x) / kC));

    // The shift by its definition, the delay of a ping sent a little sooner or later.
    const auto delay_after = [&](double t) {
      return solved(x + t * (target_v - v), v, target_v).delay_s;
    };
    const auto slope_over = [&](double h) { return (delay_after(h) - delay_after(-h)) / (2 * h); };
    const double slope = (4 * slope_over(2e-4) - slope_over(4e-4)) / 3;
    REQUIRE(std::abs(flight.doppler + slope / (1 + slope)) < 1e-9);
  }
  CHECK(largest > 1e-4);
}

// Protects the sign and size: closing at v shifts by 2v/c, to first order.
TEST_CASE("what closes comes back higher") {
  const Vec3 ahead{10, 0, 0};
  const auto shift = [&](Vec3 sonar_v, Vec3 target_v) {
    const PoseTrack object = straight(ahead, target_v);
    return direct_flight({straight({}, sonar_v), {}}, &object, ahead, kC).doppler;
  };
  CHECK(shift({2, 0, 0}, {}) == Approx(4 / kC).epsilon(2e-3));
  CHECK(shift({}, {-2, 0, 0}) == Approx(4 / kC).epsilon(2e-3));
  CHECK(shift({-2, 0, 0}, {}) == Approx(-4 / kC).epsilon(2e-3));
  CHECK(shift({1, 0, 0}, {-1, 0, 0}) == Approx(4 / kC).epsilon(2e-3));
  CHECK(std::abs(shift({2, 0, 0}, {2, 0, 0})) < 1e-12);
  CHECK(std::abs(shift({0, 2, 0}, {})) < 1e-5);
}

// A turning body throws back from a point that moves on a circle: omega x r towards the sonar.
TEST_CASE("points of a turning object have velocities of their own") {
  const PoseTrack object = straight({20, 0, 0}, {}, 2);
  const Movement movement{straight({}, {}), {}};
  CHECK(direct_flight(movement, &object, {20, 0.5, 0}, kC).doppler ==
        Approx(2 * 2 * 0.5 / kC).epsilon(0.05));
  CHECK(direct_flight(movement, &object, {20, -0.5, 0}, kC).doppler ==
        Approx(-2 * 2 * 0.5 / kC).epsilon(0.05));
}

TEST_CASE("a sonar that turns hears from omega tau aside") {
  const Sonar sonar = moved_sonar(128, radians(64));
  const double omega = radians(40);
  const Movement movement{straight({}, {}, omega), {}};
  const Scatterer before = echo_at(sonar, 45, radians(5.1), 0);
  const ScattererList list = one_after(sonar, {before}, movement);
  REQUIRE(list.size() == 1);
  const Scatterer& s = list.items[0];
  const double expected = radians(5.1) - omega * before.delay_s;
  CHECK(std::abs(static_cast<double>(s.arrival.azimuth_rad) - expected) < 1e-7);
  CHECK(s.departure.azimuth_rad == before.departure.azimuth_rad);
  CHECK(static_cast<int>(s.beam) == *sector_of(sonar, expected));
  CHECK(before.beam - s.beam == 5);  // 2.4 degrees
  CHECK(s.delay_s == Approx(before.delay_s).epsilon(1e-15));
  CHECK(s.doppler == 0.0f);
  CHECK(s.gain == Approx(before.gain).epsilon(1e-6));
}

TEST_CASE("echoes that come in beside the sectors or beyond the ranges are dropped") {
  Sonar sonar = moved_sonar(64, radians(64));
  const Movement turning{straight({}, {}, radians(40)), {}};
  CHECK(one_after(sonar, {echo_at(sonar, 45, radians(-30.5), 0)}, turning).size() == 0);
  CHECK(one_after(sonar, {echo_at(sonar, 45, radians(31.5), 0)}, turning).size() == 1);
  sonar.range_min_m = 10;
  const auto far = echo_at(sonar, 59.95, 0, 0), near = echo_at(sonar, 10.01, 0, 0);
  const Movement back{straight({}, {-3, 0, 0}), {}}, on{straight({}, {3, 0, 0}), {}};
  CHECK(one_after(sonar, {far}, back).size() == 0);
  CHECK(one_after(sonar, {far}, on).size() == 1);
  CHECK(one_after(sonar, {near}, back).size() == 1);
  CHECK(one_after(sonar, {near}, on).size() == 0);
}

// 1/(out in), absorption over both, both directions' share of the elevation pattern.
TEST_CASE("gains are those of the way there and the way back") {
  Sonar sonar = moved_sonar(64, radians(64));
  sonar.transmit_width_rad = radians(50);
  const Vec3 v{3, -2, 6};
  const Scatterer before = echo_at(sonar, 40, 0.1, 0.08);
  const ScattererList list = one_after(sonar, {before}, {straight({5, 6, 7}, v), {}});
  REQUIRE(list.size() == 1);
  const Scatterer& s = list.items[0];
  const Vec3 back = before.position_m - s.delay_s * v;
  CHECK(s.delay_s == Approx(solved(before.position_m, v, {}).delay_s).epsilon(1e-13));
  CHECK(s.received_path_m == Approx(length(back)));
  const double elevation = std::asin(back.z / length(back));
  CHECK(s.arrival.elevation_rad == Approx(elevation).epsilon(1e-5));
  const double pattern = std::sqrt(line_pattern(0.08, sonar.elevation_width_rad) *
                                   line_pattern(elevation, sonar.elevation_width_rad)) *
                         transmit_pattern(0.1, sonar.transmit_width_rad);
  const double gain =
      std::pow(10, -kWater.absorption_db_m * (40 + length(back)) / 20) / (40 * length(back));
  CHECK(s.gain == Approx(gain * pattern).epsilon(2e-6));
  CHECK(s.gain != before.gain);
}

// An echo by way of a mirror comes from an image that rests: the same as a target there.
TEST_CASE("a bounced echo moves as its image does") {
  const Sonar sonar = moved_sonar(64, radians(64));
  const Vec3 v{2, 1, -1};
  const Movement movement{straight({1, 2, 3}, v), {}};
  Scatterer image = echo_at(sonar, 30, 0.2, -0.1);
  Scatterer bounced = image;
  bounced.path = 2;
  const double further_m = 7;  // out by another way
  bounced.delay_s += further_m / kC;
  const Scatterer a = one_after(sonar, {image}, movement).items[0];
  const Scatterer b = one_after(sonar, {bounced}, movement).items[0];
  const double later_s = b.delay_s - a.delay_s - further_m / kC;
  // For 7 m the sonar goes on, towards the image at about 1.6 m/s.
  const double rate = dot(v, unit_vector(0.2, -0.1)) / kC;
  CHECK(later_s == Approx(-rate * further_m / kC).epsilon(0.02));
  CHECK(b.doppler == Approx(a.doppler).epsilon(2e-3));
  CHECK(b.gain ==
        Approx(bounced.gain * std::sqrt(a.gain / image.gain) * std::sqrt(a.gain / image.gain))
            .epsilon(0.01));
}

// Protects list order, keys and where each was; and the object's own track, by instance.
TEST_CASE("moved echoes are sorted again and know where they were") {
  const Sonar sonar = moved_sonar(64, radians(64));
  std::vector<Scatterer> echoes;
  for (int i = 0; i < 3000; ++i) {
    const auto draw = [&](std::uint32_t d) { return uniform(62, 0, i, d); };
    echoes.push_back(
        echo_at(sonar, 5 + 50 * draw(0), radians(63 * draw(1) - 31.5), 0.3 * draw(2) - 0.15));
    echoes.back().key = 100000 + 7 * i;
    echoes.back().instance = 1 + i % 2;
  }
  const ScattererList before = sorted_by_beam_and_delay(echoes, 64);
  Movement movement{straight({}, {1, 0.5, 0}, 0.6), {}};
  movement.object.resize(3);
  movement.object[2] = straight({30, 0, 0}, {-4, 0, 0});
  const MovedEchoes moved = move_echoes(before, movement, sonar, kWater, Workers(3));
  CHECK(moved.list.size() > 2800);
  CHECK(moved.list.size() < 3000);
  for (std::size_t i = 0; i < moved.list.size(); ++i) {
    const Scatterer &s = moved.list.items[i], &was = before.items[moved.origin[i]];
    REQUIRE(s.key == was.key);
    REQUIRE(s.position_m == was.position_m);
    const Vec3 target_v = s.instance == 2 ? Vec3{-4, 0, 0} : Vec3{};
    REQUIRE(std::abs(s.delay_s - solved(was.position_m, {1, 0.5, 0}, target_v).delay_s) < 1e-12);
    REQUIRE(i >= moved.list.beam_offset[s.beam]);
    REQUIRE(i < moved.list.beam_offset[s.beam + 1]);
    if (i > moved.list.beam_offset[s.beam]) REQUIRE(s.delay_s >= moved.list.items[i - 1].delay_s);
  }
  const MovedEchoes again = move_echoes(before, movement, sonar, kWater, Workers(1));
  CHECK(again.origin == moved.origin);
}

TEST_CASE("where nothing moves echoes stay as they are") {
  const Sonar sonar = moved_sonar(64, radians(64));
  const Movement still{straight({3, 4, 5}, {}, 0, 0.4), {}};
  CHECK(rests(still));
  for (const double azimuth : {-0.5, 0.0, 0.31}) {
    const Scatterer before = echo_at(sonar, 23.7, azimuth, 0.07);
    const Scatterer s = one_after(sonar, {before}, still).items[0];
    CHECK(std::abs(s.delay_s - before.delay_s) < 1e-16);
    CHECK(s.beam == before.beam);
    CHECK(s.doppler == 0);
    CHECK(s.gain == Approx(before.gain).epsilon(1e-6));
  }
}
