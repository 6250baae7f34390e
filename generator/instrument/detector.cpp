#include "instrument/detector.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "acoustics/pulse.h"
#include "core/error.h"
#include "core/random.h"
#include "core/units.h"

namespace ensonify {
namespace {

// The share of the narrower band over which two bands cross.
constexpr double kCrossing = 0.25;

// The filter of the band from borders[k] to borders[k + 1] at place x of the band.
double sub_band_filter(const std::vector<double>& borders, std::size_t k, double x) {
  // -1 below the crossing at a border and 1 above it.
  const auto crossed = [&](std::size_t border) {
    if (border == 0) return 1.0;
    if (border + 1 == borders.size()) return -1.0;
    const double narrower =
        std::min(borders[border] - borders[border - 1], borders[border + 1] - borders[border]);
    const double u = std::clamp((x - borders[border]) / (kCrossing / 2 * narrower), -1.0, 1.0);
    return std::sin(kPi / 2 * u);
  };
  return std::sin(kPi / 4 * (1 + crossed(k))) * std::cos(kPi / 4 * (1 + crossed(k + 1)));
}

// Values of Detector::law, from powers that noise has changed.
void apply_law(DetectorLaw law, std::span<double> values) {
  for (double& value : values) {
    if (law == DetectorLaw::amplitude) value = std::sqrt(value);
    if (law == DetectorLaw::logarithm) value = double{level_db(value)};
  }
}

float level_of(DetectorLaw law, double value) {
  if (law == DetectorLaw::logarithm) return std::max(kNoEnergyDb, static_cast<float>(value));
  return image_level_db(static_cast<float>(law == DetectorLaw::power ? value : value * value));
}

// One draw serves two samples.
void add_log_noise(double noise_db, std::uint64_t key, std::uint32_t ping, std::size_t beam,
                   std::span<double> power) {
  const double spread = noise_db * std::log(10.0) / 10 * std::sqrt(2.0);
  for (std::size_t n = 0; n < power.size(); n += 2) {
    const ComplexDraw xi = complex_normal(key, ping, (std::uint64_t{beam} << 32) | (n / 2), 0);
    power[n] *= std::exp(spread * xi.re);
    if (n + 1 < power.size()) power[n + 1] *= std::exp(spread * xi.im);
  }
}

// The mean about each sample.
void integrate(double length, std::span<const double> values, std::span<double> means) {
  const auto reach = static_cast<std::ptrdiff_t>(std::ceil((length - 1) / 2));
  const double end_weight = (length + 1) / 2 - static_cast<double>(reach);
  const auto count = static_cast<std::ptrdiff_t>(values.size());
  for (std::ptrdiff_t n = 0; n < count; ++n) {
    double sum = 0, weights = 0;
    for (std::ptrdiff_t k = -reach; k <= reach; ++k) {
      if (n + k < 0 || n + k >= count) continue;
      const double weight = reach > 0 && std::abs(k) == reach ? end_weight : 1;
      sum += weight * values[n + k];
      weights += weight;
    }
    means[n] = sum / weights;
  }
}

struct BeamScratch {
  explicit BeamScratch(std::size_t samples) : power(samples), mean(samples) {}
  std::vector<double> power, mean;
};

void write_power(const DetectedPing& ping, std::span<const std::complex<float>> pressure_pa,
                 std::span<double> power) {
  if (ping.sub_bands != nullptr) return ping.sub_bands->powers(pressure_pa, power);
  for (std::size_t n = 0; n < pressure_pa.size(); ++n) {
    power[n] = std::norm(std::complex<double>(pressure_pa[n]));
  }
}

// Writes the values of the law, averaged, to scratch.mean.
void detect(const DetectedPing& ping, std::uint64_t key, std::size_t beam,
            std::span<const std::complex<float>> pressure_pa, BeamScratch& scratch) {
  const Detector& detector = *ping.sonar.detector;
  write_power(ping, pressure_pa, scratch.power);
  for (const Series& band : ping.further) {
    const std::size_t samples = scratch.power.size();
    write_power(ping, std::span(band.data() + beam * samples, samples), scratch.mean);
    for (std::size_t n = 0; n < samples; ++n) scratch.power[n] += scratch.mean[n];
  }
  if (!ping.further.empty()) {
    for (double& power : scratch.power) power /= static_cast<double>(ping.further.size() + 1);
  }
  if (detector.floor_db) {
    const double floor_pa2 = mean_square_pa2(*detector.floor_db);
    for (double& power : scratch.power) power += floor_pa2;
  }
  if (detector.noise_db > 0) {
    add_log_noise(detector.noise_db, key, ping.moment.ping, beam, scratch.power);
  }
  apply_law(detector.law, scratch.power);
  integrate(detector.integrate, scratch.power, scratch.mean);
}

}  // namespace

std::vector<double> sub_band_borders(const Sonar& sonar, int looks, int transform) {
  ENSONIFY_ASSERT(looks >= 1);
  std::vector<double> energy_below = {0};  // of the bins before each
  for (const std::complex<double>& bin : pulse_spectrum(sonar, transform)) {
    energy_below.push_back(energy_below.back() + std::norm(bin));
  }
  std::vector<double> borders = {-0.5};
  for (int k = 1; k < looks; ++k) {
    const double wanted = energy_below.back() * k / looks;
    const auto above = std::upper_bound(energy_below.begin() + 1, energy_below.end() - 1, wanted);
    const double below = *(above - 1);
    const double part = std::min(1.0, (wanted - below) / (*above - below));
    // Bin m is about its frequency (m - M/2)/M.
    const auto m = static_cast<double>(above - energy_below.begin() - 1);
    borders.push_back((m - 0.5 + part) / transform - 0.5);
  }
  borders.push_back(0.5);
  return borders;
}

SubBands::SubBands(const Sonar& sonar, const Record& record)
    : forward_(record.transform, FftDirection::forward),
      backward_(record.transform, FftDirection::backward) {
  ENSONIFY_ASSERT(sonar.detector && sonar.detector->looks >= 2);
  const int count = record.transform;
  const auto borders = sub_band_borders(sonar, sonar.detector->looks, count);
  for (std::size_t k = 0; k + 1 < borders.size(); ++k) {
    std::vector<double> filter(count);
    for (int i = 0; i < count; ++i) {
      const int m = i < count / 2 ? i : i - count;
      filter[i] = sub_band_filter(borders, k, m / static_cast<double>(count));
    }
    filters_.push_back(std::move(filter));
  }
}

void SubBands::powers(std::span<const std::complex<float>> beam, std::span<double> power) const {
  const std::size_t count = filters_.front().size();
  ENSONIFY_ASSERT(beam.size() == power.size() && beam.size() <= count);
  AlignedBuffer<std::complex<double>> spectrum(count), band(count);
  std::copy(beam.begin(), beam.end(), spectrum.begin());
  forward_.run(spectrum.data());
  std::fill(power.begin(), power.end(), 0.0);
  const double scale = 1 / (static_cast<double>(count) * static_cast<double>(count));
  for (const std::vector<double>& filter : filters_) {
    for (std::size_t i = 0; i < count; ++i) band[i] = filter[i] * spectrum[i];
    backward_.run(band.data());
    for (std::size_t n = 0; n < power.size(); ++n) power[n] += scale * std::norm(band[n]);
  }
}

SampleArray<float> detected_levels_db(const DetectedPing& ping,
                                      std::span<const std::complex<float>> pressure_pa,
                                      const Workers& workers) {
  ENSONIFY_ASSERT(ping.sonar.detector.has_value());
  const std::size_t beams = ping.sonar.beam_count, samples = ping.record.samples;
  ENSONIFY_ASSERT(pressure_pa.size() == beams * samples);
  const std::uint64_t key = stream_key(ping.moment.seed, Stream::detector, ping.moment.sequence);
  SampleArray<float> level_db(pressure_pa.size());
  // As many beams as a line of the cache holds levels of one sample.
  constexpr std::size_t kBlock = 16;
  workers.for_each((beams + kBlock - 1) / kBlock, [&](std::size_t block) {
    BeamScratch scratch(samples);
    for (std::size_t beam = block * kBlock; beam < std::min(beams, (block + 1) * kBlock); ++beam) {
      detect(ping, key, beam, pressure_pa.subspan(beam * samples, samples), scratch);
      for (std::size_t n = 0; n < samples; ++n) {
        level_db[n * beams + beam] = level_of(ping.sonar.detector->law, scratch.mean[n]);
      }
    }
  });
  return level_db;
}

}  // namespace ensonify
