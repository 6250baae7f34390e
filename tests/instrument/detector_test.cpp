// The levels of a detector against closed forms: the gamma law of looks, whose dB moments are
// polygamma functions, the means of each law, and what noise and floor add.
#include "instrument/detector.h"

#include <algorithm>
#include <cmath>

#include "acoustics/pulse.h"
#include "catch.h"
#include "core/random.h"
#include "sonar_fixture.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

constexpr double kDbPerNeper = 4.342944819032518;  // 10 / ln 10, of power
constexpr double kEuler = 0.5772156649015329, kZeta3 = 1.2020569031595943;

// psi, psi_1 and psi_2 of a whole number.
struct Polygamma {
  explicit Polygamma(int k) : psi(-kEuler), psi1(kPi * kPi / 6), psi2(-2 * kZeta3) {
    for (double i = 1; i < k; ++i) {
      psi += 1 / i;
      psi1 -= 1 / (i * i);
      psi2 += 2 / (i * i * i);
    }
  }
  double psi, psi1, psi2;
};

struct Statistics {
  double mean = 0, spread = 0, skew = 0;
};

template <class Value>
Statistics statistics(std::size_t count, Value value) {
  Statistics s;
  for (std::size_t i = 0; i < count; ++i) s.mean += value(i) / static_cast<double>(count);
  double second = 0, third = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double off = value(i) - s.mean;
    second += off * off / static_cast<double>(count);
    third += off * off * off / static_cast<double>(count);
  }
  s.spread = std::sqrt(second);
  s.skew = third / (second * s.spread);
  return s;
}

Statistics statistics(const std::vector<double>& values) {
  return statistics(values.size(), [&](std::size_t i) { return values[i]; });
}

struct DetectedBeams {
  explicit DetectedBeams(int beams, double range_m = 20)
      : sonar(p900(beams, beams * 0.1, range_m)) {
    sonar.detector.emplace();
    record = make_record(sonar, water, 1e-4);
  }
  Detector& detector() { return *sonar.detector; }
  SampleArray<float> levels(const Series& p, PingMoment moment = {5, 0, 0, 0},
                            int threads = 1) const {
    std::optional<SubBands> bands;
    if (sonar.detector->looks > 1) bands.emplace(sonar, record);
    return detected_levels_db({sonar, record, bands ? &*bands : nullptr, moment}, p,
                              Workers(threads));
  }
  Series silence() const { return Series(std::size_t(sonar.beam_count) * record.samples); }
  // Independent samples with E|p|^2 = 1.
  Series noise() const {
    Series p = silence();
    for (std::size_t i = 0; i < p.size(); ++i) {
      const ComplexDraw xi = complex_normal(17, 0, i, 0);
      p[i] = std::complex<float>(std::complex<double>(xi.re, xi.im));
    }
    return p;
  }
  // What many scatterers with the sonar's pulse return, with E|p|^2 = 1.
  Series speckle() const {
    const auto spectrum = pulse_spectrum(sonar, record.transform);
    const std::size_t count = spectrum.size();
    double energy = 0;
    for (const auto& bin : spectrum) energy += std::norm(bin);
    const ComplexFft backward(record.transform, FftDirection::backward);
    AlignedBuffer<std::complex<double>> bins(count);
    Series p;
    for (int beam = 0; beam < sonar.beam_count; ++beam) {
      for (std::size_t m = 0; m < count; ++m) {
        const ComplexDraw xi = complex_normal(18, 0, std::size_t(beam) * count + m, 0);
        bins[(m + count / 2) % count] =
            spectrum[m] * std::complex<double>(xi.re, xi.im) / std::sqrt(energy);
      }
      backward.run(bins.data());
      for (int n = 0; n < record.samples; ++n) p.emplace_back(bins[n]);
    }
    return p;
  }
  // Levels of samples that the ends of the record do not reach.
  std::vector<double> inner(std::span<const float> levels, int margin = 40) const {
    std::vector<double> values;
    for (int n = margin; n < record.samples - margin; ++n) {
      for (int j = 0; j < sonar.beam_count; ++j) {
        values.push_back(double{levels[std::size_t(n) * sonar.beam_count + j]});
      }
    }
    return values;
  }

  Sonar sonar;
  Water water;
  Record record;
};

