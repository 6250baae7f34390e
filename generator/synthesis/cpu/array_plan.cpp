#include "synthesis/cpu/array_plan.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

// What the kernel, its polynomials and its ends beside elements may take of the tolerance each.
constexpr double kSpreadShare = 0.3, kPolynomialShare = 0.2, kLostShare = 0.2;
constexpr double kFurthestReach = 1.8;
// What the path's expansion may be wrong by, in turns of the carrier.
constexpr double kPathTurns = 1e-6;

double window(double z) {
  constexpr double kBeta = 2.30 * kBeamTaps;
  const double inside = 1.0 - z * z;
  return inside > 0 ? std::exp(kBeta * (std::sqrt(inside) - 1.0)) : 0.0;
}

// Of the window across kBeamTaps half samples, at k of M bins.
double window_transform(double bins, int k) {
  constexpr int kNodes = 200;
  double sum = 0;
  for (int i = 0; i < kNodes; ++i) {
    const double u = kPi * ((i + 0.5) / kNodes - 0.5);
    const double z = std::sin(u);
    sum += window(z) * std::cos(u) * (kPi / kNodes) * kBeamTaps / 2.0 *
           std::cos(kPi * k * kBeamTaps * z / (2 * bins));
  }
  return sum;
}

// The largest group whose elements hear an echo so little apart that one kernel's place serves all;
// 0 where none does.
int choose_group(const SynthesisSetup& setup, const SpreadKernel& spread, double points_per_s,
                 double& reach) {
  // In halves of a grid point, as the kernel's offset.
  const double per_element =
      2 * points_per_s * setup.sonar.array->spacing_m / setup.water.sound_speed_m_s;
  for (const int size : {16, 8, 4, 2, 1}) {
    reach = 1 + per_element * (size - 1) / 2.0;
    const double lost = lost_beyond(spread, reach) * spread.rounding_gain;
    if (reach <= kFurthestReach && lost <= kLostShare * setup.tolerance) return size;
  }
  return 0;
}

}  // namespace

BeamTaps make_beam_taps(const SynthesisSetup& setup, const ArrayGeometry& geometry) {
  BeamTaps taps;
  const int bins = setup.record.transform;
  for (int k = 0; k <= bins / 2; ++k) {
    taps.correction.push_back(1.0 / window_transform(bins, k));
  }
  int furthest = 0;
  for (int j = 0; j < setup.sonar.beam_count; ++j) {
    const double azimuth = beam_azimuth_rad(setup.sonar, j);
    for (const double y : geometry.y_m) {
      const bool delayed = setup.sonar.array->steering == Steering::true_delay;
      const double delay_s =
          delayed ? steering_delay_s(y, azimuth, setup.water.sound_speed_m_s) : 0.0;
      const double at = 2 * delay_s * setup.sonar.bandwidth_hz;
      const int begin = static_cast<int>(std::ceil(at - kBeamTaps / 2.0));
      taps.begin.push_back(begin);
      for (int m = 0; m < kBeamTaps; ++m) {
        taps.tap.push_back(static_cast<float>(window((begin + m - at) / (kBeamTaps / 2.0))));
      }
      furthest = std::max({furthest, std::abs(begin), std::abs(begin + kBeamTaps)});
    }
  }
  taps.pad = furthest / 2 + 2;
  return taps;
}

double expansion_clearance_m(const SynthesisSetup& setup, int group_elements) {
  const ArrayReceiver& array = *setup.sonar.array;
  const double half = (group_elements - 1) / 2.0 * array.spacing_m;
  const double per_m = setup.sonar.frequency_hz / setup.water.sound_speed_m_s;
  const double nearest = std::pow(0.375 * per_m * std::pow(half, 5) / kPathTurns, 0.25);
  return std::max(nearest, 3 * half);
}

double group_kernel_at(const GroupKernel& kernel, int tap, double offset) {
  const int pair = std::min(tap, kernel.width - 1 - tap);
  const float* c = kernel.coefficient + std::ptrdiff_t(pair) * kernel.terms * 2;
  const double x = offset * kernel.per_reach;
  double even = 0, odd = 0;
  for (int i = 0; i < kernel.terms; ++i) {
    even = even * x * x + c[2 * i];
    odd = odd * x * x + c[2 * i + 1];
  }
  return tap == pair ? even + odd * x : even - odd * x;
}

GroupLine ArrayPlan::line(int first_element, int count, double turns_per_m) const {
  const double c = setup.water.sound_speed_m_s;
  return {(geometry.y_m[first_element] + geometry.y_m[first_element + count - 1]) / 2,
          setup.sonar.array->spacing_m,
          turns_per_m,
          points_per_s() / c,
          -(count - 1) / 2.0,
          spread.points,
          spread.width};
}

std::shared_ptr<const ArrayPlan> make_array_plan(const SynthesisTables& tables) {
  const SynthesisSetup& setup = tables.setup;
  const int bins = setup.record.transform, half = bins / 2;
  // Every echo is deposited once for each element: a grid twice as long costs less than a kernel
  // of two vectors.
  const double tolerance = kSpreadShare * setup.tolerance;
  SpreadKernel spread = choose_spread_kernel(tables.spectrum, -half, tolerance, 8);
  if (spread.points == 0) spread = choose_spread_kernel(tables.spectrum, -half, tolerance);
  if (spread.points == 0 || spread.width > 16) return nullptr;
  const int points = spread.points;
  auto plan = std::make_shared<ArrayPlan>(
      ArrayPlan{.setup = setup,
                .geometry = make_array_geometry(setup.sonar),
                .spread = std::move(spread),
                .kernel = {},
                .coefficient = {},
                .filter = std::vector<Complex>(bins),
                .taps = {},
                .grid_forward = ComplexFft(points, FftDirection::forward),
                .record_forward = ComplexFft(bins, FftDirection::forward),
                .record_backward = ComplexFft(bins, FftDirection::backward),
                .fine_backward = ComplexFft(2 * bins, FftDirection::backward)});
  double reach = 1;
  plan->group_elements = choose_group(setup, plan->spread, plan->points_per_s(), reach);
  if (plan->group_elements == 0) return nullptr;
  WidePolynomials wide = fit_wide(plan->spread, reach, kPolynomialShare * setup.tolerance);
  plan->coefficient = std::move(wide.coefficient);
  plan->kernel = {plan->coefficient.data(), plan->spread.width, wide.terms,
                  static_cast<float>(1 / reach)};
  plan->exact_range_m =
      std::abs(plan->geometry.y_m.front()) + expansion_clearance_m(setup, plan->group_elements);
  for (int k = -half; k < half; ++k) {
    plan->filter[k < 0 ? k + bins : k] =
        tables.spectrum[k + half] * plan->spread.correction[std::abs(k)];
  }
  plan->taps = make_beam_taps(setup, plan->geometry);
  return plan;
}

}  // namespace ensonify
