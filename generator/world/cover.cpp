#include "world/cover.h"

#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "core/units.h"

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

namespace {

// Mean number of stones in a tile, which is the part of the plane that one set of keys fills.
constexpr double kPerTile = 16;

// A random number with the Poisson distribution of this mean, by inversion.
int poisson(double mean, double uniform) {
  double term = std::exp(-mean);
  int count = 0;
  for (double sum = term; sum < uniform && count < 1000; sum += term) term *= mean / ++count;
  return count;
}

double between(const std::array<double, 2>& range, std::uint32_t word) {
  return range[0] + uniform_from_word(word) * (range[1] - range[0]);
}

// The inverse of the distribution (1 - (D / smallest)^-b) / (1 - (largest / smallest)^-b).
double diameter(const StoneSpec& stones, std::uint32_t word) {
  const auto [smallest, largest] = stones.diameter_m;
  const double all = 1 - std::pow(largest / smallest, -stones.exponent);
  return smallest * std::pow(1 - uniform_from_word(word) * all, -1 / stones.exponent);
}

bool reaches(const Stone& stone, std::array<double, 2> half_m) {
  const double radius = stone.diameter_m / 2;
  return std::abs(stone.x_m) <= half_m[0] + radius && std::abs(stone.y_m) <= half_m[1] + radius;
}

// The height of the bed by bilinear interpolation; outside the grid, the height of its edge.
double bed_m(const HeightGrid& grid, double x_m, double y_m) {
  const double u = std::clamp((x_m - column_x_m(grid, 0)) / grid.cell_m, 0.0, grid.columns - 1.0);
  const double v = std::clamp((row_y_m(grid, 0) - y_m) / grid.cell_m, 0.0, grid.rows - 1.0);
  const int column = std::min(static_cast<int>(u), grid.columns - 2);
  const int row = std::min(static_cast<int>(v), grid.rows - 2);
  const double* north = &grid.heights_m[std::size_t(row) * grid.columns + column];
  const double* south = north + grid.columns;
  const double p = u - column, q = v - row;
  return (1 - q) * ((1 - p) * north[0] + p * north[1]) + q * ((1 - p) * south[0] + p * south[1]);
}

struct LaidStone {
  Stone stone;
  double bed_m = 0;
  float factor = 1;
};

void lay(const LaidStone& laid, HeightGrid& grid, std::vector<float>& factors) {
  const Stone& stone = laid.stone;
  const double radius = stone.diameter_m / 2;
  const auto index = [&](double at_m, int count) {
    const double i = at_m / grid.cell_m + 0.5 * (count - 1);
    return static_cast<int>(std::clamp(std::ceil(i), 0.0, double(count)));
  };
  const int end_row = index(radius - stone.y_m, grid.rows);
  const int end_column = index(stone.x_m + radius, grid.columns);
  for (int row = index(-stone.y_m - radius, grid.rows); row < end_row; ++row) {
    for (int column = index(stone.x_m - radius, grid.columns); column < end_column; ++column) {
      const auto above = stone_height_m(stone, column_x_m(grid, column), row_y_m(grid, row));
      const std::size_t at = std::size_t(row) * grid.columns + column;
      if (!above || !(laid.bed_m + *above > grid.heights_m[at])) continue;
      grid.heights_m[at] = laid.bed_m + *above;
      if (!factors.empty()) factors[at] = laid.factor;
    }
  }
}

}  // namespace

std::vector<Stone> stones_within(const StoneSpec& stones, std::uint64_t key, std::size_t number,
                                 std::array<double, 2> half_m) {
  std::vector<Stone> found;
  if (!(stones.density_per_m2 > 0)) return found;
  const std::uint64_t own = mix64(mix64(key ^ name_key("stones")) ^ mix64(number));
  const double tile_m = std::sqrt(kPerTile / stones.density_per_m2);
  const auto last_tile = [&](int axis) {
    return static_cast<std::int64_t>(
        std::floor((half_m[axis] + stones.diameter_m[1] / 2) / tile_m));
  };
  const std::int64_t last_x = last_tile(0), last_y = last_tile(1);
  for (std::int64_t j = -last_y - 1; j <= last_y; ++j) {
    for (std::int64_t i = -last_x - 1; i <= last_x; ++i) {
      const std::uint64_t tile =
          std::uint64_t{static_cast<std::uint32_t>(i)} << 32 | static_cast<std::uint32_t>(j);
      const int count = poisson(kPerTile, uniform(own, 0, tile, 0));
      for (int k = 0; k < count; ++k) {
        const auto draw = static_cast<std::uint32_t>(k);
        const Philox4 first = random_words(own, 1, tile, draw);
        const Philox4 second = random_words(own, 2, tile, draw);
        Stone stone;
        stone.x_m = (static_cast<double>(i) + uniform_from_word(first.v[0])) * tile_m;
        stone.y_m = (static_cast<double>(j) + uniform_from_word(first.v[1])) * tile_m;
        stone.diameter_m = diameter(stones, first.v[2]);
        stone.yaw_rad = kPi * uniform_from_word(first.v[3]);
        stone.aspect = between(stones.aspect, second.v[0]);
        stone.height_m = stone.diameter_m * between(stones.height_ratio, second.v[1]);
        stone.buried_fraction = between(stones.buried_fraction, second.v[2]);
        if (reaches(stone, half_m)) found.push_back(stone);
      }
    }
  }
  return found;
}

std::optional<double> stone_height_m(const Stone& stone, double x_m, double y_m) {
  const double c = std::cos(stone.yaw_rad), s = std::sin(stone.yaw_rad);
  const double dx = x_m - stone.x_m, dy = y_m - stone.y_m;
  const double along = 2 * (c * dx + s * dy) / stone.diameter_m;
  const double across = 2 * (c * dy - s * dx) / (stone.aspect * stone.diameter_m);
  const double square = along * along + across * across;
  if (!(square < 1)) return std::nullopt;
  return stone.height_m * (0.5 - stone.buried_fraction + 0.5 * std::sqrt(1 - square));
}

void lay_stones(const std::vector<StoneSpec>& populations, std::uint64_t key, HeightGrid& grid,
                std::vector<float>& factors) {
  const std::array<double, 2> half_m{column_x_m(grid, grid.columns - 1), row_y_m(grid, 0)};
  std::vector<LaidStone> laid;
  for (std::size_t k = 0; k < populations.size(); ++k) {
    const auto factor = static_cast<float>(std::pow(10, populations[k].reflectivity_db / 10));
    if (factor != 1) factors.resize(grid.heights_m.size(), 1);
    // All stones stand on the bed and none on another stone.
    for (const Stone& stone : stones_within(populations[k], key, k, half_m)) {
      laid.push_back({stone, bed_m(grid, stone.x_m, stone.y_m), factor});
    }
  }
  for (const LaidStone& stone : laid) lay(stone, grid, factors);
}

}  // namespace ensonify
