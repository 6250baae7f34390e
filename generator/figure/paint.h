// Polar images in colors, at the pixels of a figure.
//
//   PolarFan          azimuths and ranges of a polar image
//   Extent            what a figure shows, in meters or in degrees and meters
//   cartesian_extent  polar_extent
//   Cell  cartesian_cells  polar_cells   position of every pixel in the polar image
//   paint_values      levels and angles, by a color map
//   paint_ids         masks
//   outline           the edges of masks, over an image
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "figure/drawing.h"

namespace ensonify {

struct PolarFan {
  double first_azimuth_rad = 0, spacing_rad = 0;  // beam 0, the most negative azimuth
  double first_range_m = 0, step_m = 0;           // sample 0
  std::uint64_t beams = 0, samples = 0;
  std::vector<double> azimuth_rad = {};  // [beams] of unequal beams; empty: equal spacing

  // Outer edges of the outer cells.
  double min_azimuth_rad() const;
  double max_azimuth_rad() const;
  // Place among the beams, linear between their azimuths.
  double column_at(double azimuth_rad) const;
  double min_range_m() const;
  double max_range_m() const {
    return first_range_m + (static_cast<double>(samples) - 0.5) * step_m;
  }
};

// Values at the left, right, lower and upper edge. For a Cartesian image they are meters to port
// (larger on the left) and ahead. For a polar image they are degrees of azimuth (larger on the
// right) and meters of range (larger below).
struct Extent {
  double left = 0, right = 0, bottom = 0, top = 0;
};

// The smallest extent that contains the fan and the sonar.
Extent cartesian_extent(const PolarFan& fan);
Extent polar_extent(const PolarFan& fan);

// Row (sample) and column (beam), whole numbers at the centers of cells; outside of the fan both
// are negative.
struct Cell {
  float row = -1, column = -1;
  bool inside() const { return row >= 0; }
  std::uint64_t nearest(std::uint64_t columns) const;  // index of its cell
};

// Row-major, [height x width], of the pixels' centers.
std::vector<Cell> cartesian_cells(const PolarFan& fan, const Extent& extent, int width, int height);
std::vector<Cell> polar_cells(const PolarFan& fan, int width, int height);

enum class Sampling { nearest, bilinear };

// [rows x columns], of the polar image.
struct ValueScale {
  const ColourMap* map = nullptr;
  std::array<double, 2> limits{};  // at the ends of the color map, in the unit of the values
  Rgb8 none{};                     // of NaN
};

// White outside the fan. Bilinear mixes amplitudes, 10^(dB/20): only for levels.
RgbImage paint_values(std::span<const Cell> cells, int width, int height,
                      std::span<const float> values, std::uint64_t columns, const ValueScale& scale,
                      Sampling sampling);

// Ids are always those of the nearest cell, since ids cannot be interpolated.
RgbImage paint_ids(std::span<const Cell> cells, int width, int height,
                   std::span<const std::uint16_t> ids, std::uint64_t columns);

// Colors the pixels around each mask, up to `thickness` pixels away: the mask's interior stays
// visible. One black pixel outside separates it from image parts of the same color.
void outline(RgbImage& image, std::span<const Cell> cells, std::span<const std::uint16_t> ids,
             std::uint64_t columns, int thickness);

}  // namespace ensonify
