// Planes of motion from given echoes.
#include "labels/surfaces.h"

#include <atomic>
#include <cmath>

#include "catch.h"
#include "polar_fixture.h"

using namespace ensonify;

namespace {

using test::direct_echo;
using test::kMeterBandwidth_hz;

struct MotionScene : test::PolarPing {
  MotionScene(std::vector<Scatterer> echoes, int beams, int samples)
      : PolarPing(std::move(echoes), beams, samples, kMeterBandwidth_hz, {0, 1, 2, 3}) {}

  // Points go 2.5 samples away and half a beam to starboard; those of instance 2 are hidden by 3,
  // those of instance 3 are none.
  LabelledImage motion(int threads = 2) {
    LabelledImage polar = image(threads);
    add_motion({input,
                [&](std::span<const std::uint32_t> which, std::span<PointMotion> motions) {
                  asked += static_cast<int>(which.size());
                  for (std::size_t i = 0; i < which.size(); ++i) {
                    const Scatterer& s = list.items[which[i]];
                    motions[i] = {};
                    if (s.instance == 3) continue;
                    const double sample = s.delay_s * kMeterBandwidth_hz;
                    motions[i] = {sample, double(s.beam), sample + 2.5, s.beam - 0.5,
                                  PointState::seen, 0};
                    if (s.instance != 2) continue;
                    motions[i].state = PointState::hidden;
                    motions[i].occluder = 3;
                  }
                }},
               Workers(threads), polar);
    return polar;
  }
  std::atomic<int> asked = 0;
};

}  // namespace

// Protects the choice of the point: the strongest echo of the pixel's instance, not the strongest.
TEST_CASE("the point of a pixel is that of its instance's strongest echo") {
  Scatterer over_mirror = direct_echo(0, 10.4, 1, 50);
  over_mirror.path = 1;
  MotionScene scene({direct_echo(0, 9.6, 1, 3), direct_echo(0, 10.2, 1, 4), direct_echo(0, 10.3, 2, 5),
                     over_mirror},
                    1, 20);
  const LabelledImage image = scene.motion();
  REQUIRE(image.instance[10] == 1);
  CHECK(image.point_sample[10] == Approx(10.2).margin(kMotionQuantum));
  CHECK(image.motion_samples[10] == Approx(2.5).margin(kMotionQuantum));
  CHECK(image.motion_beams[10] == Approx(-0.5).margin(kMotionQuantum));
  CHECK(image.motion_state[10] == int(PointState::seen));
  CHECK(image.motion_occluder[10] == 0);
}

TEST_CASE("a hidden point names what hides it, and pixels without points are blank") {
  MotionScene scene({direct_echo(1, 5, 2, 1), direct_echo(1, 12, 3, 1)}, 3, 20);
  const LabelledImage image = scene.motion();
  const auto at = [](int sample, int beam) { return std::size_t(sample) * 3 + std::size_t(beam); };
  CHECK(image.motion_state[at(5, 1)] == int(PointState::hidden));
  CHECK(image.motion_occluder[at(5, 1)] == 3);
  CHECK(image.point_beam[at(5, 1)] == 1);
  for (const std::size_t blank : {at(12, 1), at(5, 0), at(8, 1)}) {
    CHECK(std::isnan(image.point_sample[blank]));
    CHECK(std::isnan(image.motion_beams[blank]));
    CHECK(image.motion_state[blank] == 0);
    CHECK(image.motion_occluder[blank] == 0);
  }
}

TEST_CASE("planes of motion do not depend on threads, and points are asked for once") {
  std::vector<Scatterer> echoes;
  for (std::uint32_t beam = 0; beam < 40; ++beam) {
    for (int k = 0; k < 30; ++k) {
      echoes.push_back(direct_echo(beam, 1 + 1.7 * k, 1 + (beam + std::uint32_t(k)) % 3, 1 + k % 5));
    }
  }
  MotionScene one(echoes, 40, 60), many(echoes, 40, 60);
  const LabelledImage a = one.motion(1), b = many.motion(4);
  CHECK(one.asked <= int(echoes.size()));
  for (std::size_t i = 0; i < a.motion_state.size(); ++i) {
    CHECK(a.motion_state[i] == b.motion_state[i]);
    CHECK((a.point_sample[i] == b.point_sample[i] || std::isnan(a.point_sample[i])));
  }
}
