// Noise against signal, matched filter and converter, from scenario to series.
#include <cmath>
#include <limits>

#include "catch.h"
#include "core/units.h"
#include "run_scene.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

const std::vector<Override> kSmall = {{"sonar.beams", "{count: 64, fov_deg: 60, width_deg: 2}"},
                                      {"sonar.rays.elevation", "20"}};

std::vector<Override> small_with(std::vector<Override> more) {
  more.insert(more.begin(), kSmall.begin(), kSmall.end());
  return more;
}

}  // namespace

// Protects the shortcut: the noise stands snr_db under the mean clean power of the pixels of ping 0
// that hear an echo, here taken from the finished image.
TEST_CASE("snr_db is measured against the pixels with an echo") {
  const SceneRun run("sonar_tank", small_with({{"noise.snr_db", "20"}}));
  const LabelledImage polar = *run.ping(0).polar;
  double power = 0;
  int count = 0;
  for (std::size_t i = 0; i < polar.clean_db.size(); ++i) {
    if (!std::isfinite(polar.elevation_rad[i])) continue;
    power += mean_square_pa2(polar.clean_db[i]);
    ++count;
  }
  REQUIRE(count > 100);
  const double snr_db = 10 * std::log10(power / count / run.info().noise_power_pa2);
  CHECK(snr_db == Approx(20).margin(1e-4));
}

TEST_CASE("snr_db without any echo is refused") {
  CHECK_THROWS_WITH(SceneRun("sonar_tank", small_with({{"noise.snr_db", "20"}, {"objects", "[]"}})),
                    Catch::Contains("noise.snr_db: ping 0 hears no echo"));
}

// Protects the gain of a chirp: b T = 29.9 kHz x 1 ms = 14.757 dB less noise, the echo unchanged.
TEST_CASE("a matched filter lowers the noise by its gain") {
  const SceneRun plain("sonar_tank", {{"noise.spectrum_level_db", "30"}});
  const SceneRun chirp("sonar_tank", {{"noise.spectrum_level_db", "30"},
                                      {"sonar.pulse", "{lfm: {duration_s: 1.0e-3}}"}});
  CHECK(10 * std::log10(plain.info().noise_power_pa2 / chirp.info().noise_power_pa2) ==
        Approx(14.757).margin(1e-3));
}

// Protects the converter's place: behind the noise, before the images, and not on the clean level.
TEST_CASE("the converter quantises series and level") {
  const std::vector<Override> noise = {{"noise.spectrum_level_db", "60"}};
  const std::vector<Override> with_adc = {noise[0],
                                          {"sonar.receiver.adc", "{bits: 8, full_scale_db: 140}"}};
  const PingResult analog = SceneRun("sonar_tank", small_with(noise)).ping(0);
  const PingResult digital = SceneRun("sonar_tank", small_with(with_adc)).ping(0);
  const double full_scale = 10.0, step = full_scale / 128;
  int clipped = 0;
  for (std::size_t i = 0; i < digital.series.size(); ++i) {
    for (const bool real : {true, false}) {
      const auto steps = [&](std::complex<float> p) { return (real ? p.real() : p.imag()) / step; };
      const double q = steps(digital.series[i]), x = steps(analog.series[i]);
      REQUIRE(q == Approx(std::round(q)).margin(1e-4));
      REQUIRE((q >= -128.0001 && q <= 127.0001));
      if (x > 127.5 || x < -128.5) {
        ++clipped;
      } else {
        REQUIRE(std::abs(q - x) <= 0.5 + 1e-4);
      }
    }
  }
  CHECK(clipped > 10);
  CHECK(digital.polar->clean_db == analog.polar->clean_db);
  CHECK(digital.polar->level_db != analog.polar->level_db);
}
