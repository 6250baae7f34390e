// The fast path's parts, and what it promises beside its error (which V8 judges).

#include "catch.h"
#include "core/random.h"
#include "synthesis/beamforming.h"
#include "synthesis/cpu/beam_nodes.h"
#include "synthesis/cpu/kernels.h"
#include "synthesis/cpu/spread_kernel.h"
#include "synthesis/ping_fixture.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

struct Case {
  SynthesisSetup setup;
  ScattererList list;
  std::vector<VolumeEcho> water;
};

Case small_case() {
  const Sonar sonar = p900(80, 16, 3);
  Case c{setup_of(sonar), sorted_by_beam_and_delay(random_scatterers(sonar, 900, 0.4, 31), 80), {}};
  c.water.push_back(volume_of(c.setup, [](int beam, int n) { return 1e-9 * (beam + n); }));
  return c;
}

bool same(const PingSeries& a, const PingSeries& b) {
  return a.pressure_pa == b.pressure_pa && a.clean_power_pa2 == b.clean_power_pa2;
}

}  // namespace

// Protects speckle, noise and volumes from being other numbers than the exported ones: all draws
// near either end of the first word's range are rare, so they come in by many draws.
TEST_CASE("vectors of normals are those of the keyed generator") {
  constexpr int kCount = 40003;
  std::vector<std::uint32_t> low(kCount), high(kCount);
  for (int i = 0; i < kCount; ++i) {
    low[i] = 0xFFFFB000u + static_cast<std::uint32_t>(i);
    high[i] = static_cast<std::uint32_t>(i % 7) << 29;
  }
  std::vector<float> re(kCount), im(kCount);
  for (const SimdLevel level : {SimdLevel::sse4, SimdLevel::avx2, SimdLevel::avx512}) {
    if (level > best_simd_level()) continue;
    const std::uint64_t key = 0x123456789ABCDEFull;
    kernels_of(level).draw_normals(key, 77, low.data(), high.data(), kCount, re.data(), im.data());
    double worst = 0;
    for (int i = 0; i < kCount; ++i) {
      const ComplexDraw xi = complex_normal(key, 77, (std::uint64_t{high[i]} << 32) | low[i], 0);
      const double size = std::hypot(xi.re, xi.im);
      worst = std::max(worst, std::hypot(re[i] - xi.re, im[i] - xi.im) / size);
    }
    INFO(simd_level_name(level));
    CHECK(worst < 6e-7);
  }
}

// Protects the nodes' stated error, which only some columns are judged for when nodes are chosen.
TEST_CASE("few nodes hold the weights of many beams") {
  const double tolerance = GENERATE(1e-3, 1e-5, 1e-6);
  Sonar sonar = p900(200, 35, 10);
  sonar.shading.kind = GENERATE(Shading::uniform, Shading::taylor);
  std::vector<double> weight = make_mixing(sonar).weight;
  if (GENERATE(false, true)) {
    for (double& w : weight) w *= w;
  }
  const BeamNodes nodes = choose_beam_nodes(weight, tolerance, 650);
  CHECK(nodes.nodes < 120);
  for (int i = 0; i < 200; ++i) {
    std::vector<double> mixed(nodes.nodes);
    for (int a = 0; a < nodes.width; ++a) {
      for (int c = 0; c < nodes.nodes; ++c) {
        mixed[c] += nodes.weight[i * nodes.width + a] *
                    nodes.matrix[std::size_t(nodes.first[i] + a) * nodes.nodes + c];
      }
    }
    double error = 0, norm = 0;
    for (int j = 0; j < 200; ++j) {
      double sum = 0;
      for (int a = 0; a < nodes.width; ++a) {
        sum += nodes.weight[j * nodes.width + a] * mixed[nodes.first[j] + a];
      }
      error += std::pow(sum - weight[std::abs(i - j)], 2);
      norm += std::pow(weight[std::abs(i - j)], 2);
    }
    INFO("column " << i);
    REQUIRE(std::sqrt(error / norm) < 1.2 * tolerance);
  }
}

// Protects fans whose beams share nothing: one node a beam, an odd number of them included.
TEST_CASE("beams as wide as their spacing have a node each") {
  const std::vector<double> weight = make_mixing(p900(31, 62, 10)).weight;
  const BeamNodes nodes = choose_beam_nodes(weight, 1e-5, 650);
  CHECK(nodes.nodes == 32);
  CHECK(nodes.width == 1);
  CHECK(nodes.matrix[3 * 32 + 7] == weight[4]);
}

