// Where the pixels of a figure lie in a polar image.
//
//   PolarFan          azimuths and ranges of a polar image
//   Extent       what a figure shows, in metres or in degrees and metres
//   cartesian_extent  polar_extent
//   cartesian_cells  polar_cells    the place in the polar picture of every pixel
#pragma once

#include <cstdint>
#include <vector>

namespace ensonify {

struct PolarFan {
  double first_azimuth_rad = 0, spacing_rad = 0;  // beam 0, the most negative azimuth
  double first_range_m = 0, step_m = 0;           // sample 0
  std::uint64_t beams = 0, samples = 0;

  // Outer edges of the outer cells.
  double min_azimuth_rad() const { return first_azimuth_rad - spacing_rad / 2; }
  double max_azimuth_rad() const {
    return first_azimuth_rad + (static_cast<double>(beams) - 0.5) * spacing_rad;
  }
  double min_range_m() const;
  double max_range_m() const {
    return first_range_m + (static_cast<double>(samples) - 0.5) * step_m;
  }
};

// Values at the left, right, lower and upper edge: of a Cartesian picture metres to port (larger
// on the left) and ahead, of a polar one degrees of azimuth (larger on the right) and metres of
// range (larger below).
struct Extent {
  double left = 0, right = 0, bottom = 0, top = 0;
};

// The smallest that holds the fan and the sonar.
Extent cartesian_extent(const PolarFan& fan);
Extent polar_extent(const PolarFan& fan);

// Row (sample) and column (beam), whole numbers at the centres of cells; outside of the fan both
// are negative.
struct Cell {
  float row = -1, column = -1;
  bool inside() const { return row >= 0; }
  std::uint64_t nearest(std::uint64_t columns) const;  // index of its cell
};

// Row-major, [height x width], of the pixels' centres.
std::vector<Cell> cartesian_cells(const PolarFan& fan, const Extent& extent, int width, int height);
std::vector<Cell> polar_cells(const PolarFan& fan, int width, int height);

}  // namespace ensonify
