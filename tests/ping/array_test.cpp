// The receiver from the scenario to the series: the array of elements, noise against signal,
// matched filter and converter.
#include <cmath>
#include <complex>
#include <limits>

#include "catch.h"
#include "core/units.h"
#include "ping/array_receiver.h"
#include "ping/pipeline.h"
#include "ping/prepare_session.h"
#include "ping/sequence_info.h"
#include "ping/session.h"
#include "ping/tables.h"
#include "run/cost.h"
#include "run_scene.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

// Few beams, elements and samples: the reference backend sums element by element.
const std::string kScene = R"(ensonify: 1
seed: 5
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 1.4
  beams: {count: 6, fov_deg: 24, receive_width_deg: 8}
  rays: {elevation: 4}
  receiver: {mode: array}
water: {absorption: {fixed_db_m: 0.3}}
materials: {wall: {reflectivity: 1e-3}, mirror: {reflectivity: 1e-2, coherent: {model: rician, k: 1}}}
objects:
  - {name: room, material: wall, shape: {box: {size_m: [2.4, 2.4, 2], inward_facing: true}}}
  - {name: ball, material: mirror, shape: {sphere: {radius_m: 0.1}}, pose: {position_m: [0.9, 0, 0]}}
output: {cartesian: false, png: false}
)";

Result<Session> session_of(const std::vector<Override>& overrides, std::uint32_t sequence = 0) {
  return prepare_session(value_of(parse_scenario(kScene, "array.yaml", ".", overrides, sequence)),
                         sequence);
}

ArrayReceiver array_of(const std::vector<Override>& overrides, std::uint32_t sequence = 0) {
  return value_of(value_of(session_of(overrides, sequence)).sonar.array);
}

PingResult ping_of(const std::vector<Override>& overrides) {
  const Numerics reference{BackendChoice::reference, best_simd_level(), "reference"};
  return SceneRun::of_text(kScene, overrides, reference).ping(0);
}

}  // namespace

// Protects the defaults: half a wavelength of the water at hand, and the aperture of the beam.
TEST_CASE("an array's elements follow from width, shading and sound speed") {
  const ArrayReceiver plain = array_of({{"sonar.beams.receive_width_deg", "1"}});
  CHECK(plain.elements == 101);
  CHECK(plain.spacing_m == Approx(1500 / 900e3 / 2));
  const ArrayReceiver warm = array_of(
      {{"water.sound_speed_m_s", "{from: {temperature_c: 25, salinity_psu: 35, depth_m: 0}}"}});
  CHECK(warm.spacing_m == Approx(1534.4 / 900e3 / 2).epsilon(1e-3));
  CHECK(warm.elements == array_of({}).elements);
  // The raised cosine is 1.626 times as long for the same width.
  const ArrayReceiver shaded =
      array_of({{"sonar.beams.receive_width_deg", "1"}, {"sonar.beams.shading", "hann"}});
  CHECK(shaded.shading.kind == Shading::hann);
  CHECK(shaded.elements == Approx(165).margin(1));
  CHECK(array_of({{"sonar.receiver.shading", "hann"}}).shading.kind == Shading::hann);
  CHECK(array_of({{"sonar.receiver.elements", "7"}}).elements == 7);
  CHECK(array_of({{"sonar.beams.receive_width_deg", "170"}}).elements == 1);
}

TEST_CASE("an array that cannot be is told with its key") {
  const auto fault = [](const std::vector<Override>& overrides) {
    return message_of(session_of(overrides));
  };
  CHECK(fault({{"sonar.beams.receive_width_deg", "0.02"}})
            .find("sonar.receiver.elements: a beam of") == 0);
  CHECK(fault({{"sonar.receiver.dead", "[14]"}}).find("sonar.receiver.dead: there is no element") ==
        0);
  CHECK(fault({{"sonar.receiver.dead", "[12]"}}).empty());
}

// 4096 elements: standard errors 1.1 % of the deviations and 0.016 of the correlation.
TEST_CASE("errors of elements have their deviation and belong to the seed") {
  const std::vector<Override> errors = {{"sonar.receiver.elements", "4096"},
                                        {"sonar.receiver.gain_error_db", "0.5"},
                                        {"sonar.receiver.phase_error_deg", "6"},
                                        {"sonar.receiver.dead", "[7, 4095]"}};
  const ArrayReceiver array = array_of(errors);
  double gain = 0, phase = 0, both = 0;
  for (const std::complex<double>& r : array.response) {
    if (r == 0.0) continue;
    const double g = 20 * std::log10(std::abs(r)), p = degrees(std::arg(r));
    gain += g * g / 4094;
    phase += p * p / 4094;
    both += g * p / 4094;
  }
  CHECK(std::sqrt(gain) == Approx(0.5).epsilon(0.034));
  CHECK(std::sqrt(phase) == Approx(6).epsilon(0.034));
  CHECK(both / std::sqrt(gain * phase) == Approx(0).margin(0.048));
  CHECK(array.response[7] == 0.0);
  CHECK(array.response[4095] == 0.0);
  CHECK(array_of(errors, 3).response == array.response);
  std::vector<Override> other = errors;
  other.push_back({"seed", "6"});
  CHECK(array_of(other).response != array.response);
  for (const std::complex<double>& r : array_of({}).response) CHECK(r == 1.0);
}