// Protects the kernel's stated error, its polynomials and its correction, by direct sums.
TEST_CASE("the spreading kernel gives phasors within its tolerance") {
  const double tolerance = GENERATE(1e-3, 1e-5, 1e-6);
  constexpr int kHighest = 60;
  const SpreadKernel kernel = choose_spread_kernel(
      std::vector<std::complex<double>>(2 * kHighest + 1, 1.0), -kHighest, tolerance);
  REQUIRE(kernel.points > 2 * kHighest);
  double error = 0;
  constexpr int kCount = 40;
  for (int i = 0; i < kCount; ++i) {
    const double x = uniform(8, 0, i, 0);
    const double edge = x * kernel.points - kernel.width / 2.0;
    const double first = std::ceil(edge), t = 2 * (first - edge) - 1;
    for (int k = -kHighest; k <= kHighest; ++k) {
      std::complex<double> sum = 0;
      for (int l = 0; l < kernel.width; ++l) {
        double value = 0;
        const int floats = kernel.polynomial().chunks * 8;
        for (int d = 0; d <= kernel.degree; ++d) {
          value = value * t + kernel.coefficient[d * floats + 2 * l];
        }
        sum += value * std::polar(1.0, -2 * kPi * k * (first + l) / kernel.points);
      }
      error += std::norm(sum * kernel.correction[std::abs(k)] - std::polar(1.0, -2 * kPi * k * x));
    }
  }
  CHECK(std::sqrt(error / (kCount * (2 * kHighest + 1))) < 1.1 * tolerance);
}

TEST_CASE("results do not depend on the number of threads, and hardly on the level") {
  Case c = small_case();
  c.setup.tolerance = GENERATE(1e-5, 1e-7);
  const RandomKeys keys = keys_of_ping(2, 5);
  const auto backend = make_cpu_backend(c.setup);
  const PingSeries one = synthesize(*backend, c.list, keys, 1e-3, c.water, Workers(1));
  for (const int threads : {2, 5}) {
    CHECK(same(one, synthesize(*backend, c.list, keys, 1e-3, c.water, Workers(threads))));
  }
  for (const SimdLevel level : {SimdLevel::sse4, SimdLevel::avx2}) {
    if (level >= best_simd_level()) continue;
    c.setup.simd = level;
    const PingSeries other =
        synthesize(*make_cpu_backend(c.setup), c.list, keys, 1e-3, c.water, Workers(1));
    double error = 0, norm = 0;
    for (std::size_t i = 0; i < one.pressure_pa.size(); ++i) {
      error += std::norm(other.pressure_pa[i] - one.pressure_pa[i]);
      norm += std::norm(one.pressure_pa[i]);
    }
    CHECK(std::sqrt(error / norm) < 3e-6);
  }
}

// Protects the scratch memory that pings share: different pings at once, and again after others.
TEST_CASE("one backend serves several threads at once") {
  const Case c = small_case();
  const auto backend = make_cpu_backend(c.setup);
  const ScattererList few = sorted_by_beam_and_delay({point_target(c.setup.sonar, 5, 2, -30)}, 80);
  const auto ping = [&](int i) {
    const bool wet = i % 3 == 0;
    return synthesize(*backend, i % 2 == 0 ? c.list : few, keys_of_ping(i), 0,
                      wet ? std::span(c.water) : std::span<const VolumeEcho>(), Workers(1));
  };
  std::vector<PingSeries> alone, together(12);
  for (int i = 0; i < 12; ++i) alone.push_back(ping(i));
  Workers(4).for_each(12, [&](std::size_t i) { together[i] = ping(static_cast<int>(i)); });
  for (int i = 0; i < 12; ++i) CHECK(same(alone[i], together[i]));
}

TEST_CASE("series keep their memory, and clean is made only where it is wanted") {
  Case c = small_case();
  c.setup.tolerance = GENERATE(1e-5, 1e-7);
  for (const bool reference : {false, true}) {
    const auto backend = reference ? make_reference_backend(c.setup) : make_cpu_backend(c.setup);
    PingTask task{&c.list, keys_of_ping(1), 0, c.water};
    PingSeries series;
    backend->synthesize({&task, 1}, {&series, 1}, Workers(2));
    const PingSeries before = series;
    const auto* memory = series.pressure_pa.data();
    backend->synthesize({&task, 1}, {&series, 1}, Workers(2));
    CHECK(same(series, before));
    if (!reference) CHECK(series.pressure_pa.data() == memory);
    task.wants_clean = false;
    backend->synthesize({&task, 1}, {&series, 1}, Workers(2));
    CHECK(series.clean_power_pa2.empty());
    CHECK(series.pressure_pa == before.pressure_pa);
    if (c.setup.tolerance < 1e-6) break;
  }
}
