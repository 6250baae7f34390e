#include "acoustics/elastic_body.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "acoustics/bessel.h"
#include "core/error.h"
#include "core/units.h"

namespace ensonify {
namespace {

using Bessels = std::vector<BesselValue>;

// Radial displacement and stresses of one wave at the radius r: r u_r, r^2 s_rr/2mu and r^2 s_rt/2mu,
// the latter over the derivative of the angular function by its angle.
struct WallMotion {
  double radial = 0, pull = 0, shear = 0;
};

// Where spheres and cylinders differ. xt is r times the wavenumber of shear waves, f the Bessel
// function of the wave.
struct Sphere {
  static std::vector<BesselValue> j(int orders, double x) { return spherical_j(orders, x); }
  static std::vector<BesselValue> y(int orders, double x) { return spherical_y(orders, x); }

  // u = grad(phi) + curl curl (r psi).
  static WallMotion longitudinal(int n, double xt, const BesselValue& f) {
    const double nn = n * (n + 1.0);
    return {f.slope, (nn - xt * xt / 2) * f.value - 2 * f.slope, f.slope - f.value};
  }
  static WallMotion transverse(int n, double xt, const BesselValue& f) {
    const double nn = n * (n + 1.0);
    return {nn * f.value, nn * (f.slope - f.value), (nn - 1 - xt * xt / 2) * f.value - f.slope};
  }
};

struct Cylinder {
  static std::vector<BesselValue> j(int orders, double x) { return cylindrical_j(orders, x); }
  static std::vector<BesselValue> y(int orders, double x) { return cylindrical_y(orders, x); }

  // u = grad(phi) + curl(n psi along the axis).
  static WallMotion longitudinal(int n, double xt, const BesselValue& f) {
    const double nn = double(n) * n;
    return {f.slope, (nn - xt * xt / 2) * f.value - f.slope, f.slope - f.value};
  }
  static WallMotion transverse(int n, double xt, const BesselValue& f) {
    const double nn = double(n) * n;
    return {nn * f.value, nn * (f.slope - f.value), (nn - xt * xt / 2) * f.value - f.slope};
  }
};

// What a wave in the wall contributes to the conditions at both of its sides, and to the motion of
// the outer side.
template <std::size_t kConditions>
struct WallWave {
  std::array<double, kConditions> condition{};  // must vanish in the sum of all waves
  double radial = 0, pressure = 0;              // of the outer side: a rho w^2 u_r, p
};

// The amplitudes, one more than conditions, for which all conditions hold: elimination with full
// pivoting after scaling the rows.
template <std::size_t kConditions>
std::array<double, kConditions + 1> amplitudes(
    const std::array<WallWave<kConditions>, kConditions + 1>& waves) {
  constexpr std::size_t kWaves = kConditions + 1;
  std::array<std::array<double, kWaves>, kConditions> m{};
  for (std::size_t row = 0; row < kConditions; ++row) {
    double most = 0;
    for (std::size_t i = 0; i < kWaves; ++i) {
      m[row][i] = waves[i].condition[row];
      most = std::max(most, std::abs(m[row][i]));
    }
    for (double& x : m[row]) x /= most > 0 ? most : 1;
  }
  std::array<std::size_t, kWaves> order{};
  for (std::size_t i = 0; i < kWaves; ++i) order[i] = i;
  for (std::size_t k = 0; k < kConditions; ++k) {
    std::size_t row = k, column = k;
    for (std::size_t r = k; r < kConditions; ++r) {
      for (std::size_t c = k; c < kWaves; ++c) {
        if (std::abs(m[r][order[c]]) > std::abs(m[row][order[column]])) {
          row = r;
          column = c;
        }
      }
    }
    std::swap(m[k], m[row]);
    std::swap(order[k], order[column]);
    const double pivot = m[k][order[k]];
    for (std::size_t r = k + 1; r < kConditions; ++r) {
      const double factor = pivot != 0 ? m[r][order[k]] / pivot : 0;
      for (std::size_t c = k; c < kWaves; ++c) m[r][order[c]] -= factor * m[k][order[c]];
    }
  }
  std::array<double, kWaves> a{};
  a[order[kConditions]] = 1;
  for (std::size_t k = kConditions; k-- > 0;) {
    double sum = 0;
    for (std::size_t c = k + 1; c < kWaves; ++c) sum += m[k][order[c]] * a[order[c]];
    const double pivot = m[k][order[k]];
    a[order[k]] = pivot != 0 ? -sum / pivot : 0;
  }
  return a;
}

// The motion of the outer side, a rho w^2 u_r, and the pressure on it, in any common unit.
struct SurfaceMotion {
  double radial = 0, pressure = 0;
};

template <std::size_t kConditions>
SurfaceMotion total(const std::array<WallWave<kConditions>, kConditions + 1>& waves) {
  const std::array<double, kConditions + 1> a = amplitudes(waves);
  SurfaceMotion sum;
  for (std::size_t i = 0; i < waves.size(); ++i) {
    sum.radial += a[i] * waves[i].radial;
    sum.pressure += a[i] * waves[i].pressure;
  }
  return sum;
}

// One body at one frequency.
template <class Geometry>
class BodyWaves {
 public:
  BodyWaves(const ElasticBody& body, const Water& water, double frequency_hz)
      : body_(body), water_density_(water.density_kg_m3) {
    const double w = 2 * kPi * frequency_hz;
    const SphereMaterial& m = body.material;
    const double a = body.radius_m, b = a - body.wall_m;
    x_ = w / water.sound_speed_m_s * a;
    orders_ = static_cast<int>(x_ + 4 * std::cbrt(x_) + 10);
    solid_ = body.is_solid();
    fluid_ = m.shear_speed_m_s == 0;
    outer_l_ = w / m.speed_m_s * a;
    inner_l_ = w / m.speed_m_s * b;
    if (!fluid_) outer_t_ = w / m.shear_speed_m_s * a;
    if (!fluid_) inner_t_ = w / m.shear_speed_m_s * b;
    jw_ = Geometry::j(orders_, x_);
    yw_ = Geometry::y(orders_, x_);
    jl_ = Geometry::j(orders_, outer_l_);
    if (!fluid_) jt_ = Geometry::j(orders_, outer_t_);
    if (solid_) return;
    yl_ = Geometry::y(orders_, outer_l_);
    inner_jl_ = Geometry::j(orders_, inner_l_);
    inner_yl_ = Geometry::y(orders_, inner_l_);
    if (!fluid_) {
      yt_ = Geometry::y(orders_, outer_t_);
      inner_jt_ = Geometry::j(orders_, inner_t_);
      inner_yt_ = Geometry::y(orders_, inner_t_);
    }
    if (body.filling.density_kg_m3 > 0) {
      filling_ = Geometry::j(orders_, w / body.filling.speed_m_s * b);
    }
  }

