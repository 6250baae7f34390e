#include "synthesis/mixing.h"

#include <cstdlib>

#include "catch.h"
#include "synthesis/cpu/beam_mixer.h"
#include "synthesis/ping_fixture.h"

using namespace ensonify;
using namespace ensonify::test;

// V7: sum w^2 / N_j^2 = 1 for every beam, those at the fan's edges included.
TEST_CASE("V7: mean-square normalization keeps the mean square") {
  Sonar sonar = p900(512, 90, 10);
  sonar.normalization = Normalization::mean_square;
  const Mixing mixing = make_mixing(sonar);
  for (int j = 0; j < 512; ++j) {
    double sum = 0;
    for (int i = 0; i < 512; ++i) {
      const double w = mixing.weight[std::abs(i - j)] * mixing.scale[j];
      sum += w * w;
    }
    CHECK(sum == Approx(1).margin(1e-6));
  }
  // What a point echo at the central beam loses: 8.08 dB.
  CHECK(20 * std::log10(mixing.scale[256]) == Approx(-8.08).margin(0.01));
}

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

// V7: iid sectors keep their mean square. 2,000 columns of 512 sectors; neighbours correlate over
// about 1/0.884 deg, which leaves 80 independent beams a column: standard error 1/sqrt(160,000).
TEST_CASE("V7: mixing iid sectors leaves their mean square unchanged") {
  Sonar sonar = p900(512, 90, 10);
  sonar.normalization = Normalization::mean_square;
  const int columns = 2000;
  AlignedBuffer<std::complex<double>> rows(512 * columns);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const ComplexDraw draw = complex_normal(17, 0, i, 0);
    rows[i] = {draw.re, draw.im};
  }
  BeamMixer(make_mixing(sonar)).mix_amplitude(rows.data(), columns, columns, Workers(2));
  double sum = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) sum += std::norm(rows[i]);
  CHECK(sum / rows.size() == Approx(1).margin(3 / std::sqrt(160000.0)));
}

// Protects the convolution against its ends joining and against blocks that do not come out even:
// it is the plain product with the matrix.
TEST_CASE("the mixer equals the full product") {
  const int beams = GENERATE(1, 2, 37);
  const int columns = 13, stride = 16;
  const Mixing mixing = make_mixing(p900(beams, beams * 0.3, 10));
  AlignedBuffer<std::complex<double>> rows(std::size_t(beams) * stride);
  AlignedBuffer<double> power(std::size_t(beams) * stride);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i] = {uniform(1, 0, i, 0) - 0.5, uniform(1, 0, i, 1) - 0.5};
    power[i] = uniform(1, 0, i, 2);
  }
  const std::vector<std::complex<double>> before(rows.begin(), rows.end());
  const std::vector<double> power_before(power.begin(), power.end());
  const BeamMixer mixer(mixing);
  mixer.mix_amplitude(rows.data(), columns, stride, Workers(2));
  mixer.mix_power(power.data(), columns, stride, Workers(2));
  for (int j = 0; j < beams; ++j) {
    for (int n = 0; n < columns; ++n) {
      std::complex<double> amplitude = 0;
      double square = 0;
      for (int i = 0; i < beams; ++i) {
        const double w = mixing.scale[j] * mixing.weight[std::abs(i - j)];
        amplitude += w * before[i * stride + n];
        square += w * w * power_before[i * stride + n];
      }
      REQUIRE(std::abs(rows[j * stride + n] - amplitude) < 1e-13);
      REQUIRE(power[j * stride + n] == Approx(square).margin(1e-13));
    }
  }
}
