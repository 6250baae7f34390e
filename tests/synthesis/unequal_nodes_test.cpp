// Nodes for unequal beams: their error over all cells, and the CPU backend against the reference.
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "core/random.h"
#include "synthesis/beamforming.h"
#include "synthesis/cpu/beam_nodes.h"
#include "synthesis/v8.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

struct Layout {
  std::string name;
  std::vector<double> azimuth_deg, width_deg;  // increasing, and one width for each
};

// Equal steps of sin(azimuth), with the widths of a line array steered there.
Layout sine_spaced(int beams, double end_deg, double width_deg) {
  Layout layout{"sine", {}, {}};
  for (int j = 0; j < beams; ++j) {
    const double azimuth_rad = std::asin(std::sin(radians(end_deg)) * (2.0 * j / (beams - 1) - 1));
    layout.azimuth_deg.push_back(degrees(azimuth_rad));
    layout.width_deg.push_back(width_deg / std::cos(azimuth_rad));
  }
  return layout;
}

// Steps from step_deg[0] to step_deg[1] and widths from width_deg[0] to width_deg[1], uniform in
// the logarithm.
Layout random_layout(int beams, std::vector<double> step_deg, std::vector<double> width_deg,
                     std::uint64_t seed) {
  Layout layout{"random", {}, {}};
  const auto draw = [&](const std::vector<double>& ends, int j, std::uint32_t what) {
    return ends[0] * std::pow(ends[1] / ends[0], uniform(seed, 0, j, what));
  };
  double azimuth_deg = 0;
  for (int j = 0; j < beams; ++j) {
    layout.azimuth_deg.push_back(azimuth_deg);
    layout.width_deg.push_back(draw(width_deg, j, 1));
    azimuth_deg += draw(step_deg, j, 0);
  }
  for (double& a : layout.azimuth_deg) a -= azimuth_deg / 2;
  return layout;
}

// Clusters of beams a twentieth of a degree apart, with gaps in which no beam points.
Layout clustered(int clusters, int beams_of_each, double gap_deg) {
  Layout layout{"clustered", {}, {}};
  for (int c = 0; c < clusters; ++c) {
    for (int j = 0; j < beams_of_each; ++j) {
      layout.azimuth_deg.push_back((c - (clusters - 1) / 2.0) * gap_deg + 0.05 * j);
      layout.width_deg.push_back(1);
    }
  }
  return layout;
}

Sonar sonar_of(const Layout& layout, double range_max_m = 3) {
  const int beams = static_cast<int>(layout.azimuth_deg.size());
  Sonar sonar = p900(beams, beams == 1 ? 1.0 : 10.0, range_max_m);
  for (const double a : layout.azimuth_deg) sonar.azimuth_rad.push_back(radians(a));
  for (const double w : layout.width_deg) sonar.width_rad.push_back(radians(w));
  const std::vector<double> borders = beam_borders_rad(sonar);
  sonar.beam_spacing_rad = (borders.back() - borders.front()) / beams;
  return sonar;
}

// The largest error of a column of R P^T, relative to the column of W. `Value`: of all factors and
// products.
template <class Value = double>
double worst_column(const BeamNodes& nodes, const std::vector<double>& matrix) {
  const int beams = nodes.beams;
  double worst = 0;
  for (int i = 0; i < beams; ++i) {
    double error = 0, norm = 0;
    for (int j = 0; j < beams; ++j) {
      const double w = matrix[std::size_t(j) * beams + i];
      double sum = 0;
      for (int a = 0; a < nodes.width; ++a) {
        sum += static_cast<Value>(nodes.weight[std::size_t(i) * nodes.width + a]) *
               static_cast<Value>(nodes.matrix[std::size_t(j) * nodes.nodes + nodes.first[i] + a]);
      }
      error += std::pow(sum - w, 2);
      norm += w * w;
    }
    if (error > 0) worst = std::max(worst, std::sqrt(error / norm));
  }
  return worst;
}

std::vector<double> weights_of(const Sonar& sonar, bool squared) {
  std::vector<double> matrix = make_mixing(sonar).matrix;
  for (double& w : matrix) w = squared ? w * w : w;
  return matrix;
}

}  // namespace