  int orders() const { return orders_; }
  double x() const { return x_; }

  // c_n = -(x j' p - u j)/(x h' p - u h), h = j - iy, with the motion u and the pressure p.
  std::complex<double> coefficient(int n) const {
    SurfaceMotion s = surface(n);
    const double size = std::hypot(s.radial, s.pressure);
    s = {s.radial / size, s.pressure / size};
    const auto &j = jw_[at(n)], &y = yw_[at(n)];
    const double of_j = j.slope * s.pressure - s.radial * j.value;
    const double of_y = y.slope * s.pressure - s.radial * y.value;
    const int exponent = std::max(j.exponent, y.exponent);
    const double re = std::ldexp(of_j, j.exponent - exponent);
    const double im = std::ldexp(of_y, y.exponent - exponent);
    const double length = std::hypot(re, im);
    return -(re / length) * std::complex<double>(re / length, im / length);
  }

 private:
  static std::size_t at(int n) { return static_cast<std::size_t>(n); }

  SurfaceMotion surface(int n) const {
    if (fluid_)
      return solid_ ? fluid_body(n)
                    : total<1>({fluid_wave(n, jl_, inner_jl_, true),
                                fluid_wave(n, yl_, inner_yl_, false)});
    if (solid_ || !feels_cavity(n)) {
      const auto l = solid_wave<1>(n, jl_, jl_, true, true);
      if (n == 0) return {l.radial, l.pressure};
      return total<1>({l, solid_wave<1>(n, jt_, jt_, false, true)});
    }
    const auto jl = solid_wave<3>(n, jl_, inner_jl_, true, true);
    const auto yl = solid_wave<3>(n, yl_, inner_yl_, true, false);
    if (n == 0) {
      // No shear: the last condition alone.
      return total<1>({WallWave<1>{{jl.condition[2]}, jl.radial, jl.pressure},
                       WallWave<1>{{yl.condition[2]}, yl.radial, yl.pressure}});
    }
    return total<3>({jl, yl, solid_wave<3>(n, jt_, inner_jt_, false, true),
                     solid_wave<3>(n, yt_, inner_yt_, false, false)});
  }

