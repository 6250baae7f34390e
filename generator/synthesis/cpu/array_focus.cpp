#include "synthesis/cpu/array_nodes.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace ensonify {
namespace {

using Complex = std::complex<double>;

constexpr int kMostOrders = 5;
// The share of the tolerance for the focus. It is small because the echoes in a beam may be much
// weaker than those at its elements.
constexpr double kFocusShare = 0.2;
constexpr int kMostTimeDegree = 5;
constexpr int kShortest = 8;  // samples of a stretch
// From this number of samples on, a stretch of lower degree in time costs less than a longer
// stretch of higher degree.
constexpr int kLongEnough = 64;
constexpr int kTapChoices[] = {6, 8, 10, 12, 14, 16, 20, 24, 28, 32};

// Fits sums of `taps` neighboring nodes to given values across the array, by least squares.
class NodeFit {
 public:
  NodeFit(const ArrayPlan& plan, double spacing_u, int taps, double stretch_y)
      : taps_(taps), points_(std::max(48, 3 * taps)), factor_(std::size_t(taps) * taps) {
    const ArrayReceiver& array = *plan.setup.sonar.array;
    const double end_m = array.elements / 2.0 * array.spacing_m * stretch_y;
    for (int p = 0; p < points_; ++p) y_.push_back(end_m * (2 * (p + 0.5) / points_ - 1));
    const double per_m = plan.setup.sonar.frequency_hz / plan.setup.water.sound_speed_m_s;
    turns_per_m_ = per_m * spacing_u;
    step_ = 2 * kPi * turns_per_m_;
    for (const double y : y_) {
      taper_.push_back(node_taper(y * turns_per_m_));
      weight_.push_back(1 / (taper_.back() * taper_.back()));
    }
    decompose();
  }

  const std::vector<double>& y() const { return y_; }
  const std::vector<double>& taper() const { return taper_; }
  int taps() const { return taps_; }

  // Coefficients [taps] for the given `value` at y(), taper included. Tap 0 lies `off` nodes after
  // the beam.
  void solve(const std::vector<Complex>& value, double off, Complex* coefficient) const {
    std::vector<Complex> right(taps_);
    for (int p = 0; p < points_; ++p) {
      const Complex turn = std::polar(1.0, step_ * y_[p]);
      Complex z = weight_[p] * value[p] * std::polar(1.0, step_ * y_[p] * off);
      for (int q = 0; q < taps_; ++q, z *= turn) right[q] += z;
    }
    for (int i = 0; i < taps_; ++i) {
      for (int k = 0; k < i; ++k) right[i] -= factor_[i * taps_ + k] * right[k];
      right[i] /= factor_[i * taps_ + i];
    }
    for (int i = taps_ - 1; i >= 0; --i) {
      for (int k = i + 1; k < taps_; ++k) right[i] -= factor_[k * taps_ + i] * right[k];
      right[i] /= factor_[i * taps_ + i];
    }
    std::copy(right.begin(), right.end(), coefficient);
  }

  double residual(const std::vector<Complex>& value, double off, const Complex* c) const {
    double sum = 0;
    for (int p = 0; p < points_; ++p) {
      const Complex turn = std::polar(1.0, -step_ * y_[p]);
      Complex z = std::polar(1.0, -step_ * y_[p] * off), got = 0;
      for (int q = 0; q < taps_; ++q, z *= turn) got += c[q] * z;
      sum += weight_[p] * std::norm(got - value[p]);
    }
    return sum / points_;
  }

 private:
  // Cholesky factor of sum_p cos(step y_p (q - q')). The diagonal is raised a little, because
  // neighboring nodes are almost dependent.
  void decompose() {
    for (int i = 0; i < taps_; ++i) {
      for (int k = 0; k <= i; ++k) {
        double sum = i == k ? 1e-13 * points_ : 0.0;
        for (int p = 0; p < points_; ++p) {
          sum += weight_[p] * std::cos(step_ * y_[p] * (i - k));
        }
        for (int l = 0; l < k; ++l) sum -= factor_[i * taps_ + l] * factor_[k * taps_ + l];
        factor_[i * taps_ + k] =
            i == k ? std::sqrt(std::max(sum, 1e-14 * points_)) : sum / factor_[k * taps_ + k];
      }
    }
  }

