#include "acoustics/pulse.h"

#include <algorithm>

#include "acoustics/pattern.h"
#include "acoustics/pulse_fixture.h"
#include "catch.h"

using namespace ensonify;

namespace {

constexpr int kTransform = 2500;
const double kInstants[] = {0, 0.4, 1, 1.6, 2.5, 2.94, 5, 7.7, 12.3, 30.2};

double envelope(const std::vector<std::complex<double>>& spectrum, double x) {
  return std::abs(pulse_at(spectrum, x));
}

// The transform of a band with raised-cosine edges, in closed form: Nyquist's pulse of rate 1 - p.
double tapered_band(double x, double taper) {
  const double u = 2 * taper * x;
  const double edges =
      std::abs(std::abs(u) - 1) < 1e-9 ? kPi / 4 : std::cos(kPi * taper * x) / (1 - u * u);
  return sinc((1 - taper) * x) * edges;
}

double flat_amplitude(double) { return 1; }
double gaussian_amplitude(double x) { return std::exp(-(kPi * x) * (kPi * x)); }
double no_phase(double) { return 0; }

}  // namespace

TEST_CASE("the flat pulse is the tapered band alone") {
  const auto spectrum = pulse_spectrum(with_pulse(PulseShape::flat), 1000);
  const double middle = spectrum[500].real();
  CHECK(envelope(spectrum, 0) == Approx(1).epsilon(1e-12));
  CHECK(spectrum[100].real() == Approx(middle));         // -0.4 b
  CHECK(spectrum[50].real() == Approx(middle / 2));      // -0.45 b
  CHECK(spectrum[0].real() == Approx(0).margin(1e-15));  // -0.5 b
}

// Protects flat and lfm by the closed form of their envelope.
TEST_CASE("flat and chirp pulses in closed form") {
  for (const double taper : {0.05, 0.1, 0.3, 0.5}) {
    const auto chirp = pulse_spectrum(with_lfm(taper), kTransform);
    for (const double x : kInstants) {
      INFO("taper " << taper << ", " << x << " samples");
      // The record is periodic: its neighbours' tails are what the margin is for.
      CHECK(pulse_at(chirp, x).real() == Approx(tapered_band(x, taper)).margin(1e-7));
    }
  }
  CHECK(pulse_spectrum(with_lfm(0.1), 500) == pulse_spectrum(with_pulse(PulseShape::flat), 500));
}

// Protects the windows: a cosine over the band is half an echo a sample earlier and half a later.
TEST_CASE("receiver windows in closed form") {
  struct Terms {
    Window window;
    double one, two, four;  // weight of 1, cos(2 pi x), cos(4 pi x)
  };
  for (const Terms& terms :
       {Terms{Window::hann, 0.5, 0.5, 0}, Terms{Window::hamming, 0.54, 0.46, 0},
        Terms{Window::blackman, 0.42, 0.5, 0.08}}) {
    const auto windowed = pulse_spectrum(with_pulse(PulseShape::flat, terms.window), kTransform);
    const auto shape = [&](double x) {
      return terms.one * tapered_band(x, 0.1) +
             terms.two / 2 * (tapered_band(x - 1, 0.1) + tapered_band(x + 1, 0.1)) +
             terms.four / 2 * (tapered_band(x - 2, 0.1) + tapered_band(x + 2, 0.1));
    };
    for (const double x : kInstants) {
      INFO("window " << static_cast<int>(terms.window) << ", " << x << " samples");
      CHECK(pulse_at(windowed, x).real() == Approx(shape(x) / shape(0)).margin(1e-7));
    }
  }
  // A table and a burst pass the window as well.
  Sonar table = with_table(401, -0.5, 0.5, flat_amplitude, no_phase);
  table.window = Window::hann;
  const auto expected = pulse_spectrum(with_pulse(PulseShape::flat, Window::hann), 500);
  const auto seen = pulse_spectrum(table, 500);
  for (int m = 0; m < 500; ++m) CHECK(std::abs(seen[m] - expected[m]) < 1e-15);
}

// Protects the tone burst: a rectangle as long as the tone, smeared by the tapered band, worked out
// as an integral in time.
TEST_CASE("a tone burst is its rectangle seen through the band") {
  for (const double length : {0.5, 2.99, 29.9}) {  // b T, samples
    const auto spectrum = pulse_spectrum(with_cw(length / 29.9e3), kTransform);
    const auto smeared = [&](double x) {
      const int points = 4000;
      double sum = 0;
      for (int i = 0; i < points; ++i) {
        sum += tapered_band(x + length * ((i + 0.5) / points - 0.5), 0.1);
      }
      return sum / points;
    };
    const double scale = pulse_at(spectrum, 0).real() / smeared(0);
    for (const double x : kInstants) {
      INFO(length << " samples long, at " << x);
      CHECK(pulse_at(spectrum, x).real() == Approx(scale * smeared(x)).margin(1e-6));
    }
  }
}