// sum w^2 and sum w^3 of the weights of an integration, and the correlation at a lag that they give
// to independent samples.
struct Weights {
  explicit Weights(double length) {
    for (int k = -20; k <= 20; ++k) {
      w.push_back(
          std::clamp(std::min(k + 0.5, length / 2) - std::max(k - 0.5, -length / 2), 0.0, 1.0) /
          length);
    }
  }
  double sum(int power) const {
    double total = 0;
    for (const double value : w) total += std::pow(value, power);
    return total;
  }
  double correlation(std::size_t lag) const {
    double total = 0;
    for (std::size_t k = 0; k + lag < w.size(); ++k) total += w[k] * w[k + lag];
    return total / sum(2);
  }
  std::vector<double> w;
};

}  // namespace

TEST_CASE("a detector without effects gives the level of each sample's power") {
  const DetectedBeams receiver(3, 3);
  const Series p = receiver.noise();
  const auto levels = receiver.levels(p);
  for (int j = 0; j < 3; ++j) {
    for (int n = 0; n < receiver.record.samples; ++n) {
      const double power = std::norm(std::complex<double>(p[j * receiver.record.samples + n]));
      CHECK(double{levels[n * 3 + j]} == Approx(120 + 10 * std::log10(power)).margin(1e-4));
    }
  }
}

TEST_CASE("looks follow the gamma law of their number") {
  DetectedBeams receiver(40, 20);
  const Series p = receiver.speckle();
  for (const int looks : {1, 2, 3, 4}) {
    INFO(looks);
    receiver.detector().looks = looks;
    const auto values = receiver.inner(receiver.levels(p));
    const Statistics s = statistics(values);
    const Polygamma gamma(looks);
    // 40 beams of 717 samples; cells of echoes are 1.4 looks samples long at least, n = 5000 for
    // four looks. Standard errors, relative for the spread, grow by the kurtosis of log-gamma:
    // mean spread/sqrt(n), spread 0.8/sqrt(n), skew 3.5/sqrt(n). Bands that cross share 4 % of
    // their amplitudes, which adds at most 0.2 % to the spread.
    const double root = std::sqrt(40 * 717 / (1.4 * looks));
    CHECK(s.mean ==
          Approx(120 + kDbPerNeper * (gamma.psi - std::log(looks))).margin(3 * s.spread / root));
    CHECK(s.spread == Approx(kDbPerNeper * std::sqrt(gamma.psi1)).epsilon(2.4 / root + 0.002));
    CHECK(s.skew == Approx(gamma.psi2 / std::pow(gamma.psi1, 1.5)).margin(10.5 / root));
  }
}

TEST_CASE("sub-bands share the energy of every pulse equally, and lose none of it") {
  DetectedBeams receiver(1);
  for (const PulseShape shape : {PulseShape::gaussian, PulseShape::flat, PulseShape::cw}) {
    receiver.sonar.pulse = {shape, 2e-4, 0.1, {}};
    const auto spectrum = pulse_spectrum(receiver.sonar, receiver.record.transform);
    const std::size_t count = spectrum.size();
    double energy = 0;
    for (const auto& bin : spectrum) energy += std::norm(bin);
    for (const int looks : {2, 3, 5}) {
      INFO(name_of(shape) << ", " << looks);
      receiver.detector().looks = looks;
      const SubBands bands(receiver.sonar, receiver.record);
      for (std::size_t i = 0; i < count; ++i) {
        double sum = 0;
        for (const auto& filter : bands.filters()) sum += filter[i] * filter[i];
        CHECK(sum == Approx(1).margin(1e-12));
      }
      // Of what a band loses where it crosses another, slopes of the spectrum return a part.
      for (const auto& filter : bands.filters()) {
        double share = 0;
        for (std::size_t i = 0; i < count; ++i) {
          share += std::norm(filter[i] * spectrum[(i + count / 2) % count]) / energy;
        }
        CHECK(share == Approx(1.0 / looks).epsilon(0.02));
      }
    }
  }
}

TEST_CASE("a border between two looks lies where the pulse has half of its energy") {
  DetectedBeams receiver(1);
  const double border = sub_band_borders(receiver.sonar, 2, receiver.record.transform)[1];
  CHECK(border == Approx(0).margin(1e-9));
}