  int taps_, points_;
  std::vector<double> factor_, y_, taper_, weight_;
  double turns_per_m_, step_;
};

// Everything that determines the coefficients of one array.
class Focusing {
 public:
  Focusing(const ArrayPlan& plan, const ArrayNodes& nodes) : plan_(plan), nodes_(nodes) {
    const ArrayReceiver& array = *plan.setup.sonar.array;
    dynamic_ = array.focus == Focus::dynamic;
    chirped_ = dynamic_ && array.steering == Steering::true_delay;
    band_ = 0.5 * plan.setup.sonar.bandwidth_hz / plan.setup.sonar.frequency_hz;
  }

  bool dynamic() const { return dynamic_; }
  bool chirped() const { return chirped_; }
  double stretch_y() const { return chirped_ ? 1 + band_ : 1.0; }

  int first_of(int beam, int taps) const {
    return static_cast<int>(std::floor(sine(beam) / nodes_.spacing_u)) - taps / 2 + 1;
  }
  double off_of(int beam, int first) const { return first - sine(beam) / nodes_.spacing_u; }
  double sine(int beam) const { return std::sin(beam_azimuth_rad(plan_.setup.sonar, beam)); }

  // The values at `y` that the sums of nodes must have at the frequency f_c + x b/2.
  void values(int beam, double sample, double x, const NodeFit& fit,
              std::vector<Complex>& value) const {
    const std::vector<double>& y = fit.y();
    const double shrink = chirped_ ? 1 / (1 + x * band_) : 1.0;
    value.assign(fit.taper().begin(), fit.taper().end());
    if (!dynamic_) return;
    const Sonar& sonar = plan_.setup.sonar;
    const double c = plan_.setup.water.sound_speed_m_s;
    const double range_m = sample * c / (2 * sonar.bandwidth_hz);
    const double azimuth = beam_azimuth_rad(sonar, beam);
    for (std::size_t p = 0; p < y.size(); ++p) {
      const double delay_s = focus_delay_s(y[p] * shrink, azimuth, range_m, c);
      value[p] *= std::polar(1.0, 2 * kPi * sonar.frequency_hz * delay_s);
    }
  }

  // out: [orders][taps].
  void place_coefficients(const NodeFit& fit, int beam, double sample, int orders,
                          std::vector<Complex>& out) const {
    const int taps = fit.taps();
    const double off = off_of(beam, first_of(beam, taps));
    std::vector<Complex> value, at(taps);
    out.assign(std::size_t(orders) * taps, 0);
    for (int i = 0; i < orders; ++i) {
      const double angle = kPi * (i + 0.5) / orders;
      values(beam, sample, std::cos(angle), fit, value);
      fit.solve(value, off, at.data());
      for (int k = 0; k < orders; ++k) {
        const double w = (k == 0 ? 1.0 : 2.0) / orders * std::cos(k * angle);
        for (int q = 0; q < taps; ++q) out[std::size_t(k) * taps + q] += w * at[q];
      }
    }
  }

  // Relative error of a beam at a sample, as rms over the array and the band.
  double error(const NodeFit& fit, int beam, double sample, int orders,
               const std::vector<Complex>& coefficient) const {
    const int taps = fit.taps();
    const double off = off_of(beam, first_of(beam, taps));
    std::vector<Complex> value, at(taps);
    double sum = 0;
    const std::vector<double> places =
        chirped_ ? std::vector<double>{-0.95, -0.6, -0.2, 0.2, 0.6, 0.95} : std::vector<double>{0};
    for (const double x : places) {
      std::fill(at.begin(), at.end(), Complex(0));
      for (int k = 0; k < orders; ++k) {
        const double w = std::cos(k * std::acos(x));
        for (int q = 0; q < taps; ++q) at[q] += w * coefficient[std::size_t(k) * taps + q];
      }
      values(beam, sample, x, fit, value);
      sum += fit.residual(value, off, at.data());
    }
    return std::sqrt(sum / places.size());
  }