// Protects the density of scatterers on surfaces, which is one to a cell of this length.
TEST_CASE("the -3 dB width of a pulse") {
  const Sonar gaussian = with_pulse(PulseShape::gaussian);
  CHECK(pulse_width_s(gaussian, kTransform) * 1500 / 2 == Approx(0.0330).epsilon(0.01));
  // A tone is loud from edge to edge, less what the band takes of the edges.
  for (const double length : {29.9, 299.0}) {
    const double width_s = pulse_width_s(with_cw(length / 29.9e3), kTransform);
    CHECK(width_s * 29.9e3 == Approx(length).margin(1));
  }
}

// Protects the number of echoes that an even level needs.
TEST_CASE("a flat band lets echoes be as far apart as its triangular autospectrum tells") {
  // Q_k / Q_0 = 1 - k/M.
  Sonar flat = with_pulse(PulseShape::lfm);
  flat.pulse.taper = 0;
  for (const double level_db : {0.01, 0.1, 0.5}) {
    const double ripple = level_db * std::log(10.0) / 10;
    CHECK(echo_step_samples(flat, 4000, level_db) ==
          Approx(1 / (1 - ripple / std::sqrt(2.0))).epsilon(1e-3));
  }
  CHECK(echo_step_samples(flat, 4000, 10) == 1.5);
  // A Gaussian is not as wide: its echoes may be further apart.
  CHECK(echo_step_samples(with_pulse(PulseShape::gaussian), 4000, 0.01) > 1.01);
}

// Protects the scale: the largest of all instants of the grid is 1, also where the pulse does not
// peak at t = 0.
TEST_CASE("every pulse peaks at one on the grid") {
  const auto curved = [](double x) { return 300 * x * x - 20 * x; };
  for (const Sonar& sonar :
       {with_pulse(PulseShape::gaussian), with_cw(1e-4), with_cw(1e-3, Window::hamming),
        with_table(101, -0.5, 0.5, gaussian_amplitude, curved)}) {
    const int transform = 90;
    const auto spectrum = pulse_spectrum(sonar, transform);
    double highest = 0;
    for (int k = 0; k < 32 * transform; ++k) {
      highest = std::max(highest, envelope(spectrum, k / 32.0));
    }
    INFO("pulse " << static_cast<int>(sonar.pulse.shape));
    CHECK(highest == Approx(1).epsilon(1e-12));
  }
}

// Protects measured pulses: the Gaussian's own spectrum in a table is the Gaussian, of any scale.
TEST_CASE("a table of the Gaussian's spectrum is the Gaussian") {
  const auto spectrum = pulse_spectrum(
      with_table(
          2001, -0.6, 0.6, [](double x) { return 7 * gaussian_amplitude(x); }, no_phase),
      500);
  const auto expected = pulse_spectrum(with_pulse(PulseShape::gaussian), 500);
  for (int m = 0; m < 500; ++m) {
    CHECK(std::abs(spectrum[m] - expected[m]) < 1e-6 * expected[250].real());
  }
}

// Protects interpolation and the table's ends: linear in amplitude and in phase, zero outside.
TEST_CASE("a table is linear between its rows and zero outside them") {
  Sonar sonar = with_pulse(PulseShape::table);
  sonar.bandwidth_hz = 20e3;
  sonar.pulse.table = {{892e3, 1, 0.5}, {900e3, 3, 1.5}, {904e3, 2, -0.5}};
  const auto spectrum = pulse_spectrum(sonar, 20);  // bins of 1 kHz, 890 ... 909
  const std::complex<double> reference = spectrum[10] / std::polar(3.0, 1.5);
  CHECK(std::abs(spectrum[6] / reference - std::polar(2.0, 1.0)) < 1e-12);    // 896 kHz
  CHECK(std::abs(spectrum[11] / reference - std::polar(2.75, 1.0)) < 1e-12);  // 901 kHz
  CHECK(std::abs(spectrum[2] / reference - std::polar(1.0, 0.5)) < 1e-12);    // the first row
  CHECK(std::abs(spectrum[14] / reference - std::polar(2.0, -0.5)) < 1e-12);  // the last row
  for (const int outside : {0, 1, 15, 16, 19}) CHECK(spectrum[outside] == 0.0);
}

