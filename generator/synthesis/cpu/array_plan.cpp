#include "synthesis/cpu/array_plan.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

// Kernel and its Taylor terms may take this much of the tolerance each.
constexpr double kKernelShare = 0.3, kTaylorShare = 0.2;
// What the path's expansion may be wrong by, in turns of the carrier.
constexpr double kPathTurns = 3e-7;
constexpr int kLargestOrder = 4;

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

// [degree + 1][lanes] of the spreading kernel, which has every coefficient twice.
std::vector<float> single_coefficients(const SpreadKernel& spread, int lanes) {
  const int pairs = spread.polynomial().chunks * 8;
  std::vector<float> result(std::size_t(spread.degree + 1) * lanes);
  for (int d = 0; d <= spread.degree; ++d) {
    for (int l = 0; l < spread.width; ++l) {
      result[std::size_t(d) * lanes + l] = spread.coefficient[std::size_t(d) * pairs + 2 * l];
    }
  }
  return result;
}

// The first Taylor term left out of the kernel, at its worst, for shifts of e half grid points.
double left_out(const SpreadKernel& spread, int order, double e) {
  // The kernel is close to exp(-beta z^2 / 2): its derivatives are bounded by Hermite's.
  const double scale = e / spread.width * std::sqrt(spread.beta);
  constexpr double kHermite[] = {1, 0.61, 1, 1.4, 3, 6, 15};
  double factorial = 1;
  for (int k = 2; k <= order + 1; ++k) factorial *= k;
  return std::pow(scale, order + 1) * kHermite[order + 1] / factorial;
}

// Chooses group and order; 0 where none serves.
void choose_group(const SynthesisSetup& setup, ArrayPlan& plan) {
  const double per_element =
      2 * plan.points_per_s() * setup.sonar.array->spacing_m / setup.water.sound_speed_m_s;
  for (const int size : {16, 8, 4, 2, 1}) {
    const double e = per_element * (size - 1) / 2.0;
    for (int order = 1; order <= kLargestOrder; ++order) {
      // Shifts are spread evenly about zero, and echoes about broadside: their rms is far less.
      if (left_out(plan.spread, order, 0.7 * e) > kTaylorShare * setup.tolerance * (order + 3)) {
        continue;
      }
      plan.group_elements = size;
      plan.kernel.order = order;
      return;
    }
  }
}

}  // namespace

double expansion_clearance_m(const SynthesisSetup& setup, int group_elements) {
  const ArrayReceiver& array = *setup.sonar.array;
  const double half = (group_elements - 1) / 2.0 * array.spacing_m;
  const double per_m = setup.sonar.frequency_hz / setup.water.sound_speed_m_s;
  const double nearest = std::pow(0.375 * per_m * std::pow(half, 5) / kPathTurns, 0.25);
  return std::max(nearest, 3 * half);
}

ArrayGroup ArrayPlan::group(int first_element, int count) const {
  ArrayGroup group;
  group.count = count;
  group.first_element = -(count - 1) / 2.0;
  for (int l = 0; l < count; ++l) {
    group.response_re[l] = static_cast<float>(geometry.response[first_element + l].real());
    group.response_im[l] = static_cast<float>(geometry.response[first_element + l].imag());
  }
  return group;
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
  const double tolerance = kKernelShare * setup.tolerance;
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
  const int lanes = plan->spread.width <= 8 ? 8 : 16;
  plan->coefficient = single_coefficients(plan->spread, lanes);
  plan->kernel = {plan->coefficient.data(), plan->spread.degree, lanes, 0};
  choose_group(setup, *plan);
  if (plan->group_elements == 0) return nullptr;
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
