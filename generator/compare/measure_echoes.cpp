// Bright isolated maxima, and dark regions.
#include <algorithm>
#include <cmath>

#include "compare/measure_parts.h"

namespace ensonify {
namespace {

constexpr double kOverBackground = 31.6;  // 15 dB
constexpr double kOverOthers = 8;         // 9 dB
constexpr double kDark = -10;             // dB
constexpr int kDarkRun = 3;               // dark samples before an edge
constexpr double kSurroundingsOfDark = 2.5;

// Whether no pixel near it is brighter, and the others in its window are far weaker.
bool stands_alone(const Frame& frame, const Picture& picture, int row, int column) {
  const float peak = picture.intensity[frame.at(row, column)];
  for (int r = row - frame.half_rows; r <= row + frame.half_rows; ++r) {
    for (int c = column - frame.half_columns; c <= column + frame.half_columns; ++c) {
      const std::size_t i = frame.at(r, c);
      if (frame.measured[i] == 0) return false;
      const bool near =
          std::abs(r - row) <= frame.guard_rows && std::abs(c - column) <= frame.guard_columns;
      const bool earlier = r < row || (r == row && c < column);
      const float other = picture.intensity[i];
      if (near ? other > peak || (earlier && other == peak)
               : static_cast<double>(other) * kOverOthers > static_cast<double>(peak)) {
        return false;
      }
    }
  }
  return true;
}

void add_maximum(const Frame& frame, const Picture& picture, int row, int column, double background,
                 Sums& sums) {
  const auto peak = static_cast<double>(picture.level[frame.at(row, column)]);
  sums.maxima += 1;
  const auto relative = [&](int r, int c) {
    return static_cast<double>(picture.level[frame.at(r, c)]) - peak;
  };
  for (int k = -frame.half_rows; k <= frame.half_rows; ++k) {
    sums.range_cut[static_cast<std::size_t>(k + frame.half_rows)] += relative(row + k, column);
  }
  for (int k = -frame.half_columns; k <= frame.half_columns; ++k) {
    sums.azimuth_cut[static_cast<std::size_t>(k + frame.half_columns)] += relative(row, column + k);
  }
  const auto level = [&](int r0, int r1, int c0, int c1) {
    return picture.sums.rectangle(row + r0, row + r1, column + c0, column + c1).mean() / background;
  };
  const int gr = frame.guard_rows + 1, hr = frame.half_rows;
  const int gc = frame.guard_columns + 1, hc = frame.half_columns;
  sums.before += level(-hr, -gr, 0, 0);
  sums.behind += level(gr, hr, 0, 0);
  sums.beside += (level(0, 0, -hc, -gc) + level(0, 0, gc, hc)) / 2;
}

}  // namespace

void add_maxima(const Frame& frame, const Picture& picture, Sums& sums) {
  sums.range_cut.assign(2 * static_cast<std::size_t>(frame.half_rows) + 1, 0);
  sums.azimuth_cut.assign(2 * static_cast<std::size_t>(frame.half_columns) + 1, 0);
  for (int r = frame.half_rows; r < frame.rows - frame.half_rows; ++r) {
    for (int c = frame.half_columns; c < frame.columns - frame.half_columns; ++c) {
      const auto peak = static_cast<double>(picture.intensity[frame.at(r, c)]);
      const auto ring = picture.sums.around(r, c, frame.half_rows, frame.half_columns) -
                        picture.sums.around(r, c, frame.guard_rows, frame.guard_columns);
      if (!(ring.sum > 0) || peak < kOverBackground * ring.mean()) continue;
      if (!stands_alone(frame, picture, r, c)) continue;
      add_maximum(frame, picture, r, c, ring.mean(), sums);
    }
  }
}

// Levels along the beam over the first sample that is not dark.
static void add_edge(const Frame& frame, const Picture& picture, int row, int column, double around,
                     Sums& sums) {
  sums.edges += 1;
  for (int k = -kEdgeHalf; k <= kEdgeHalf; ++k) {
    sums.edge_profile[static_cast<std::size_t>(k + kEdgeHalf)] +=
        static_cast<double>(picture.level[frame.at(row + k, column)]) - around;
  }
}

void add_darkness(const Frame& frame, const Picture& picture, Sums& sums) {
  sums.edge_profile.assign(2 * kEdgeHalf + 1, 0);
  const int far_rows = static_cast<int>(kSurroundingsOfDark * frame.half_rows);
  const int far_columns = static_cast<int>(kSurroundingsOfDark * frame.half_columns);
  for (int c = 0; c < frame.columns; ++c) {
    int run = 0;
    for (int r = 0; r < frame.rows; ++r) {
      if (frame.ground[frame.at(r, c)] == 0) {
        run = 0;
        continue;
      }
      const double around = picture.levels.around(r, c, far_rows, far_columns).mean();
      const double relative = picture.levels.around(r, c, 1, 1).mean() - around;
      sums.dark_of += 1;
      if (relative < kDark) {
        sums.dark += 1;
        sums.dark_level += relative;
        ++run;
        continue;
      }
      const bool edge = run >= kDarkRun && r >= kEdgeHalf && r + kEdgeHalf < frame.rows;
      run = 0;
      if (edge) add_edge(frame, picture, r, c, around, sums);
    }
  }
}

}  // namespace ensonify
