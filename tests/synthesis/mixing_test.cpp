#include "synthesis/beamforming.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "catch.h"
#include "core/random.h"
#include "synthesis/beam_mixing.h"
#include "synthesis/cpu/gridding.h"
#include "synthesis/cpu/spread_kernel.h"
#include "synthesis/mixing_fixture.h"
#include "synthesis/ping_fixture.h"

using namespace ensonify::test;
using namespace ensonify;

// V7 for every shading, in sum and over 4,000 columns of 96 iid sectors. The mean's variance is
// that of one column, sum_jk |rho_jk|^2 / 96^2 with the beams' correlation rho, over the columns.
TEST_CASE("V7: mean-square normalization of shaded beams") {
  constexpr int kBeams = 96, kColumns = 4000;
  Sonar sonar = p900(kBeams, 24, 10);
  sonar.normalization = Normalization::mean_square;
  sonar.shading.kind =
      GENERATE(Shading::uniform, Shading::hann, Shading::taylor, Shading::chebyshev);
  const Mixing mixing = make_mixing(sonar);
  double variance = 0;
  for (int j = 0; j < kBeams; ++j) {
    for (int k = 0; k < kBeams; ++k) {
      double rho = 0;
      for (int i = 0; i < kBeams; ++i) {
        rho += mixing.weight[std::abs(i - j)] * mixing.scale[j] * mixing.weight[std::abs(i - k)] *
               mixing.scale[k];
      }
      if (j == k) CHECK(rho == Approx(1).margin(1e-6));
      variance += rho * rho / (kBeams * kBeams);
    }
  }
  AlignedBuffer<std::complex<double>> rows(kBeams * kColumns);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const ComplexDraw draw = complex_normal(18, 0, i, 0);
    rows[i] = {draw.re, draw.im};
  }
  BeamMixer(mixing).mix_amplitude(rows.data(), kColumns, kColumns, Workers(2));
  double sum = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) sum += std::norm(rows[i]);
  CHECK(sum / rows.size() == Approx(1).margin(3 * std::sqrt(variance / kColumns)));
}

// Protects the convolution against its ends joining.
TEST_CASE("the mixer equals the full product") {
  const int beams = GENERATE(1, 2, 37);
  check_mixer(make_mixing(p900(beams, beams * 0.3, 10)), beams);
}

// Protects the deposit: the kernel's stated error, and samples whose kernel wraps around the
// period's ends.
TEST_CASE("spreading gives the sums of phasors") {
  const int highest = 45, grid = 180, count = 60;
  const GriddingKernel kernel = make_gridding_kernel(grid, highest);
  std::vector<std::complex<double>> fine(grid);
  std::vector<double> x(count);
  std::vector<std::complex<double>> value(count);
  for (int i = 0; i < count; ++i) {
    x[i] = i < 4 ? (i - 2) * 1e-3 + (i == 3 ? 0.998 : 0) : uniform(8, 0, i, 0);
    value[i] = {uniform(8, 0, i, 1) - 0.5, uniform(8, 0, i, 2) - 0.5};
    spread(kernel, x[i], value[i], fine.data());
  }
  for (int k = -highest; k <= highest; ++k) {
    std::complex<double> exact = 0, obtained = 0;
    for (int i = 0; i < count; ++i) exact += value[i] * std::polar(1.0, -2 * kPi * k * x[i]);
    for (int l = 0; l < grid; ++l) {
      obtained += fine[l] * std::polar(1.0, -2 * kPi * k * l / grid);
    }
    obtained *= kernel.correction[std::abs(k)];
    CHECK(std::abs(obtained - exact) < 1e-14 * count);
  }
}

// Protects elements that share a place on the time grid: their kernel is the same function, also
// beside its own point.
TEST_CASE("wide polynomials follow the kernel beside their point") {
  const std::vector<std::complex<double>> flat(200, 1.0);
  const SpreadKernel kernel = choose_spread_kernel(flat, -100, 1e-5);
  REQUIRE(kernel.points > 0);
  const auto window = [&](double z) {
    const double inside = 1 - z * z;
    return inside > 0 ? std::exp(kernel.beta * (std::sqrt(inside) - 1)) : 0.0;
  };
  for (const double reach : {1.0, 1.3, 1.6}) {
    const WidePolynomials wide = fit_wide(kernel, reach, 1e-6);
    REQUIRE(wide.coefficient.size() == std::size_t(kernel.width + 1) / 2 * wide.terms * 2);
    for (int tap = 0; tap < kernel.width; ++tap) {
      const int pair = std::min(tap, kernel.width - 1 - tap);
      const float* c = wide.coefficient.data() + std::size_t(pair) * wide.terms * 2;
      for (double x = -1; x <= 1; x += 0.01) {
        double even = 0, odd = 0;
        for (int i = 0; i < wide.terms; ++i) {
          even = even * x * x + c[2 * i];
          odd = odd * x * x + c[2 * i + 1];
        }
        const double value = tap == pair ? even + odd * x : even - odd * x;
        const double exact = window((2 * tap + reach * x + 1) / kernel.width - 1);
        CHECK(std::abs(value - exact) * kernel.rounding_gain < 2e-6);
      }
    }
  }
  CHECK(lost_beyond(kernel, 1) == 0);
  CHECK(lost_beyond(kernel, 1.3) > 0);
  CHECK(lost_beyond(kernel, 1.6) > 2 * lost_beyond(kernel, 1.3));
  CHECK(lost_beyond(kernel, 1.6) < window(1 - 0.6 / kernel.width));
}