TEST_CASE("a point echo becomes longer and weaker by the number of looks, at the same range") {
  DetectedBeams receiver(1);
  receiver.sonar.pulse.shape = PulseShape::flat;
  const auto spectrum = pulse_spectrum(receiver.sonar, receiver.record.transform);
  const int count = receiver.record.transform, at = receiver.record.samples / 2;
  Series p = receiver.silence();
  for (int n = 0; n < receiver.record.samples; ++n) {
    std::complex<double> sum = 0;
    for (int m = 0; m < count; ++m) {
      sum += spectrum[m] * std::polar(1.0, 2 * kPi * (m - count / 2) * (n - at) / count);
    }
    p[n] = std::complex<float>(sum);
  }
  for (const int looks : {1, 2, 4}) {
    receiver.detector().looks = looks;
    const auto levels = receiver.levels(p);
    double energy = 0, first_moment = 0;
    for (int n = 0; n < receiver.record.samples; ++n) {
      const double power = std::pow(10.0, (double{levels[n]} - 120) / 10);
      energy += power;
      first_moment += power * n;
    }
    // b int |s|^2 dt of the flat pulse (docs/physics/2_pulse_and_record.md). Some thousandths of
    // it are beyond the record.
    CHECK(energy == Approx(1.080).epsilon(0.01));
    CHECK(first_moment / energy == Approx(at).margin(0.05));
    // Bands that cross share some of the amplitude, but none of the power.
    CHECK(double{levels[at]} == Approx(120 - 10 * std::log10(looks) + 0.15).margin(0.2));
  }
}

TEST_CASE("integration gives each law its moments, and samples their correlation") {
  DetectedBeams receiver(60, 20);
  const Series p = receiver.noise();
  // Spread over mean, and skew, of |p|^2 and |p| of one sample; of levels the spread itself.
  const Polygamma one(1);
  const struct {
    DetectorLaw law;
    double mean, spread, skew;
  } laws[] = {
      {DetectorLaw::power, 1, 1, 2},
      {DetectorLaw::amplitude, std::sqrt(kPi) / 2, std::sqrt(1 - kPi / 4),
       2 * std::sqrt(kPi) * (kPi - 3) / std::pow(4 - kPi, 1.5)},
      {DetectorLaw::logarithm, 120 - kDbPerNeper * kEuler, kDbPerNeper * std::sqrt(one.psi1),
       one.psi2 / std::pow(one.psi1, 1.5)},
  };
  for (const auto& one_value : laws) {
    const DetectorLaw law = one_value.law;
    receiver.detector().law = law;
    for (const double length : {1.0, 1.4, 2.0, 5.0}) {
      INFO(name_of(law) << " over " << length);
      receiver.detector().integrate = length;
      const auto levels = receiver.levels(p);
      const auto value = [&](int n, int j) {
        const double level = double{levels[std::size_t(n) * 60 + j]};
        if (law == DetectorLaw::logarithm) return level;
        return std::pow(10.0, (level - 120) / (law == DetectorLaw::power ? 10 : 20));
      };
      const Weights weights(length);
      const int first = 10, end = receiver.record.samples - 10;
      std::vector<double> values;
      for (int n = first; n < end; ++n) {
        for (int j = 0; j < 60; ++j) values.push_back(value(n, j));
      }
      const Statistics s = statistics(values);
      // Of about n = 46,600/length independent values with the kurtosis of an exponential at most,
      // 9: standard errors spread/sqrt(n), spread sqrt(2/n) and, of the skew, sqrt(200/n) for
      // power and sqrt(15/n) otherwise.
      const double root = std::sqrt(static_cast<double>(values.size()) / length);
      CHECK(s.mean == Approx(one_value.mean).margin(3 * s.spread / root));
      CHECK(s.spread == Approx(one_value.spread * std::sqrt(weights.sum(2))).epsilon(4.3 / root));
      CHECK(s.skew == Approx(one_value.skew * weights.sum(3) / std::pow(weights.sum(2), 1.5))
                          .margin((law == DetectorLaw::power ? 42 : 12) / root));
      for (const int lag : {1, 3}) {
        double product = 0;
        for (int n = first; n < end - lag; ++n) {
          for (int j = 0; j < 60; ++j) {
            product += (value(n, j) - s.mean) * (value(n + lag, j) - s.mean);
          }
        }
        product /= 60.0 * (end - lag - first) * s.spread * s.spread;
        CHECK(product == Approx(weights.correlation(lag)).margin(3 / root));
      }
    }
  }
}