// Protects every layout from another error than the stated one: that of any cell, also of one that
// all beams hear faintly.
TEST_CASE("nodes of unequal beams hold the tolerance for every cell") {
  const std::vector<Layout> layouts = {
      {"one", {3}, {1}},
      {"two", {-4, 9}, {0.5, 20}},
      sine_spaced(160, 60, 1.2),
      clustered(3, 40, 12),
      random_layout(150, {0.1, 0.3}, {1, 1}, 3),
      random_layout(150, {0.05, 0.5}, {1, 4}, 4),
      random_layout(90, {0.02, 3}, {0.2, 20}, 5),
      random_layout(60, {0.3, 3}, {0.3, 0.3}, 6),
  };
  for (const double tolerance : {3e-4, 3e-6, 3e-7}) {
    for (const Layout& layout : layouts) {
      for (const bool squared : {false, true}) {
        const Sonar sonar = sonar_of(layout);
        const std::vector<double> matrix = weights_of(sonar, squared);
        const BeamNodes nodes =
            choose_unequal_nodes(matrix, make_mixing(sonar).middle_rad, tolerance, 650);
        CAPTURE(layout.name, layout.azimuth_deg.size(), tolerance, squared, nodes.nodes);
        CHECK_FALSE(nodes.is_equal);
        CHECK(nodes.nodes % 2 == 0);
        CHECK(worst_column(nodes, matrix) <= tolerance);
        // The error of the fit and that of rounding are each within the tolerance.
        CHECK(worst_column<float>(nodes, matrix) <= 1.5 * tolerance);
        CHECK(nodes.error <= tolerance);
      }
    }
  }
}

// Protects the gain: beams that overlap share nodes, also where each has its own width.
TEST_CASE("overlapping unequal beams need fewer nodes than beams") {
  for (const Layout& layout :
       {sine_spaced(200, 20, 1), random_layout(200, {0.1, 0.3}, {1, 3}, 7)}) {
    const Sonar sonar = sonar_of(layout);
    const BeamNodes nodes =
        choose_unequal_nodes(weights_of(sonar, false), make_mixing(sonar).middle_rad, 3e-6, 650);
    CAPTURE(layout.name);
    CHECK(nodes.nodes < 100);
    CHECK(nodes.width > 1);
  }
}

// Protects layouts that no nodes represent: each cell is its own node, and the weights are exact.
TEST_CASE("unequal beams that share nothing have a node for each cell") {
  const Sonar sonar = sonar_of(random_layout(61, {0.9, 1.4}, {0.5, 1}, 8));
  const std::vector<double> matrix = weights_of(sonar, false);
  const BeamNodes nodes = choose_unequal_nodes(matrix, make_mixing(sonar).middle_rad, 3e-6, 650);
  CHECK(nodes.nodes == 62);
  CHECK(nodes.width == 1);
  CHECK(worst_column(nodes, matrix) == 0);
}

TEST_CASE("V8: unequal beams of every kind") {
  const std::vector<Layout> layouts = {
      {"one", {3}, {1}},
      {"two", {-4, 9}, {0.5, 20}},
      sine_spaced(64, 10, 1.2),
      clustered(2, 30, 6),
      random_layout(60, {0.02, 0.4}, {0.7, 9}, 9),
  };
  for (const Layout& layout : layouts) {
    CAPTURE(layout.name, layout.azimuth_deg.size());
    Sonar sonar = sonar_of(layout, 4);
    if (layout.name == "sine") sonar.normalization = Normalization::mean_square;
    if (layout.name == "clustered") sonar.shading.kind = Shading::taylor;
    require_agreement({.sonar = sonar,
                       .scatterers = random_scatterers(sonar, 150, 0.5, 11),
                       .judged_tenths = 8,
                       .tolerances = {1e-3, 1e-5, 1e-6, 1e-7}});
  }
}

// A strong echo before faint ones, from any cell: what unequal beams share holds no less.
TEST_CASE("V8: unequal beams with a strong echo at 1.5 m before a faint far field", "[figure]") {
  const Sonar sonar = sonar_of(sine_spaced(48, 8, 1), 20);
  require_agreement(
      {.sonar = sonar,
       .scatterers = strong_before_faint(sonar, 12, 8, -80),
       .judged_tenths = 1,
       .volumes = {volume_of(setup_of(sonar),
                             [](int beam, int n) { return beam == 40 && n > 30 ? 1e-16 : 0.0; })},
       .tolerances = {1e-5, 1e-6}});
}
