// Plain patches: rectangles of 32 samples and 24 beams of the grid, half a rectangle apart, that
// show speckle and nothing else. From the levels in dB of a patch a plane is taken away (least
// squares). The patch is plain if the means of its 12 blocks of 8 x 8 pixels then spread by less
// than 1.5 dB, if the plane rises by less than 6 dB along and across it, and if the patch's mean
// lies between the 60 % and the 97 % quantile of those of all patches of the image, which excludes
// noise and echoes of objects.
#include <algorithm>
#include <cmath>

#include "compare/measure_parts.h"

namespace ensonify {
namespace {

constexpr int kPlainRows = 32, kPlainColumns = 24, kPlainBlock = 8;
constexpr double kMostOfBlocks = 1.5, kMostRise = 6;  // dB
constexpr double kFromMeans = 0.6, kToMeans = 0.97;   // quantiles
// Tiles that blocks and patches are made of; patches begin every 2 x 3 tiles.
constexpr int kTileRows = 8, kTileColumns = 4;
constexpr int kPatchTileRows = kPlainRows / kTileRows,
              kPatchTileColumns = kPlainColumns / kTileColumns;

// Sums of the levels, and of their products with rows and columns from the tile's middle.
struct Tile {
  double sum = 0, row_moment = 0, column_moment = 0;
  float first = 0;
  bool is_whole = true, is_constant = true;
};

struct Tiles {
  int rows = 0, columns = 0;
  std::vector<Tile> tiles;