TEST_CASE("at the ends of the record fewer samples are averaged") {
  DetectedBeams receiver(1, 3);
  receiver.detector().integrate = 3;
  Series p = receiver.silence();
  p[0] = 2;
  p.back() = 3;
  const auto levels = receiver.levels(p);
  CHECK(double{levels[0]} == Approx(120 + 10 * std::log10(4 / 2.0)).margin(1e-4));
  CHECK(double{levels[1]} == Approx(120 + 10 * std::log10(4 / 3.0)).margin(1e-4));
  CHECK(levels[2] == kNoEnergyDb);
  CHECK(double{levels.back()} == Approx(120 + 10 * std::log10(9 / 2.0)).margin(1e-4));
}

TEST_CASE("noise is normal in dB, keyed by sample, ping and sequence, and of one look each") {
  DetectedBeams receiver(50, 12);
  receiver.detector().noise_db = 3;
  const Series p(std::size_t(50) * receiver.record.samples, {0.6f, 0.8f});
  const auto levels = receiver.levels(p);
  const auto values = receiver.inner(levels, 0);
  const Statistics s = statistics(values);
  const double root = std::sqrt(static_cast<double>(values.size()));
  CHECK(s.mean == Approx(120).margin(3 * 3 / root));
  CHECK(s.spread == Approx(3).epsilon(3 / (std::sqrt(2.0) * root)));
  CHECK(s.skew == Approx(0).margin(3 * std::sqrt(6.0) / root));
  double next = 0, other_beam = 0;
  for (std::size_t i = 0; i + 50 < values.size(); ++i) {
    next += (values[i] - 120) * (values[i + 50] - 120) / (9 * (root * root - 50));
    other_beam += (values[i] - 120) * (values[i + 1] - 120) / (9 * (root * root - 50));
  }
  CHECK(next == Approx(0).margin(3 / root));
  CHECK(other_beam == Approx(0).margin(3 / root));
  CHECK(receiver.levels(p, {5, 0, 0, 0}, 3) == levels);
  CHECK(receiver.levels(p, {5, 0, 1, 0}) != levels);
  CHECK(receiver.levels(p, {5, 1, 0, 0}) != levels);
  CHECK(receiver.levels(p, {6, 0, 0, 0}) != levels);
}

// With noise of unit power and a floor of c: E ln(x + c) = ln c + e^c E_1(c), x exponential.
TEST_CASE("the floor adds to the power of each sample") {
  DetectedBeams receiver(60, 20);
  const Series p = receiver.noise();
  const struct { double floor, mean_neper; } cases[] = {{1, 0.5963473623}, {0.1, -0.2879425483}};
  for (const auto& [floor, mean_neper] : cases) {
    receiver.detector().floor_db = 120 + 10 * std::log10(floor);
    const auto values = receiver.inner(receiver.levels(p), 0);
    const Statistics s = statistics(values);
    CHECK(s.mean == Approx(120 + kDbPerNeper * mean_neper)
                        .margin(3 * s.spread / std::sqrt(static_cast<double>(values.size()))));
    CHECK(*std::min_element(values.begin(), values.end()) >= *receiver.detector().floor_db - 1e-4);
  }
}

TEST_CASE("no power has no level, whatever the law and the noise") {
  DetectedBeams receiver(2, 3);
  for (const DetectorLaw law :
       {DetectorLaw::power, DetectorLaw::amplitude, DetectorLaw::logarithm}) {
    receiver.detector() = {2, {}, 3, 2.5, law};
    const auto levels = receiver.levels(receiver.silence());
    CHECK(std::all_of(levels.begin(), levels.end(), [](float l) { return l == kNoEnergyDb; }));
    receiver.detector().floor_db = 40;
    receiver.detector().noise_db = 0;
    for (const float level : receiver.levels(receiver.silence())) {
      CHECK(double{level} == Approx(40).margin(1e-4));
    }
  }
}
