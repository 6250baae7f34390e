#include "acoustics/pulse.h"

#include <algorithm>

#include "acoustics/pulse_fixture.h"
#include "catch.h"
#include "core/random.h"

using namespace ensonify;

// The numbers of docs/physics/2_pulse_and_record.md, and the promise that a record keeps about its start.
namespace {

constexpr int kGrid = 32;

struct Figures {
  double width = 0;              // -3 dB full width, samples
  double lobe_db = 0, lobe = 0;  // highest side lobe, and where, samples from the middle
  double beyond_db[3] = {};      // highest beyond 10, 20, 30 samples
  double energy = 0;             // b int |s|^2 dt
  double middle_db = 0;          // |s(0)|
};

// Of a pulse that is symmetric about t = 0; `half_length` samples of it are no side lobe.
Figures measure(const Sonar& sonar, double half_length) {
  const int transform = 2500;
  const auto spectrum = pulse_spectrum(sonar, transform);
  const auto squared = envelope_squared(spectrum, kGrid);
  const std::size_t half = squared.size() / 2;
  const auto highest_from = [&](double samples) {
    return std::max_element(squared.begin() + std::lround(samples * kGrid), squared.begin() + half);
  };
  Figures figures;
  std::size_t k = half;
  while (squared[k - 1] < 0.5) --k;
  figures.width = 2 * (k - 1 + (squared[k - 1] - 0.5) / (squared[k - 1] - squared[k])) / kGrid;
  while (squared[k + 1] < squared[k]) ++k;
  const auto lobe = highest_from(static_cast<double>(k) / kGrid);
  figures.lobe_db = 10 * std::log10(*lobe);
  figures.lobe = static_cast<double>(lobe - squared.begin()) / kGrid;
  for (int i = 0; i < 3; ++i) {
    figures.beyond_db[i] = 10 * std::log10(*highest_from(half_length + 10 * (i + 1)));
  }
  for (const auto& bin : spectrum) figures.energy += std::norm(bin) * transform;
  figures.middle_db = 10 * std::log10(squared[0]);
  return figures;
}

struct Row {
  Sonar sonar;
  double half_length;
  double width, width_m, lobe_db, lobe, beyond_db[3], energy, middle_db;
};

void check(const Row& row) {
  const Figures seen = measure(row.sonar, row.half_length);
  INFO(seen.width << " samples, " << seen.width * 1500 / (2 * 29.9e3) << " m, " << seen.lobe_db
                  << " dB at " << seen.lobe << ", beyond " << seen.beyond_db[0] << " "
                  << seen.beyond_db[1] << " " << seen.beyond_db[2] << ", energy " << seen.energy
                  << ", middle " << seen.middle_db);
  CHECK(seen.width == Approx(row.width).margin(0.006));
  CHECK(seen.width * 1500 / (2 * 29.9e3) == Approx(row.width_m).margin(0.00006));
  CHECK(seen.lobe_db == Approx(row.lobe_db).margin(0.06));
  CHECK(seen.lobe == Approx(row.lobe).margin(0.06));
  for (int i = 0; i < 3; ++i) {
    CHECK(seen.beyond_db[i] == Approx(row.beyond_db[i]).margin(0.6));
  }
  CHECK(seen.energy == Approx(row.energy).epsilon(0.0005));
  CHECK(seen.middle_db == Approx(row.middle_db).margin(0.006));
}

}  // namespace

// Protects the table of pulses: range resolution, shadows and gaps behind strong echoes, levels of
// diffuse surfaces (which go with the energy).
TEST_CASE("the figures of every pulse") {
  const Sonar gaussian = with_pulse(PulseShape::gaussian), flat = with_pulse(PulseShape::flat);
  const double half_short = 29.9e3 * 1e-4 / 2, half_long = 29.9e3 * 1e-3 / 2;
  check({gaussian, 0, 1.316, 0.0330, -32.4, 2.94, {-53, -72, -82}, 1.370, 0});
  check({flat, 0, 0.981, 0.0246, -13.5, 1.59, {-40, -59, -70}, 1.080, 0});
  check({with_lfm(0.1), 0, 0.981, 0.0246, -13.5, 1.59, {-40, -59, -70}, 1.080, 0});
  check({with_lfm(0.5), 0, 1.441, 0.0361, -31.5, 2.38, {-71, -89, -99}, 1.500, 0});
  check({with_cw(1e-4), half_short, 2.314, 0.0580, -20.7, 2.66, {-49, -68, -78}, 2.302, 0});
  check({with_cw(1e-3), half_long, 29.275, 0.7343, -21.8, 16.06, {-49, -70, -81}, 25.05, -0.73});
}