  const Tile& at(int row, int column) const {
    return tiles[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
                 static_cast<std::size_t>(column)];
  }
};

Tile tile_of(const Frame& frame, const Picture& picture, int row, int column) {
  Tile tile;
  tile.first = picture.level[frame.at(row, column)];
  for (int r = 0; r < kTileRows; ++r) {
    const float* level = picture.level.data() + frame.at(row + r, column);
    const std::uint8_t* measured = frame.measured.data() + frame.at(row + r, column);
    double line = 0;
    for (int c = 0; c < kTileColumns; ++c) {
      const auto value = static_cast<double>(level[c]);
      line += value;
      tile.column_moment += (c - (kTileColumns - 1) / 2.0) * value;
      tile.is_whole = tile.is_whole && measured[c] != 0;
      tile.is_constant = tile.is_constant && level[c] == tile.first;
    }
    tile.sum += line;
    tile.row_moment += (r - (kTileRows - 1) / 2.0) * line;
  }
  return tile;
}

Tiles tiles_of(const Frame& frame, const Picture& picture) {
  Tiles tiles{frame.rows / kTileRows, frame.columns / kTileColumns, {}};
  for (int r = 0; r < tiles.rows; ++r) {
    for (int c = 0; c < tiles.columns; ++c) {
      tiles.tiles.push_back(tile_of(frame, picture, r * kTileRows, c * kTileColumns));
    }
  }
  return tiles;
}

struct PlainPatch {
  int row = 0, column = 0;
  double mean = 0, per_row = 0, per_column = 0;  // the plane, dB
  bool is_plain = false;
};

// Of n equal steps: the sum of squares from their middle.
constexpr double squares_of_steps(int n) { return n * (n * n - 1.0) / 12; }

// Standard deviation of the means of the blocks over the plane.
double spread_of_blocks(const Tiles& tiles, int row, int column, const PlainPatch& patch) {
  constexpr int kAcross = kPlainBlock / kTileColumns;
  double sum = 0, squares = 0, blocks = 0;
  for (int a = 0; a < kPatchTileRows; ++a) {
    for (int b = 0; b < kPatchTileColumns; b += kAcross) {
      double block = 0;
      for (int k = 0; k < kAcross; ++k) block += tiles.at(row + a, column + b + k).sum;
      const double down = a * kTileRows + (kPlainBlock - kPlainRows) / 2.0;
      const double across = b * kTileColumns + (kPlainBlock - kPlainColumns) / 2.0;
      const double over = block / (kPlainBlock * kPlainBlock) - patch.mean - down * patch.per_row -
                          across * patch.per_column;
      sum += over;
      squares += over * over;
      blocks += 1;
    }
  }
  return std::sqrt(std::max(0.0, squares / blocks - sum / blocks * (sum / blocks)));
}

// The patches that are measured and not constant.
std::vector<PlainPatch> candidates(const Tiles& tiles) {
  std::vector<PlainPatch> patches;
  for (int i = 0; i + kPatchTileRows <= tiles.rows; i += kPatchTileRows / 2) {
    for (int j = 0; j + kPatchTileColumns <= tiles.columns; j += kPatchTileColumns / 2) {
      PlainPatch patch{i * kTileRows, j * kTileColumns};
      bool is_whole = true, is_constant = true;
      const float first = tiles.at(i, j).first;
      for (int a = 0; a < kPatchTileRows; ++a) {
        for (int b = 0; b < kPatchTileColumns; ++b) {
          const Tile& tile = tiles.at(i + a, j + b);
          is_whole = is_whole && tile.is_whole;
          is_constant = is_constant && tile.is_constant && tile.first == first;
          patch.mean += tile.sum;
          patch.per_row +=
              tile.row_moment + tile.sum * (a * kTileRows + (kTileRows - kPlainRows) / 2.0);
          patch.per_column += tile.column_moment +
                              tile.sum * (b * kTileColumns + (kTileColumns - kPlainColumns) / 2.0);
        }
      }
      if (!is_whole || is_constant) continue;
      patch.mean /= kPlainRows * kPlainColumns;
      patch.per_row /= kPlainColumns * squares_of_steps(kPlainRows);
      patch.per_column /= kPlainRows * squares_of_steps(kPlainColumns);
      patch.is_plain = spread_of_blocks(tiles, i, j, patch) < kMostOfBlocks &&
                       std::abs(patch.per_row) * kPlainRows < kMostRise &&
                       std::abs(patch.per_column) * kPlainColumns < kMostRise;
      patches.push_back(patch);
    }
  }
  return patches;
}

// Linear between the sorted values.
double quantile_of(const std::vector<double>& sorted, double q) {
  const double place = q * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (place - std::floor(place)) * (sorted[above] - sorted[below]);
}

void count_in(Sums::Row& table, const PlainAxis& axis, double value) {
  const double step = std::floor((value - axis.from) / axis.step());
  table[static_cast<std::size_t>(std::clamp(step, 0.0, kPlainSteps - 1.0))] += 1;
}

// Mean of (a - mean)(a' - mean) over pairs some pixels apart.
double neighbors(const std::vector<double>& a, double mean, int rows, int columns) {
  double sum = 0;
  for (int r = 0; r < kPlainRows - rows; ++r) {
    const double* from = a.data() + r * kPlainColumns;
    const double* to = from + rows * kPlainColumns + columns;
    for (int c = 0; c < kPlainColumns - columns; ++c) sum += (from[c] - mean) * (to[c] - mean);
  }
  return sum / ((kPlainRows - rows) * (kPlainColumns - columns));
}

void add_patch(const Frame& frame, const Picture& picture, const PlainPatch& patch, Sums& sums) {
  constexpr double kPixels = kPlainRows * kPlainColumns;
  std::vector<double> amplitude(static_cast<std::size_t>(kPixels));
  double second = 0, third = 0, mean = 0, square = 0;
  for (int r = 0; r < kPlainRows; ++r) {
    const float* level = picture.level.data() + frame.at(patch.row + r, patch.column);
    for (int c = 0; c < kPlainColumns; ++c) {
      const double plane = patch.mean + (r - (kPlainRows - 1) / 2.0) * patch.per_row +
                           (c - (kPlainColumns - 1) / 2.0) * patch.per_column;
      const double x = static_cast<double>(level[c]) - plane;
      const double a = std::exp(std::log(10) / 20 * x);
      amplitude[static_cast<std::size_t>(r * kPlainColumns + c)] = a;
      second += x * x / kPixels;
      third += x * x * x / kPixels;
      mean += a / kPixels;
      square += a * a / kPixels;
    }
  }
  const double spread = std::sqrt(second), variance = square - mean * mean;
  if (!(spread > 0) || !(variance > 0)) return;
  count_in(sums.plain_spread, kSpreadAxis, spread);
  count_in(sums.plain_skewness, kSkewnessAxis, third / (spread * spread * spread));
  count_in(sums.plain_beams, kCorrelationAxis, neighbors(amplitude, mean, 0, 1) / variance);
  count_in(sums.plain_samples, kCorrelationAxis, neighbors(amplitude, mean, 1, 0) / variance);
}

}  // namespace

void add_plain_patches(const Frame& frame, const Picture& picture, Sums& sums) {
  for (Sums::Row* row :
       {&sums.plain_spread, &sums.plain_skewness, &sums.plain_beams, &sums.plain_samples}) {
    row->resize(kPlainSteps, 0);
  }
  const std::vector<PlainPatch> patches = candidates(tiles_of(frame, picture));
  if (patches.empty()) return;
  std::vector<double> means;
  for (const PlainPatch& patch : patches) means.push_back(patch.mean);
  std::sort(means.begin(), means.end());
  const double low = quantile_of(means, kFromMeans), high = quantile_of(means, kToMeans);
  for (const PlainPatch& patch : patches) {
    if (patch.is_plain && patch.mean >= low && patch.mean <= high) {
      add_patch(frame, picture, patch, sums);
    }
  }
}

}  // namespace ensonify
