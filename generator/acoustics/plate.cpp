#include "acoustics/plate.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

constexpr int kSines = 256;
constexpr double kLeastLoss = 1e-6;  // keeps the resonances finite
constexpr double kLeastCosine = 1e-6;
// Taps may lie between these delays, in 1/b, besides the time through the wall. Later reverberation
// of the plate is left out.
constexpr double kFirstTap_cells = -1, kLastTap_cells = 10;
constexpr int kMostTaps = 16;
constexpr double kTapError = 1e-3;

struct PlateImpedances {
  Complex symmetric, antisymmetric;
};

PlateImpedances impedances_of(const Wall& wall, double xi, double omega) {
  const Complex lossy = std::sqrt(Complex(1, std::max(wall.loss, kLeastLoss)));
  const Complex kl = omega / (wall.speed_m_s * lossy);
  const Complex alpha = std::sqrt(kl * kl - xi * xi);
  const Complex tan_alpha = std::tan(alpha * (wall.thickness_m / 2));
  const Complex scale = Complex(0, -omega * wall.density_kg_m3) / alpha;
  if (wall.shear_speed_m_s == 0) return {scale / tan_alpha, -scale * tan_alpha};
  const Complex kt = omega / (wall.shear_speed_m_s * lossy);
  const Complex beta = std::sqrt(kt * kt - xi * xi);
  const Complex tan_beta = std::tan(beta * (wall.thickness_m / 2));
  const Complex kt4 = kt * kt * kt * kt;
  const Complex direct = (kt * kt - 2 * xi * xi) * (kt * kt - 2 * xi * xi) / kt4;
  const Complex shear = 4 * xi * xi * alpha * beta / kt4;
  return {scale * (direct / tan_alpha + shear / tan_beta),
          -scale * (direct * tan_alpha + shear * tan_beta)};
}

double energy_of(const std::vector<Tap>& taps) {
  double sum = 0;
  for (const Tap& tap : taps) sum += std::norm(tap.gain);
  return sum;
}

}  // namespace

PlateResponse plate_response(const Wall& wall, const Water& water, double sine, double f_hz) {
  const double omega = 2 * kPi * f_hz;
  const double cosine = std::max(std::sqrt(std::max(1 - sine * sine, 0.0)), kLeastCosine);
  const Complex z = water.density_kg_m3 * water.sound_speed_m_s / cosine;
  const auto [symmetric, antisymmetric] =
      impedances_of(wall, omega / water.sound_speed_m_s * sine, omega);
  if (!wall.water_inside) {
    // Twice 1/Z_in is 1/Z_S + 1/Z_A; written as a product, it also holds where one of them is 0.
    const Complex both = 2.0 * symmetric * antisymmetric, sum = symmetric + antisymmetric;
    return {(both - z * sum) / (both + z * sum), 0};
  }
  const Complex s = (symmetric - z) / (symmetric + z);
  const Complex a = (antisymmetric - z) / (antisymmetric + z);
  return {(s + a) / 2.0, (s - a) / 2.0};
}

const WallResponse::Angle& WallResponse::at(double sine) const {
  const int step = static_cast<int>(sine * static_cast<double>(by_sine.size()));
  return by_sine[std::clamp(step, 0, static_cast<int>(by_sine.size()) - 1)];
}

WallResponse wall_response(const Wall& wall, const Water& water, double frequency_hz,
                           double bandwidth_hz) {
  const double slowest_m_s = wall.shear_speed_m_s > 0 ? wall.shear_speed_m_s : wall.speed_m_s;
  // Whole cells, so that the delay 0 is on the grid of the fit.
  const double water_cells = wall.thickness_m / water.sound_speed_m_s * bandwidth_hz;
  const TapFit fit{frequency_hz,
                   bandwidth_hz,
                   (kFirstTap_cells - std::ceil(water_cells)) / bandwidth_hz,
                   kLastTap_cells / bandwidth_hz + wall.thickness_m / slowest_m_s,
                   kTapError,
                   kMostTaps};
  WallResponse response;
  response.lets_through = wall.water_inside;
  response.by_sine.resize(kSines);
  for (int i = 0; i < kSines; ++i) {
    const double sine = (i + 0.5) / kSines;
    WallResponse::Angle& angle = response.by_sine[i];
    angle.reflected =
        fit_taps([&](double f) { return plate_response(wall, water, sine, f).reflected; }, fit);
    if (wall.water_inside) {
      // A ray takes the whole piece in water, and the wall is a part of it.
      const double water_s = wall.thickness_m * std::sqrt(1 - sine * sine) / water.sound_speed_m_s;
      const auto transmitted = [&](double f) {
        return plate_response(wall, water, sine, f).transmitted *
               std::polar(1.0, 2 * kPi * f * water_s);
      };
      angle.transmitted = fit_taps(transmitted, fit);
    }
    angle.reflected_energy = energy_of(angle.reflected);
    angle.transmitted_energy = energy_of(angle.transmitted);
  }
  return response;
}

}  // namespace ensonify