 private:
  const ArrayPlan& plan_;
  const ArrayNodes& nodes_;
  bool dynamic_ = false, chirped_ = false;
  double band_ = 0;
};

// The beams at which errors are measured, as a sample of all beams.
std::vector<int> judged_beams(const Sonar& sonar) {
  const int beams = sonar.beam_count;
  std::vector<int> judged = {0, beams / 3, beams / 2};
  if (!sonar.azimuth_rad.empty()) judged.push_back(beams - 1);
  return judged;
}

// Chooses taps and orders that hold the tolerance at one sample. Returns false if none do.
bool choose_size(const ArrayPlan& plan, const Focusing& focusing, const ArrayNodes& nodes,
                 double sample, NodeStretch& stretch) {
  const double tolerance = kFocusShare * plan.setup.tolerance;
  std::vector<Complex> coefficient;
  for (const int taps : kTapChoices) {
    const NodeFit fit(plan, nodes.spacing_u, taps, focusing.stretch_y());
    for (int orders = 1; orders <= (focusing.chirped() ? kMostOrders : 1); ++orders) {
      double worst = 0;
      for (const int beam : judged_beams(plan.setup.sonar)) {
        focusing.place_coefficients(fit, beam, sample, orders, coefficient);
        worst = std::max(worst, focusing.error(fit, beam, sample, orders, coefficient));
      }
      if (worst > tolerance) continue;
      stretch.taps = taps;
      stretch.orders = orders;
      return true;
    }
  }
  return false;
}

// The phase of the focus at the array's end for a beam ahead, in turns of the carrier.
double focus_turns(const ArrayPlan& plan, double sample) {
  const Sonar& sonar = plan.setup.sonar;
  const double c = plan.setup.water.sound_speed_m_s;
  const double end_m = (plan.elements() - 1) / 2.0 * sonar.array->spacing_m;
  return sonar.frequency_hz * focus_delay_s(end_m, 0, sample * c / (2 * sonar.bandwidth_hz), c);
}

// Coefficients of a beam as sums of Chebyshev polynomials of the stretch's time,
// [orders][taps][degree + 1].
std::vector<Complex> in_time(const Focusing& focusing, const NodeFit& fit, int beam,
                             const NodeStretch& stretch) {
  const int terms = stretch.degree + 1, count = stretch.orders * stretch.taps;
  std::vector<Complex> at, sum(std::size_t(count) * terms);
  for (int i = 0; i < terms; ++i) {
    const double angle = kPi * (i + 0.5) / terms;
    const double last = 1.0 / (stretch.end - 1), first = 1.0 / std::max(stretch.begin, 1);
    const double sample = 2 / (first + last + (first - last) * std::cos(angle));
    focusing.place_coefficients(fit, beam, sample, stretch.orders, at);
    for (int k = 0; k < terms; ++k) {
      const double w = (k == 0 ? 1.0 : 2.0) / terms * std::cos(k * angle);
      for (int q = 0; q < count; ++q) sum[std::size_t(q) * terms + k] += w * at[q];
    }
  }
  return sum;
}

// Converts a sum of Chebyshev polynomials to powers.
void powers_of(const Complex* c, int degree, Complex* power) {
  static constexpr double kPowers[kMostTimeDegree + 1][kMostTimeDegree + 1] = {
      {1}, {0, 1}, {-1, 0, 2}, {0, -3, 0, 4}, {1, 0, -8, 0, 8}, {0, 5, 0, -20, 0, 16}};
  for (int i = 0; i <= degree; ++i) {
    power[i] = 0;
    for (int k = i; k <= degree; ++k) power[i] += kPowers[k][i] * c[k];
  }
}

void fill_beam(const Focusing& focusing, const NodeFit& fit, int beam, NodeStretch& stretch) {
  const std::vector<Complex> sum = in_time(focusing, fit, beam, stretch);
  const int terms = stretch.degree + 1;
  stretch.first[beam] = focusing.first_of(beam, stretch.taps);
  float* out = stretch.coefficient.data() + 2 * beam * sum.size();
  for (std::size_t q = 0; q < sum.size(); q += terms) {
    Complex power[kMostTimeDegree + 1];
    powers_of(sum.data() + q, stretch.degree, power);
    for (int k = stretch.degree; k >= 0; --k) {
      *out++ = static_cast<float>(power[k].real());
      *out++ = static_cast<float>(power[k].imag());
    }
  }
}

// Copies the coefficients of the opposite beam, because a fan of equal beams is symmetric.
void mirror_beam(int beam, int from, NodeStretch& stretch) {
  const int terms = stretch.degree + 1;
  const std::size_t size = std::size_t(stretch.orders) * stretch.taps * terms * 2;
  const float* source = stretch.coefficient.data() + from * size;
  float* out = stretch.coefficient.data() + beam * size;
  for (int k = 0; k < stretch.orders; ++k) {
    for (int q = 0; q < stretch.taps; ++q) {
      const std::size_t row = std::size_t(k) * stretch.taps;
      std::copy_n(source + (row + stretch.taps - 1 - q) * terms * 2, terms * 2,
                  out + (row + q) * terms * 2);
    }
  }
  stretch.first[beam] = -(stretch.first[from] + stretch.taps - 1);
}

void fill_stretch(const ArrayPlan& plan, const Focusing& focusing, const ArrayNodes& nodes,
                  NodeStretch& stretch) {
  const NodeFit fit(plan, nodes.spacing_u, stretch.taps, focusing.stretch_y());
  const int beams = plan.beams();
  stretch.first.resize(beams);
  stretch.coefficient.resize(std::size_t(beams) * stretch.orders * stretch.taps *
                             (stretch.degree + 1) * 2);
  const int filled = plan.setup.sonar.azimuth_rad.empty() ? (beams + 1) / 2 : beams;
  for (int j = 0; j < filled; ++j) fill_beam(focusing, fit, j, stretch);
  for (int j = filled; j < beams; ++j) mirror_beam(j, beams - 1 - j, stretch);
}

// The first sample of the longest stretch before `end` for which polynomials of a degree in time
// hold the tolerance.
int begin_of_stretch(const ArrayPlan& plan, int end, int degree) {
  // For a phasor that turns by phi, polynomials of degree n have the error
  // phi^(n + 1) / (2^(2 n + 1) (n + 1)!). The mean over the array is a third of the error at its
  // ends.
  const double error = 3 * kFocusShare * plan.setup.tolerance;
  const double per_turn = degree == 3 ? 3072 : 1474560;
  const double at_once = std::pow(error * per_turn, 1.0 / (degree + 1)) / (2 * kPi);
  const double turns = focus_turns(plan, std::max(end - 1, 1)) + at_once;
  // The phase of the focus grows as 1 / sample toward the sonar.
  int begin = end - 1;
  while (begin > 16 && focus_turns(plan, begin - 1) < turns && end - begin < 4096) --begin;
  return begin;
}

}  // namespace

void choose_stretches(const ArrayPlan& plan, ArrayNodes& nodes) {
  const Focusing focusing(plan, nodes);
  int end = plan.samples();
  nodes.near_samples = end;
  nodes.orders = 1;
  while (end > 0) {
    NodeStretch stretch;
    stretch.end = end;
    stretch.begin = 0;
    if (focusing.dynamic()) {
      for (const int degree : {3, 5}) {
        stretch.degree = degree;
        stretch.begin = begin_of_stretch(plan, end, degree);
        if (end - stretch.begin >= kLongEnough) break;
      }
      if (end - stretch.begin < kShortest) break;
    }
    if (!choose_size(plan, focusing, nodes, std::max(stretch.begin, 1), stretch)) break;
    fill_stretch(plan, focusing, nodes, stretch);
    nodes.orders = std::max(nodes.orders, stretch.orders);
    nodes.near_samples = end = stretch.begin;
    nodes.stretches.push_back(std::move(stretch));
  }
}

}  // namespace ensonify
