#include "instrument/front_end.h"

#include <algorithm>
#include <cmath>

#include "acoustics/pattern.h"
#include "core/error.h"
#include "core/random.h"
#include "core/units.h"

namespace ensonify {
namespace {

using Complex = std::complex<float>;

// Purposes of draws of Stream::electronics.
enum Draw : std::uint32_t {
  kResponse,
  kLeakage,
  kStreak,
  kBurst,
  kOtherSonar,
  kPingGain,
  kGroupLevel
};

// Normal with mean 0.
double normal_db(std::uint64_t key, std::uint32_t ping, std::uint64_t item, Draw draw,
                 double deviation_db) {
  return deviation_db * std::sqrt(2.0) * complex_normal(key, ping, item, draw).re;
}

double amplitude_pa(double level_db) { return std::pow(10.0, (level_db - 120) / 20); }

std::uint64_t pixel_item(std::size_t beam, int sample) {
  return (static_cast<std::uint64_t>(beam) << 32) | static_cast<std::uint32_t>(sample);
}

// The parts of a ping that every beam needs.
struct FrontEndPing {
  const Sonar& sonar;
  const FrontEnd& front;
  const Record& record;
  double range_step_m;
  std::uint64_t instrument_key, sequence_key;
  PingMoment moment;
};

void mark(std::uint8_t& flags, Artifact artifact) {
  flags = static_cast<std::uint8_t>(flags | static_cast<std::uint8_t>(artifact));
}

// Adds `extra` to the sample, and marks it if it is stronger than what was there.
void add_foreign(std::complex<double> extra, Artifact artifact, Complex& p, std::uint8_t& flags) {
  if (std::abs(extra) > std::abs(p)) mark(flags, artifact);
  p += Complex(extra);
}

void add_leakage(const FrontEndPing& ping, std::size_t beam, Complex* p, std::uint8_t* flags) {
  const Leakage& leakage = *ping.front.leakage;
  const double start_pa = amplitude_pa(leakage.level_db);
  const double fall = ping.range_step_m / leakage.decay_m;
  constexpr double kHeard = 1e-6;  // of its amplitude at range 0
  const int end =
      static_cast<int>(std::min<double>(ping.record.samples, 1 - std::log(kHeard) / fall));
  for (int n = 0; n < end; ++n) {
    const ComplexDraw xi = complex_normal(ping.instrument_key, 0, pixel_item(beam, n), kLeakage);
    const double a = start_pa * std::exp(-n * fall);
    add_foreign({a * xi.re, a * xi.im}, Artifact::leakage, p[n], flags[n]);
  }
}

// A burst has the envelope sin^2(pi t/T), a carrier of its own within the middle 80 % of the band,
// fixed in a sequence, and a random phase. The pulse compression is left out.
void add_interference(const FrontEndPing& ping, std::size_t beam, Complex* p, std::uint8_t* flags) {
  const Interference& other = *ping.front.interference;
  const Philox4 fixed = random_words(ping.sequence_key, 0, 0, kOtherSonar);
  const double first = uniform_from_word(fixed.v[0]);
  const double offset_hz = 0.8 * ping.sonar.bandwidth_hz * (uniform_from_word(fixed.v[1]) - 0.5);
  const int j = static_cast<int>(beam);
  const double off_axis = beam_azimuth_rad(ping.sonar, j) - other.azimuth_rad;
  const ShadedLine line = make_shaded_line(ping.sonar.shading, width_of_beam_rad(ping.sonar, j));
  const double a = amplitude_pa(other.level_db) * shaded_pattern(line, off_axis);
  const double dt = ping.record.sample_interval_s;
  const double end_s = ping.moment.time_s + ping.record.samples * dt;
  const double from = (ping.moment.time_s - other.duration_s) * other.ping_rate_hz - first;
  for (double k = std::ceil(from);; ++k) {
    const double start_s = (k + first) / other.ping_rate_hz;
    if (start_s >= end_s) break;
    const auto number = static_cast<std::uint64_t>(static_cast<std::int64_t>(k));
    const double phase = 2 * kPi * uniform(ping.sequence_key, 0, number, kBurst);
    const double in_record_s = start_s - ping.moment.time_s;
    const auto sample_at = [&](double time_s) {
      return static_cast<int>(
          std::clamp(std::ceil(time_s / dt), 0.0, static_cast<double>(ping.record.samples)));
    };
    const int low = sample_at(in_record_s), high = sample_at(in_record_s + other.duration_s);
    for (int n = low; n < high; ++n) {
      const double t = n * dt - in_record_s;
      const double envelope = std::sin(kPi * t / other.duration_s);
      add_foreign(std::polar(a * envelope * envelope, phase + 2 * kPi * offset_hz * t),
                  Artifact::interference, p[n], flags[n]);
    }
  }
}

void saturate(const FrontEndPing& ping, std::size_t beam, Complex* p, std::uint8_t* flags) {
  const Saturation& saturation = *ping.front.saturation;
  const double limit_pa = amplitude_pa(saturation.level_db);
  const double start = saturation.streak_db ? std::pow(10.0, *saturation.streak_db / 20) : 0;
  const double keep = std::exp(-ping.range_step_m / saturation.streak_m);
  double tail_pa = 0;  // rms
  for (int n = 0; n < ping.record.samples; ++n) {
    const double heard_pa = std::abs(p[n]);
    const double excess_pa = heard_pa - limit_pa;
    if (tail_pa > 0) {
      const ComplexDraw xi =
          complex_normal(ping.sequence_key, ping.moment.ping, pixel_item(beam, n), kStreak);
      add_foreign({tail_pa * xi.re, tail_pa * xi.im}, Artifact::streak, p[n], flags[n]);
    }
    const double now_pa = std::abs(p[n]);
    if (now_pa > limit_pa) {
      p[n] *= static_cast<float>(limit_pa / now_pa);
      mark(flags[n], Artifact::clipped);
    }
    tail_pa = std::max(tail_pa * keep, start * std::max(0.0, excess_pa));
  }
}

void blank(const FrontEndPing& ping, Complex* p, std::uint8_t* flags) {
  for (int n = 0; n < ping.record.samples && n * ping.range_step_m < ping.front.blanking_m; ++n) {
    p[n] = 0;
    flags[n] = static_cast<std::uint8_t>(Artifact::blanked);
  }
}

void distort(const FrontEndPing& ping, std::size_t beam, Complex* p, std::uint8_t* flags) {
  if (ping.front.leakage) add_leakage(ping, beam, p, flags);
  if (ping.front.interference) add_interference(ping, beam, p, flags);
  if (ping.front.blanking_m > 0) blank(ping, p, flags);
  if (ping.front.saturation) saturate(ping, beam, p, flags);
}

// Of each beam in this ping; empty if all beams are alike.
std::vector<Complex> responses_of(const FrontEndPing& ping) {
  std::vector<Complex> responses(ping.front.beam_response.begin(), ping.front.beam_response.end());
  const double error_db = ping.front.ping_gain_error_db;
  if (error_db == 0) return responses;
  responses.resize(static_cast<std::size_t>(ping.sonar.beam_count), 1);
  for (std::size_t beam = 0; beam < responses.size(); ++beam) {
    const double gain_db =
        normal_db(ping.sequence_key, ping.moment.ping, beam, kPingGain, error_db);
    responses[beam] *= static_cast<float>(std::pow(10.0, gain_db / 20));
  }
  return responses;
}

// Each beam gets shares of those on either side, with their errors.
void respond(const FrontEndPing& ping, std::span<Complex> pressure_pa, const Workers& workers) {
  const std::vector<Complex> response = responses_of(ping);
  std::vector<float> shares;
  for (const double db : ping.front.crosstalk_db.values) {
    shares.push_back(static_cast<float>(std::pow(10.0, db / 20)));
  }
  if (response.empty() && shares.empty()) return;
  if (shares.empty()) shares = {0};
  const std::size_t beams = ping.sonar.beam_count, samples = ping.record.samples,
                    step = beams_of_group(ping.sonar, 0).step;
  std::vector<int> group;
  for (std::size_t beam = 0; beam < beams; ++beam) {
    group.push_back(group_of(ping.sonar, static_cast<int>(beam)));
  }
  workers.for_each(samples, [&](std::size_t n) {
    std::vector<Complex> heard(beams);
    for (std::size_t beam = 0; beam < beams; ++beam) {
      const Complex p = pressure_pa[beam * samples + n];
      heard[beam] = response.empty() ? p : p * response[beam];
    }
    for (std::size_t beam = 0; beam < beams; ++beam) {
      Complex sum = heard[beam];
      for (std::size_t k = 0; k < shares.size(); ++k) {
        const std::size_t away = (k + 1) * step;
        const auto of_group = [&](std::size_t other) {
          return other < beams && group[other] == group[beam] ? heard[other] : Complex(0);
        };
        const Complex before = of_group(beam - away), after = of_group(beam + away);
        sum += shares[k] * (before + after);
      }
      pressure_pa[beam * samples + n] = sum;
    }
  });
}

}  // namespace

std::vector<std::complex<double>> beam_responses(std::uint64_t seed, int beams,
                                                 double gain_error_db, double phase_error_rad) {
  const std::uint64_t key = stream_key(seed, Stream::electronics, 0);
  std::vector<std::complex<double>> responses;
  for (int beam = 0; beam < beams; ++beam) {
    const ComplexDraw xi = complex_normal(key, 0, static_cast<std::uint64_t>(beam), kResponse);
    const double gain_db = gain_error_db * std::sqrt(2.0) * xi.re;
    responses.push_back(
        std::polar(std::pow(10.0, gain_db / 20), phase_error_rad * std::sqrt(2.0) * xi.im));
  }
  return responses;
}

std::vector<double> group_levels_db(const Sonar& sonar, const PingMoment& moment) {
  std::vector<double> levels_db;
  if (!sonar.transmit) return levels_db;
  levels_db = sonar.transmit->level_db;
  if (sonar.transmit->level_error_db == 0) return levels_db;
  levels_db.resize(static_cast<std::size_t>(sonar.transmit->count));
  const std::uint64_t key = stream_key(moment.seed, Stream::electronics, moment.sequence + 1);
  for (int group = 0; group < sonar.transmit->count; ++group) {
    levels_db[static_cast<std::size_t>(group)] +=
        normal_db(key, moment.ping, static_cast<std::uint64_t>(group), kGroupLevel,
                  sonar.transmit->level_error_db);
  }
  return levels_db;
}

std::vector<std::uint8_t> front_end(const Sonar& sonar, const Water& water, const Record& record,
                                    const PingMoment& moment, bool marks,
                                    std::span<Complex> pressure_pa, const Workers& workers) {
  ENSONIFY_ASSERT(sonar.front_end.has_value());
  const std::size_t beams = sonar.beam_count, samples = record.samples;
  ENSONIFY_ASSERT(pressure_pa.size() == beams * samples);
  const FrontEndPing ping{sonar,
                          *sonar.front_end,
                          record,
                          sample_range_m(sonar, water, 1),
                          stream_key(moment.seed, Stream::electronics, 0),
                          stream_key(moment.seed, Stream::electronics, moment.sequence + 1),
                          moment};
  respond(ping, pressure_pa, workers);
  std::vector<std::uint8_t> flags(marks ? beams * samples : 0);
  workers.for_each(beams, [&](std::size_t beam) {
    std::vector<std::uint8_t> of_beam(samples);
    distort(ping, beam, pressure_pa.data() + beam * samples, of_beam.data());
    for (std::size_t n = 0; n < samples && marks; ++n) flags[n * beams + beam] = of_beam[n];
  });
  return flags;
}

}  // namespace ensonify