  // Whether the order reaches into the shell: waves fall towards the center below kr = n. Otherwise
  // its conditions on the inner side would be lost in rounding.
  bool feels_cavity(int n) const {
    const auto size = [n](const Bessels& f) {
      const BesselValue& v = f[at(n)];
      return std::log2(std::hypot(v.value, v.slope)) + v.exponent;
    };
    const double fall = size(inner_jt_) - size(jt_) + size(yt_) - size(inner_yt_);
    return n == 0 || fall - 2 * std::log2(std::min(1.0, inner_t_ / n)) > -50;
  }

  // In a fluid, p = rho_s w^2 phi and r u_r = x phi'.
  SurfaceMotion fluid_body(int n) const {
    return {water_density_ / body_.material.density_kg_m3 * jl_[at(n)].slope, jl_[at(n)].value};
  }

  // p/(rho_s w^2) = d f and r u_r = x f' must meet on the inner side: d f (x phi') = phi (x f').
  WallWave<1> fluid_wave(int n, const Bessels& outer, const Bessels& inner, bool grows) const {
    const BesselValue &o = outer[at(n)], &i = inner[at(n)];
    const int exponent = grows ? o.exponent : i.exponent;
    const double out = std::ldexp(1.0, o.exponent - exponent);
    const double in = std::ldexp(1.0, i.exponent - exponent);
    const auto [value, slope] = of_filling(n);
    return {{in * (value * i.slope - slope * i.value)},
            out * water_density_ / body_.material.density_kg_m3 * o.slope,
            out * o.value};
  }

  // Of the waves in the filling: pressure over rho_s w^2, and r u_r; a vacuum has no pressure.
  std::pair<double, double> of_filling(int n) const {
    if (filling_.empty()) return {0, 1};
    const BesselValue& f = filling_[at(n)];
    const double value = body_.filling.density_kg_m3 / body_.material.density_kg_m3 * f.value;
    const double size = std::hypot(value, f.slope);
    return {value / size, f.slope / size};
  }

  // Conditions: no shear on the outer side, and for shells none on the inner side, where the normal
  // stress and the motion are those of the filling.
  template <std::size_t kConditions>
  WallWave<kConditions> solid_wave(int n, const Bessels& outer, const Bessels& inner,
                                   bool is_longitudinal, bool grows) const {
    const auto wave = [&](double xt, const BesselValue& f, int scale) {
      const WallMotion m = is_longitudinal ? Geometry::longitudinal(n, xt, f)
                                           : Geometry::transverse(n, xt, f);
      const double factor = std::ldexp(1.0, f.exponent - scale);
      return WallMotion{factor * m.radial, factor * m.pull, factor * m.shear};
    };
    const BesselValue &o = outer[at(n)], &i = inner[at(n)];
    const int exponent = grows ? o.exponent : i.exponent;
    const WallMotion out = wave(outer_t_, o, exponent);
    WallWave<kConditions> w;
    w.radial =
        water_density_ / body_.material.density_kg_m3 * outer_t_ * outer_t_ / 2 * out.radial;
    w.pressure = -out.pull;
    w.condition[0] = out.shear;
    if constexpr (kConditions == 3) {
      const WallMotion in = wave(inner_t_, i, exponent);
      const auto [value, slope] = of_filling(n);
      w.condition[1] = in.shear;
      w.condition[2] = slope * in.pull + value * inner_t_ * inner_t_ / 2 * in.radial;
    }
    return w;
  }

