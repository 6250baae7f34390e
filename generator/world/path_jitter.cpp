#include "world/path_jitter.h"

#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "core/units.h"

namespace ensonify {
namespace {

constexpr double kCut = 3;  // standard deviations; no frequency reaches zero with bandwidth < 1/3

double normal_below(double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); }

// Quantile of the normal density cut at +-kCut.
double cut_normal(double probability) {
  const double low_tail = normal_below(-kCut);
  const double wanted = low_tail + probability * (1 - 2 * low_tail);
  // On either side of zero the curve bends one way, so that Newton's rule never overshoots.
  double z = 0;
  for (int i = 0; i < 12; ++i) {
    z += (wanted - normal_below(z)) * std::sqrt(2 * kPi) * std::exp(0.5 * z * z);
  }
  return std::clamp(z, -kCut, kCut);
}

Jitter::Axis make_axis(const JitterSpec& spec, double rms, std::uint64_t key, std::uint32_t axis) {
  Jitter::Axis made;
  made.rms = rms;
  if (rms == 0) return made;
  for (int i = 0; i < Jitter::kTerms; ++i) {
    const Philox4 words = random_words(key, axis, static_cast<std::uint64_t>(i), 0);
    const double stratum = (i + uniform_from_word(words.v[0])) / Jitter::kTerms;
    made.terms[i] = {2 * kPi / spec.period_s * (1 + spec.bandwidth * cut_normal(stratum)),
                     2 * kPi * uniform_from_word(words.v[1])};
  }
  return made;
}

double value_of(const Jitter::Axis& axis, double time_s) {
  if (axis.rms == 0) return 0;
  double sum = 0;
  for (const Sinusoid& term : axis.terms) sum += std::cos(term.rad_s * time_s + term.phase_rad);
  return axis.rms * std::sqrt(2.0 / Jitter::kTerms) * sum;
}

}  // namespace

Jitter make_jitter(const JitterSpec& spec, std::uint64_t key, double start_time_s) {
  return {start_time_s, make_axis(spec, radians(spec.roll_deg), key, 0),
          make_axis(spec, radians(spec.pitch_deg), key, 1),
          make_axis(spec, radians(spec.yaw_deg), key, 2), make_axis(spec, spec.heave_m, key, 3)};
}

Pose jittered(const Jitter& jitter, double time_s, const Pose& pose) {
  const double t = time_s - jitter.start_time_s;
  const Quat turn = from_roll_pitch_yaw(value_of(jitter.roll, t), value_of(jitter.pitch, t),
                                        value_of(jitter.yaw, t));
  return {pose.position_m + Vec3{0, 0, value_of(jitter.heave, t)}, pose.rotation * turn};
}

}  // namespace ensonify
