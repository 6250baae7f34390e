// What a comparison measures, as arrays: pings as polar images, or crops of images.
//
//   GridImage     one image of amplitudes
//   PixelClass    what a pixel shows
//   PolarPings    pings of one grid, in blocks
//   Crops         images of any sizes, in blocks
//   block_sizes   how many pings, or crops, each block gets
//   Amount  PingRun  ping_runs   which pings of the sequences of a data set
//   amplitude_of_level
//
// A block is a run of consecutive pings. Errors are computed from differences between blocks, so
// that pings within a block may be as correlated as they like.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/units.h"

namespace ensonify {

// Amplitudes of any scale, row-major; 0: no echo. Rows are samples, columns beams.
struct GridImage {
  int rows = 0, columns = 0;
  std::span<const float> amplitude;
  std::span<const std::uint8_t> classes = {};  // PixelClass; empty: not known
};

enum class PixelClass : std::uint8_t { background, object, shadow };
inline constexpr int kPixelClasses = 3;

struct PolarPings {
  std::vector<double> range_m;                // [samples], rising
  std::vector<double> azimuth_rad;            // [beams], rising
  std::vector<std::vector<float>> amplitude;  // [pings][samples x beams]
  std::vector<std::vector<std::uint8_t>> classes;  // likewise PixelClass; empty: not known
  std::vector<double> time_s;                      // [pings]
  std::vector<std::uint32_t> block;           // [pings], from 0, rising
  std::vector<std::uint8_t> use;  // [samples x beams], 0: not measured; empty: all are measured
  bool from_counts = false;       // of a recorder
  int transmit_groups = 1;        // that transmit in turn, as the data set says
  // [pings], of the sonar over a flat bottom; empty: not known.
  std::vector<double> height_m;

  int samples() const { return static_cast<int>(range_m.size()); }
  int beams() const { return static_cast<int>(azimuth_rad.size()); }
  std::uint32_t blocks() const { return block.empty() ? 0 : block.back() + 1; }
  GridImage image(std::size_t ping) const {
    GridImage image{samples(), beams(), amplitude[ping]};
    if (!classes.empty()) image.classes = classes[ping];
    return image;
  }
};

struct Crops {
  struct Crop {
    int rows = 0, columns = 0;
    std::vector<float> amplitude;
  };
  std::vector<Crop> crops;
  std::vector<std::uint32_t> block;  // [crops], from 0, rising

  std::uint32_t blocks() const { return block.empty() ? 0 : block.back() + 1; }
  GridImage image(std::size_t crop) const {
    return {crops[crop].rows, crops[crop].columns, crops[crop].amplitude};
  }
};

// Splits `count` into `blocks` numbers that differ by 1 at most, or into `count` ones.
std::vector<std::size_t> block_sizes(std::size_t count, std::size_t blocks);

// `blocks` runs of consecutive pings, or crops, spread evenly.
struct Amount {
  int images = 200;
  int blocks = 0;  // 0: 10, or one for each of 10 to 40 sequences
};

struct PingRun {
  std::size_t sequence = 0;  // in the list
  std::uint32_t first = 0, count = 0;
};

// One run for each block, in order, each in the middle of its part. `sequences` are their pings,
// [first, last). With as many sequences as blocks or more, each block is of one sequence.
std::vector<PingRun> ping_runs(std::span<const std::pair<std::uint32_t, std::uint32_t>> sequences,
                               const Amount& amount);

// 10^(level / 20), and 0 for the level of pixels without energy.
inline float amplitude_of_level(float level_db) {
  return level_db > kNoEnergyDb ? std::pow(10.0f, level_db / 20) : 0.0f;
}

}  // namespace ensonify