// Protects the sign of a table's phase: -2 pi f tau is a delay of tau, written out or wrapped.
TEST_CASE("a table's linear phase moves the pulse by its group delay") {
  for (const double delay : {-12.0, 5.0, 40.0}) {  // samples
    const auto phase = [&](double x) { return -2 * kPi * delay * x; };
    const auto wrapped = [&](double x) { return std::remainder(phase(x), 2 * kPi); };
    const auto plain = pulse_spectrum(with_table(401, -0.5, 0.5, gaussian_amplitude, phase), 500);
    const auto folded =
        pulse_spectrum(with_table(401, -0.5, 0.5, gaussian_amplitude, wrapped), 500);
    CHECK(envelope(plain, delay) == Approx(1).epsilon(1e-9));
    CHECK(envelope(plain, delay + 1) < 0.6);
    CHECK(envelope(plain, delay - 1) < 0.6);
    for (int m = 0; m < 500; ++m) CHECK(std::abs(plain[m] - folded[m]) < 1e-14);
  }
}

// Protects the length of records: how long a pulse rings.
TEST_CASE("the extent of a pulse") {
  CHECK(pulse_extent_s(with_pulse(PulseShape::gaussian)) == 0);
  CHECK(pulse_extent_s(with_pulse(PulseShape::flat)) == 0);
  CHECK(pulse_extent_s(with_lfm(0.1)) == 0);
  CHECK(pulse_extent_s(with_lfm(0.05)) > 0);
  CHECK(pulse_extent_s(with_cw(3e-4)) == 3e-4);
  // Of a table: from the pulse's own tails, in eighths of a sample, rounded outward.
  const auto spectrum = pulse_spectrum(with_pulse(PulseShape::gaussian), 2500);
  double end = 0;
  for (int k = 0; k < 800; ++k) {
    if (amplitude_db(envelope(spectrum, k / 8.0)) > -90) end = (k + 1) / 8.0;
  }
  const auto extent = [](double delay) {  // in samples, of a Gaussian at that delay
    return 29.9e3 * pulse_extent_s(with_table(2001, -0.5, 0.5, gaussian_amplitude,
                                              [=](double x) { return -2 * kPi * delay * x; }));
  };
  CHECK(extent(0) == Approx(2 * end));
  CHECK(extent(0) == Approx(81.5));
  // It holds t = 0: a late or an early pulse counts from there, also one that is later than the
  // first record that is tried is long.
  CHECK(extent(200) == Approx(200 + end));
  CHECK(extent(-200) == Approx(200 + end));
  CHECK(extent(900) == Approx(900 + end));
  // Tables that end with a jump inside the band ring for as long as
  // docs/physics/2_pulse_and_record.md says.
  const Sonar ended = with_table(101, -0.4, 0.4, gaussian_amplitude, no_phase);
  CHECK(29.9e3 * pulse_extent_s(ended) == Approx(8134).margin(1));
  const Sonar narrow = with_table(2, -0.3, 0.3, flat_amplitude, no_phase);
  CHECK(29.9e3 * pulse_extent_s(narrow) == Approx(38973).margin(1));
}

// Protects the noise of chirps: its matched filter gathers b T samples' worth.
TEST_CASE("processing gain") {
  CHECK(processing_gain(with_lfm(0.1)) == Approx(29.9));
  CHECK(processing_gain(with_cw(1e-3)) == 1);
  CHECK(processing_gain(with_pulse(PulseShape::gaussian)) == 1);
}

// Protects expected power: the Fourier series of |s|^2 is |s|^2, also of a pulse that is not real.
TEST_CASE("the autospectrum gives the square of the envelope") {
  for (const Sonar& sonar : {with_pulse(PulseShape::gaussian),
                             with_table(101, -0.5, 0.5, gaussian_amplitude,
                                        [](double x) { return 40 * x * x - 10 * x; })}) {
    const auto spectrum = pulse_spectrum(sonar, 90);
    const auto coefficients = pulse_autospectrum(spectrum);
    for (const double x : {0.0, 0.3, 1.7, 2.9, 44.9, 89.5}) {
      double square = coefficients[0].real();
      for (int k = 1; k < 90; ++k) {
        square += 2 * (coefficients[k] * std::polar(1.0, 2 * kPi * k * x / 90)).real();
      }
      const double s = envelope(spectrum, x);
      CHECK(square == Approx(s * s).margin(1e-12));
    }
  }
}