// Protects the layers: each goes through the array, the noise as well, and they add up; and the
// channels, which hold all of them.
TEST_CASE("layers of an array add up, and channels are written") {
  const PingResult ping = ping_of({{"noise.spectrum_level_db", "90"},
                                   {"volumes", "[{name: water, uniform: {strength_db: -50}}]"},
                                   {"output.layers", "true"},
                                   {"output.channels", "true"},
                                   {"sonar.receiver.dead", "[2]"}});
  REQUIRE(ping.layers.size() == 4);
  double worst = 0, largest = 0;
  for (std::size_t i = 0; i < ping.series.size(); ++i) {
    std::complex<double> sum = 0;
    for (const LayerSeries& layer : ping.layers) sum += std::complex<double>(layer.pressure_pa[i]);
    worst = std::max(worst, std::abs(sum - std::complex<double>(ping.series[i])));
    largest = std::max<double>(largest, std::abs(ping.series[i]));
  }
  CHECK(worst < 1e-6 * largest);
  for (const LayerSeries& layer : ping.layers) {
    double power = 0;
    for (const auto& p : layer.pressure_pa) power += std::norm(p);
    INFO(layer_name(layer.layer));
    CHECK(power > 0);
  }
  const std::size_t samples = ping.series.size() / 6;
  REQUIRE(ping.channels.size() == 13 * samples);
  for (std::size_t n = 0; n < 13; ++n) {
    double power = 0;
    for (std::size_t k = 0; k < samples; ++k) power += std::norm(ping.channels[n * samples + k]);
    CHECK((power > 0) == (n != 2));
  }
  CHECK(ping_of({}).channels.empty());
}

// Protects the scale of hidden echoes: the mean of what a beam of sound elements at half a
// wavelength hears is that of the beam model, whose pattern it has; errors and width change it.
TEST_CASE("hidden power of an array is that of its pattern") {
  const std::vector<Override> fine = {
      {"sonar.beams", "{count: 200, fov_deg: 40, receive_width_deg: 1}"}};
  const auto power_of = [&](std::vector<Override> more) {
    more.insert(more.begin(), fine.begin(), fine.end());
    const Session session = value_of(session_of(more));
    return hidden_power(session.sonar, session.water, session.record).per_energy;
  };
  const std::vector<double> array = power_of({});
  const std::vector<double> beams = power_of({{"sonar.receiver.mode", "beams"}});
  CHECK(array[100] / beams[100] == Approx(1).epsilon(0.02));
  const std::vector<double> wide = power_of({{"sonar.receiver.element_width_m", "1.6666667e-3"}});
  CHECK(wide[100] / array[100] == Approx(1).epsilon(0.02));
  const double edge = std::sin(radians(18.0)) * kPi;
  CHECK(wide[190] / array[190] == Approx(std::pow(std::sin(edge) / edge, 2)).epsilon(0.02));
  const std::vector<double> one = power_of({{"sonar.receiver.elements", "1"}});
  CHECK(one[3] == Approx(200 * std::pow(10.0, (220 - 120) / 10.0)));
}

// Protects the comparison of hidden echoes with the noise where cells are unequal: with the same
// energy in an angle, a beam hears the same however the fan is cut.
TEST_CASE("hidden power does not depend on how the fan is cut into cells") {
  const auto power_of = [](const std::string& beams, const std::string& mode) {
    const Session session =
        value_of(session_of({{"sonar.beams", beams}, {"sonar.receiver.mode", mode}}));
    const HiddenPower power = hidden_power(session.sonar, session.water, session.record);
    return power.per_energy[50] * cell_width_rad(session.sonar, 50);
  };
  std::string azimuths;
  for (int j = 0; j < 101; ++j) {
    azimuths += (j == 0 ? "" : ", ") + std::to_string(0.2 * (j - 50) + (j % 3 - 1) * 0.04);
  }
  const std::string equal = "{count: 101, fov_deg: 20.2, receive_width_deg: 1}";
  const std::string width = ", receive_width_deg: 1}";
  CHECK(power_of("{count: 101, azimuths_deg: [" + azimuths + "]" + width, "beams") ==
        Approx(power_of(equal, "beams")).epsilon(0.01));
  CHECK(power_of("{count: 101, azimuths_deg: [" + azimuths + "]}", "array") ==
        Approx(power_of("{count: 101, fov_deg: 20.2}", "array")).epsilon(0.01));
}

TEST_CASE("the cost of channels is announced") {
  const auto plain = session_of({{"sonar.receiver.elements", "100"}});
  const auto channels =
      session_of({{"sonar.receiver.elements", "100"}, {"output.channels", "true"}});
  REQUIRE((plain.ok() && channels.ok()));
  const Cost a = estimate_cost(*plain, 0), b = estimate_cost(*channels, 0);
  CHECK(b.files == a.files + 1);
  CHECK(b.disk_bytes == a.disk_bytes + 800 * channels->record.samples);
}

namespace {

const std::vector<Override> kSmallFan = {
    {"sonar.beams", "{count: 64, fov_deg: 60, receive_width_deg: 2}"},
    {"sonar.rays.elevation", "20"}};

std::vector<Override> small_with(std::vector<Override> more) {
  more.insert(more.begin(), kSmallFan.begin(), kSmallFan.end());
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
                    Catch::Contains("noise.snr_db: ping 0 has no echo"));
}

// Protects the gain of a chirp: b T = 29.9 kHz x 1 ms = 14.757 dB less noise, the echo unchanged.
TEST_CASE("a matched filter lowers the noise by its gain", "[figure]") {
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