  const ElasticBody& body_;
  double water_density_, x_ = 0;
  int orders_ = 0;
  bool solid_ = true, fluid_ = false;
  // Radius times wavenumber, of longitudinal and shear waves.
  double outer_l_ = 0, inner_l_ = 0, outer_t_ = 0, inner_t_ = 0;
  Bessels jw_, yw_, jl_, yl_, jt_, yt_, inner_jl_, inner_yl_, inner_jt_, inner_yt_, filling_;
};

template <class Geometry>
std::vector<std::complex<double>> modes_of(const ElasticBody& body, const Water& water,
                                           double frequency_hz) {
  ENSONIFY_ASSERT(body.radius_m > 0 && body.wall_m > 0 && frequency_hz > 0);
  const BodyWaves<Geometry> waves(body, water, frequency_hz);
  std::vector<std::complex<double>> modes;
  for (int n = 0; n < waves.orders(); ++n) modes.push_back(waves.coefficient(n));
  return modes;
}

// The sum of (-1)^n weight(n) c_n, the smallest terms first.
template <class Weight>
std::complex<double> alternating_sum(const std::vector<std::complex<double>>& modes,
                                     const Weight& weight) {
  std::complex<double> sum = 0;
  for (std::size_t n = modes.size(); n-- > 0;) {
    sum += (n % 2 == 0 ? 1.0 : -1.0) * weight(static_cast<double>(n)) * modes[n];
  }
  return sum;
}

}  // namespace

std::vector<std::complex<double>> sphere_modes(const ElasticBody& sphere, const Water& water,
                                               double frequency_hz) {
  return modes_of<Sphere>(sphere, water, frequency_hz);
}

std::vector<std::complex<double>> cylinder_modes(const ElasticBody& cylinder, const Water& water,
                                                 double frequency_hz) {
  return modes_of<Cylinder>(cylinder, water, frequency_hz);
}

std::complex<double> sphere_backscatter_m(const ElasticBody& sphere, const Water& water,
                                          double frequency_hz) {
  const double k = 2 * kPi * frequency_hz / water.sound_speed_m_s;
  return std::complex<double>(0, 1 / k) *
         alternating_sum(sphere_modes(sphere, water, frequency_hz),
                         [](double n) { return 2 * n + 1; });
}

std::complex<double> cylinder_backscatter(const ElasticBody& cylinder, const Water& water,
                                          double frequency_hz) {
  return std::complex<double>(0, 1 / kPi) *
         alternating_sum(cylinder_modes(cylinder, water, frequency_hz),
                         [](double n) { return n > 0 ? 2.0 : 1.0; });
}

namespace {

// Share of the energy over the band that the taps miss, at other frequencies than those of the fit.
double missing_energy(std::span<const std::complex<double>> response, const TapFit& fit,
                      std::span<const Tap> taps) {
  double missing = 0, all = 0;
  for (std::size_t i = 0; i < response.size(); ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(response.size() - 1) - 0.5;
    const double f = fit.frequency_hz + part * fit.bandwidth_hz;
    std::complex<double> sum = 0;
    for (const Tap& tap : taps) sum += tap.gain * std::polar(1.0, -2 * kPi * f * tap.delay_s);
    missing += std::norm(response[i] - sum);
    all += std::norm(response[i]);
  }
  return all > 0 ? missing / all : 0;
}

// `response` is that of a body of this radius.
template <class Response>
ElasticTaps taps_of(const Response& response, double radius_m, const Water& water,
                    double frequency_hz, double bandwidth_hz) {
  constexpr double kLeastWindow = 8, kMostWindow = 512;  // in a/c
  constexpr double kMostPeriods = 2000, kError = 1e-3;
  const double a_c = radius_m / water.sound_speed_m_s;
  TapFit fit{frequency_hz, bandwidth_hz, 0, 0, kError / 2, 256};
  fit.delay_min_s = -2 * a_c - 1 / bandwidth_hz;
  const double most_s = std::min(kMostWindow * a_c + 2 / bandwidth_hz, kMostPeriods / bandwidth_hz);
  std::vector<std::complex<double>> checked(static_cast<std::size_t>(3 * bandwidth_hz * most_s) +
                                            33);
  for (std::size_t i = 0; i < checked.size(); ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(checked.size() - 1) - 0.5;
    checked[i] = response(frequency_hz + part * bandwidth_hz);
  }
  ElasticTaps best{{}, 1};
  for (double window = kLeastWindow; window <= kMostWindow; window *= 4) {
    fit.delay_max_s = std::min(window * a_c + 2 / bandwidth_hz, most_s);
    std::vector<Tap> taps = fit_taps(response, fit);
    const double error = missing_energy(checked, fit, taps);
    const bool full = static_cast<int>(taps.size()) == fit.most;
    if (error < best.error) best = {std::move(taps), error};
    if (best.error < kError || full || fit.delay_max_s == most_s) break;
  }
  return best;
}

}  // namespace

ElasticTaps sphere_taps(const ElasticBody& sphere, const Water& water, double frequency_hz,
                        double bandwidth_hz) {
  return taps_of([&](double f_hz) { return sphere_backscatter_m(sphere, water, f_hz); },
                 sphere.radius_m, water, frequency_hz, bandwidth_hz);
}

ElasticTaps cylinder_taps(const ElasticBody& cylinder, const Water& water, double frequency_hz,
                          double bandwidth_hz) {
  return taps_of([&](double f_hz) { return cylinder_backscatter(cylinder, water, f_hz); },
                 cylinder.radius_m, water, frequency_hz, bandwidth_hz);
}

}  // namespace ensonify
