#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "world/cover.h"

namespace ensonify {
namespace {

// The correlation length in units of the distance between nodes. With this value the sum of squares
// over the nodes is constant to 1e-8, and the kernel leaves out 1e-7 of it.
constexpr double kCorrelation = 2;
constexpr int kReach = 8;
constexpr int kTaps = 2 * kReach;

// As a share of the rms gradient, sqrt(2) / correlation.
constexpr double kLeastGradient = 1.0 / 7;

// The kernel and its slope per node, at the nodes around one coordinate.
struct Taps {
  std::int64_t first = 0;
  std::array<double, kTaps> value{}, slope{};
};

Taps taps_at(double nodes) {
  Taps taps;
  taps.first = static_cast<std::int64_t>(std::floor(nodes)) - kReach + 1;
  const double scale = std::pow(2 * kPi, -0.25);
  for (int i = 0; i < kTaps; ++i) {
    const double u = (nodes - static_cast<double>(taps.first + i)) / kCorrelation;
    taps.value[i] = scale * std::exp(-u * u);
    taps.slope[i] = -2 * u / kCorrelation * taps.value[i];
  }
  return taps;
}

double node_value(std::uint64_t key, std::int64_t column, std::int64_t row) {
  const std::uint64_t item =
      std::uint64_t{static_cast<std::uint32_t>(column)} << 32 | static_cast<std::uint32_t>(row);
  return std::sqrt(2.0) * complex_normal(key, 0, item, 0).re;
}

// Sums of the values and of the slopes over the nodes of one column, for a row of the grid.
struct ColumnSum {
  double value = 0, slope = 0;
};

// The rows of nodes around a row of the grid.
struct NodeRows {
  std::uint64_t key = 0;
  std::int64_t first_column = 0;
  std::size_t columns = 0;
  std::array<std::int64_t, kTaps> row{};  // in each slot, which is the row modulo kTaps
  std::array<std::vector<double>, kTaps> values = {};
};

const std::vector<double>& node_row(NodeRows& nodes, std::int64_t row) {
  const std::size_t slot = static_cast<std::uint64_t>(row) % kTaps;
  std::vector<double>& values = nodes.values[slot];
  if (!values.empty() && nodes.row[slot] == row) return values;
  nodes.row[slot] = row;
  values.resize(nodes.columns);
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = node_value(nodes.key, nodes.first_column + static_cast<std::int64_t>(i), row);
  }
  return values;
}

std::vector<ColumnSum> column_sums(const Taps& rows, NodeRows& nodes) {
  std::vector<ColumnSum> sums(nodes.columns);
  for (int i = 0; i < kTaps; ++i) {
    const std::vector<double>& values = node_row(nodes, rows.first + i);
    for (std::size_t column = 0; column < sums.size(); ++column) {
      sums[column].value += rows.value[i] * values[column];
      sums[column].slope += rows.slope[i] * values[column];
    }
  }
  return sums;
}

double smooth_step(double u) {
  u = std::clamp(u, 0.0, 1.0);
  return u * u * (3 - 2 * u);
}

}  // namespace

double standard_normal_quantile(double probability) {
  double low = -10, high = 10;
  for (int i = 0; i < 80; ++i) {
    const double middle = 0.5 * (low + high);
    (0.5 * std::erfc(-middle / std::sqrt(2.0)) < probability ? low : high) = middle;
  }
  return low;
}

std::vector<float> patch_weights(const PatchSpec& patch, std::uint64_t key, std::size_t number,
                                 const HeightGrid& grid) {
  const std::uint64_t own = mix64(mix64(key ^ name_key("patches")) ^ mix64(number));
  const double node_m = patch.correlation_m / kCorrelation;
  const double threshold = standard_normal_quantile(1 - patch.share);
  const double border = patch.border_m / node_m;
  const double least = kLeastGradient * std::sqrt(2.0) / kCorrelation;
  std::vector<Taps> columns;
  for (int column = 0; column < grid.columns; ++column) {
    columns.push_back(taps_at(column_x_m(grid, column) / node_m));
  }
  const std::int64_t first = columns.front().first;
  NodeRows nodes{own, first, static_cast<std::size_t>(columns.back().first - first + kTaps)};
  std::vector<float> weights;
  weights.reserve(grid.heights_m.size());
  for (int row = 0; row < grid.rows; ++row) {
    const std::vector<ColumnSum> sums = column_sums(taps_at(row_y_m(grid, row) / node_m), nodes);
    for (const Taps& taps : columns) {
      double value = 0, along_x = 0, along_y = 0;
      for (int i = 0; i < kTaps; ++i) {
        const ColumnSum& sum = sums[static_cast<std::size_t>(taps.first - first) + i];
        value += taps.value[i] * sum.value;
        along_x += taps.slope[i] * sum.value;
        along_y += taps.value[i] * sum.slope;
      }
      const double above = (value - threshold) / std::max(std::hypot(along_x, along_y), least);
      const double weight = border > 0 ? smooth_step(0.5 + above / border) : above > 0;
      weights.push_back(static_cast<float>(weight));
    }
  }
  return weights;
}

void lay_patches(const std::vector<PatchSpec>& patches, std::uint64_t key, const HeightGrid& grid,
                 std::vector<float>& factors) {
  const bool differs =
      !factors.empty() || std::any_of(patches.begin(), patches.end(), [](const PatchSpec& patch) {
        return patch.reflectivity_db != 0;
      });
  if (!differs) return;
  factors.resize(grid.heights_m.size(), 1);
  for (std::size_t k = 0; k < patches.size(); ++k) {
    const auto factor = static_cast<float>(std::pow(10, patches[k].reflectivity_db / 10));
    const std::vector<float> weights = patch_weights(patches[k], key, k, grid);
    for (std::size_t i = 0; i < factors.size(); ++i) {
      factors[i] += weights[i] * (factor - factors[i]);
    }
  }
}

}  // namespace ensonify
