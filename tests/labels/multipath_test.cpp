// Labels where echoes come over mirrors as well: they tell of what stands there.
#include <array>
#include <cmath>

#include "catch.h"
#include "core/random.h"
#include "labels/polar.h"
#include "labels/shadow.h"
#include "polar_fixture.h"

using namespace ensonify;

namespace {

// Of one beam at 1 kHz: sample n is n ms.
struct Pixels {
  std::vector<Scatterer> scatterers;
  double noise_power_pa2 = 0;
  bool multipath = true;

  void add(int sample, std::uint32_t instance, double amplitude, std::uint16_t path,
           float elevation_rad = 0) {
    Scatterer s;
    s.delay_s = sample * 1e-3;
    s.gain = 1;
    s.mean = static_cast<float>(amplitude);
    s.instance = instance;
    s.path = path;
    s.key = scatterers.size();
    s.arrival.elevation_rad = elevation_rad;
    s.position_m = {sample * 0.75, 0, 0};
    scatterers.push_back(s);
  }
  LabelledImage image() const {
    test::PolarPing ping(scatterers, 1, 40, 1000, {0, 1, 2, 1});
    std::ranges::fill(ping.pressure, 1.0f);
    std::ranges::fill(ping.clean, 1.0f);
    ping.input.noise_power_pa2 = noise_power_pa2;
    ping.input.multipath = multipath;
    return ping.image(1);
  }
};

}  // namespace

// Protects detectors: an echo over a mirror is no object where it is seen.
TEST_CASE("instance, class and elevation are of direct echoes alone") {
  Pixels pixels;
  pixels.add(5, 1, 1, 0, 0.1f);
  pixels.add(5, 2, 3, 7, 0.4f);   // louder, but bounced
  pixels.add(15, 2, 1, 7, 0.4f);  // alone
  const LabelledImage image = pixels.image();
  CHECK(image.instance[5] == 1);
  CHECK(image.semantic[5] == 1);
  CHECK(image.elevation_rad[5] == Approx(0.1));
  CHECK(image.elevation_std_rad[5] == Approx(0).margin(1e-7));
  CHECK(image.instance_fraction[5] == Approx(1.0 / 10));
  CHECK(image.instance[15] == 0);
  CHECK(image.semantic[15] == 0);
  CHECK(std::isnan(image.elevation_rad[15]));
  CHECK(image.instance_fraction[15] == 0);
}

TEST_CASE("the mask of bounced echoes holds the loudest where they outweigh the direct ones") {
  Pixels pixels;
  pixels.add(5, 1, 1, 0);
  pixels.add(5, 2, 0.8, 3);
  pixels.add(5, 3, 0.7, 3);  // together 1.13 of 1
  pixels.add(15, 1, 1, 0);
  pixels.add(15, 2, 0.7, 1);
  pixels.add(15, 3, 0.7, 2);  // together 0.98
  pixels.add(25, 3, 0.1, 1);
  pixels.add(25, 2, 0.1, 2);  // alone, a tie
  pixels.add(35, 1, 0.1, 0);
  const LabelledImage image = pixels.image();
  CHECK(image.multipath[5] == 2);
  CHECK(image.multipath[15] == 0);
  CHECK(image.multipath[25] == 2);
  CHECK(image.multipath[35] == 0);
  CHECK(image.multipath[20] == 0);
  CHECK(image.instance_fraction[5] == Approx(1 / (1 + 0.64 + 0.49)));
  pixels.noise_power_pa2 = 2;
  for (const std::uint16_t ghost : pixels.image().multipath) CHECK(ghost == 0);
  pixels.multipath = false;
  CHECK(pixels.image().multipath.empty());
}

TEST_CASE("the first return is a direct one") {
  Pixels pixels;
  pixels.add(5, 2, 1, 3);
  pixels.add(15, 1, 1, 0);
  const ScattererList list = sorted_by_beam_and_delay(pixels.scatterers, 1);
  CHECK(first_return_m(list, 1)[0] == Approx(15 * 0.75));
  pixels.scatterers.pop_back();
  CHECK(std::isnan(first_return_m(sorted_by_beam_and_delay(pixels.scatterers, 1), 1)[0]));
}

// Protects shadows: an echo over a mirror does not light what is hidden.
TEST_CASE("a shadow is one whatever bounces into it") {
  Pixels pixels;
  pixels.add(5, 1, 1, 3);
  const ScattererList heard = sorted_by_beam_and_delay(pixels.scatterers, 1);
  Pixels behind;
  behind.add(5, 2, 0.5, 0);
  HiddenEchoes hidden;
  hidden.list = sorted_by_beam_and_delay(behind.scatterers, 1);
  hidden.occluder = {3};
  PolarInput input;
  input.scatterers = &heard;
  input.bandwidth_hz = 1000;
  input.beams = 1;
  input.samples = 40;
  const HiddenLabels labels = hidden_labels({input, hidden, {}, {}}, pixels.image(), Workers(1));
  CHECK(labels.shadow[5] == 3);
}