// Protects the table of windows.
TEST_CASE("the figures of pulses seen through a window") {
  const auto bell = [](Window window) { return with_pulse(PulseShape::gaussian, window); };
  const auto flat = [](Window window) { return with_pulse(PulseShape::flat, window); };
  check({bell(Window::hann), 0, 1.784, 0.0448, -63.8, 4.66, {-73, -93, -103}, 1.878, 0});
  check({bell(Window::hamming), 0, 1.714, 0.0430, -55.9, 4.16, {-69, -87, -97}, 1.809, 0});
  check({bell(Window::blackman), 0, 1.982, 0.0497, -72.8, 5.66, {-80, -99, -109}, 2.097, 0});
  check({flat(Window::hann), 0, 1.449, 0.0363, -30.7, 2.34, {-58, -81, -91}, 1.507, 0});
  check({flat(Window::hamming), 0, 1.351, 0.0339, -32.9, 2.19, {-57, -74, -84}, 1.406, 0});
  check({flat(Window::blackman), 0, 1.649, 0.0414, -53.1, 3.47, {-65, -87, -97}, 1.731, 0});
}

namespace {

// 416 samples: with 64 of padding they are 480, which is smooth, so that there is no more padding.
constexpr double kShortRange_m = 10.43;

// The highest level, within the first tenth of the record, of an echo in its last sample.
double start_of_record_db(Sonar sonar, double range_m) {
  sonar.range_max_m = range_m;
  const Record record = make_record(sonar, Water{1500, 0}, pulse_extent_s(sonar));
  constexpr int kSteps = 8;
  const auto squared = envelope_squared(pulse_spectrum(sonar, record.transform), kSteps);
  const long count = static_cast<long>(squared.size());
  double highest = 0;
  // Delays end with the range, at most a sample after the last.
  const long end = record.samples * kSteps;
  for (long delay = end - 3 * kSteps / 2; delay <= end; ++delay) {
    for (long sample = 0; sample <= record.samples / 10; ++sample) {
      highest = std::max(highest, squared[((sample * kSteps - delay) % count + count) % count]);
    }
  }
  return 10 * std::log10(highest);
}

}  // namespace

// Protects near samples from far echoes: no pulse comes round a record's end into its start.
TEST_CASE("an echo in the last sample leaves the first tenth below -90 dB") {
  const auto bell = [](double x) { return std::exp(-(kPi * x) * (kPi * x)); };
  const auto late = [](double x) { return -2 * kPi * 150 * x; };
  const auto curved = [](double x) { return 200 * x * x; };
  for (const Window window : {Window::none, Window::hann, Window::hamming, Window::blackman}) {
    for (const double range_m : {kShortRange_m, 60.0}) {
      INFO("window " << static_cast<int>(window) << ", " << range_m << " m");
      for (const PulseShape shape : {PulseShape::gaussian, PulseShape::flat}) {
        CHECK(start_of_record_db(with_pulse(shape, window), range_m) < -90);
      }
      for (const double taper : {0.1, 0.25, 0.5}) {
        CHECK(start_of_record_db(with_lfm(taper, window), range_m) < -90);
      }
      for (const double duration_s : {1e-5, 5e-5, 1e-4, 3e-4, 1e-3, 5e-3}) {
        INFO(duration_s << " s");
        CHECK(start_of_record_db(with_cw(duration_s, window), range_m) < -90);
      }
      Sonar table = with_table(401, -0.5, 0.5, bell, late);
      table.window = window;
      CHECK(start_of_record_db(table, range_m) < -90);
    }
    // Tables so coarse or so curved that the corners between their rows ring on both sides of the
    // echo, further than the short record reaches back.
    for (Sonar table :
         {with_table(401, -0.5, 0.5, bell, curved), with_table(21, -0.5, 0.5, bell, curved)}) {
      table.window = window;
      CHECK(start_of_record_db(table, 60) < -90);
    }
  }
}

// Protects chirps with steeper edges than a tenth of the band: they ring for longer than the plain
// padding, so that their record is longer.
TEST_CASE("steep band edges do not ring into the start of the record") {
  for (const double taper : {0.01, 0.02, 0.05, 0.08}) {
    for (const Window window : {Window::none, Window::hann, Window::hamming, Window::blackman}) {
      INFO("taper " << taper << ", window " << int(window));
      CHECK(start_of_record_db(with_lfm(taper, window), kShortRange_m) < -90);
    }
  }
}

// Protects the peak that every pulse is scaled by: the transforms behind it against the sum that
// they stand for, for lengths with every radix and with a large prime.
TEST_CASE("the envelope on a grid is the sum over the bins") {
  const std::uint64_t key = stream_key(3, Stream::speckle, 0);
  for (const int count : {2, 6, 8, 16, 30, 64, 90, 94, 120, 250}) {
    std::vector<std::complex<double>> spectrum(count);
    for (int m = 0; m < count; ++m) {
      const ComplexDraw draw = complex_normal(key, count, m, 0);
      spectrum[m] = {draw.re, draw.im};
    }
    for (const int oversampling : {1, 3, 4}) {
      const std::vector<double> squared = envelope_squared(spectrum, oversampling);
      REQUIRE(squared.size() == static_cast<std::size_t>(count * oversampling));
      double worst = 0;
      for (std::size_t k = 0; k < squared.size(); ++k) {
        const double expected =
            std::norm(pulse_at(spectrum, static_cast<double>(k) / oversampling));
        worst = std::max(worst, std::abs(squared[k] - expected));
      }
      INFO(count << " bins, " << oversampling << " instants a sample");
      CHECK(worst < 1e-11 * count);  // of about `count` on average
    }
  }
}
