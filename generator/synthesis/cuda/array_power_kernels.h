// What one thread of a device does for the expected power of an array: echoes are dealt out to
// nodes in u, the cosine of arrival, and beams add up nodes by their power patterns at the range
// of a block of samples. What that leaves out: synthesis/cpu/array_power.h.
//
//   PlaceDirections        expected energies, in the order of directions
//   GatherDirections       -> a point of two nodes' grid; GatherDirectionCells adds volumes
//   FilterDirections       spectrum of a grid -> spectrum of a record
//   TurnWavefronts         what each element makes of a wave, and each beam of an element
//   MakePatterns           power patterns of beams at nodes
//   MixDirections          nodes -> beams
#pragma once

#include "synthesis/cuda/array_kernels.h"

namespace ensonify {

constexpr int kDirectionTaps = 4;

struct PlaceDirections {
  const EchoRecord* echoes;
  const DirectionRecord* directed;
  double source_pa_m, points_per_s;
  int width;
  PlacedEchoes out;  // value.re alone

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const EchoRecord& e = echoes[directed[i].echo];
    const double rms = source_pa_m * e.deviation * e.gain;
    out.value[i] = {static_cast<float>(rms * rms), 0};
    place_echo(e.delay_s, points_per_s, width, out.offset[i], out.first[i]);
  }
};

// grid [pings][nodes / 2][points]: an even node and the odd one after it.
struct GatherDirections {
  PlacedEchoes placed;
  const DirectionRecord* directed;
  const std::uint32_t* offset;  // [pings][groups + 1], by the first of four nodes
  const float* cell_weight;     // [cells][kDirectionTaps]
  DeviceKernel kernel;
  int nodes;
  Complex32* grid;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const auto point = static_cast<std::int32_t>(i % kernel.points);
    const int rows = nodes / 2, groups = nodes - kDirectionTaps + 1;
    const auto node = static_cast<int>(i / kernel.points % rows) * 2;
    const std::uint32_t* at = offset + i / kernel.points / rows * (groups + 1);
    const int low = node - kDirectionTaps + 1;
    Complex32 sum{0, 0};
    for (int g = low > 0 ? low : 0; g <= node + 1 && g < groups; ++g) {
      for (int turn = -1; turn <= 1; ++turn) {
        const std::int32_t p = point + turn * kernel.points;
        if (p < -kernel.width || p >= kernel.points + kernel.width) continue;
        add(at[g], at[g + 1], p, node - g, sum);
      }
    }
    grid[i] = sum;
  }

  // `tap` is that of the even node among those that the echoes [begin, end) reach.
  ENSONIFY_HD void add(std::uint32_t begin, std::uint32_t end, std::int32_t point, int tap,
                       Complex32& sum) const {
    std::uint32_t low = begin, high = end;
    while (low < high) {
      const std::uint32_t middle = low + (high - low) / 2;
      if (placed.first[middle] > point - kernel.width) {
        high = middle;
      } else {
        low = middle + 1;
      }
    }
    for (; low < end && placed.first[low] <= point; ++low) {
      const float w = kernel_at(kernel, point - placed.first[low], placed.offset[low]);
      const float power = w * placed.value[low].re;
      const float* of_cell = cell_weight + directed[low].cell * kDirectionTaps;
      if (tap >= 0 && tap < kDirectionTaps) sum.re += power * of_cell[tap];
      if (tap + 1 < kDirectionTaps) sum.im += power * of_cell[tap + 1];
    }
  }
};

// Adds to the same grid: energy [pings][beams][samples] on whole samples.
struct GatherDirectionCells {
  const float* energy;
  const SectorRecord* sectors;
  const std::uint32_t* row_offset;  // [rows + 1], among these
  DeviceKernel kernel;
  double source_pa_m, points_per_sample;
  int rows, beams, samples;
  Complex32* grid;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const auto point = static_cast<std::int32_t>(i % kernel.points);
    const auto row = static_cast<int>(i / kernel.points % rows);
    const float* of_ping = energy + i / kernel.points / rows * beams * samples;
    const double half = 0.5 * kernel.width;
    Complex32 sum{0, 0};
    for (int turn = -1; turn <= 1; ++turn) {
      const std::int32_t p = point + turn * kernel.points;
      const double low = std::floor((p - half) / points_per_sample);
      const double high = std::ceil((p + half) / points_per_sample);
      const int last = high < samples - 1 ? static_cast<int>(high) : samples - 1;
      for (int n = low > 0 ? static_cast<int>(low) : 0; n <= last; ++n) {
        float offset;
        std::int32_t first;
        place_echo(n, points_per_sample, kernel.width, offset, first);
        if (p < first || p >= first + kernel.width) continue;
        add(of_ping + n, row, kernel_at(kernel, p - first, offset), sum);
      }
    }
    const auto power = static_cast<float>(source_pa_m * source_pa_m);
    grid[i].re += power * sum.re;
    grid[i].im += power * sum.im;
  }

  ENSONIFY_HD void add(const float* of_sample, int row, float w, Complex32& sum) const {
    for (std::uint32_t s = row_offset[row]; s < row_offset[row + 1]; ++s) {
      const float e = w * of_sample[std::int64_t{sectors[s].sector} * samples];
      sum.re += e * sectors[s].even;
      sum.im += e * sectors[s].odd;
    }
  }
};

// |s|^2 fills twice the band: bins above the record's fall on those a period lower. filter
// [row_filters][lower, upper][transform].
struct FilterDirections {
  const Complex32* grid;
  const Complex32* filter;
  int rows, row_filters, points, transform;
  Complex32* record;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const auto k = static_cast<int>(i % transform);
    const std::int64_t row = i / transform;
    const Complex32* from = grid + row * points;
    const Complex32* lower = filter + row % rows % row_filters * 2 * transform;
    Complex32 sum = product(from[k], lower[k]);
    if (k > 0) {
      const Complex32 upper = product(from[points - transform + k], lower[transform + k]);
      sum.re += upper.re;
      sum.im += upper.im;
    }
    record[i] = sum;
  }
};

// out [waves][elements]: a wave from a direction, from `range_m` or plane, at every element.
struct TurnWavefronts {
  const double* cosine;  // [waves]
  const double* y_m;
  const Complex32* factor;  // [elements], or null: 1
  double range_m, turns_per_m;
  int elements;
  bool plane;
  Complex32* out;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const std::int64_t n = i % elements;
    const double u = cosine[i / elements];
    const double later_m = plane ? -y_m[n] * u : longer_way_m(range_m, range_m * u, y_m[n]);
    out[i] = turned(factor != nullptr ? factor[n] : Complex32{1, 0}, later_m * turns_per_m);
  }
};

// pattern [beams][nodes].
struct MakePatterns {
  const Complex32 *beams, *waves;  // TurnWavefronts, [beams] and [nodes]
  const float* heard;              // [nodes], an element's own
  int nodes, elements;
  float* pattern;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const Complex32* b = beams + i / nodes * elements;
    const Complex32* w = waves + i % nodes * elements;
    Complex32 sum{0, 0};
    for (int n = 0; n < elements; ++n) {
      const Complex32 part = product(b[n], w[n]);
      sum.re += part.re;
      sum.im += part.im;
    }
    pattern[i] = heard[i % nodes] * (sum.re * sum.re + sum.im * sum.im);
  }
};

// powers [pings][beams][samples], of the block's samples [first, first + count), of records
// [pings][nodes / 2][transform], plus |means|^2 of [pings][beams][samples] unless null.
struct MixDirections {
  const Complex32* record;
  const Complex32* means;
  const float* pattern;
  int beams, nodes, samples, transform, first, count;
  float* out;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const auto n = static_cast<int>(first + i % count);
    const std::int64_t row = i / count, ping = row / beams;
    const float* w = pattern + row % beams * nodes;
    const Complex32* from = record + ping * (nodes / 2) * transform + n;
    float power = 0;
    for (int q = 0; q < nodes; q += 2, from += transform) {
      power += w[q] * from->re + w[q + 1] * from->im;
    }
    // Ringing of the kernel may leave a rounding error below zero.
    power = power > 0 ? power : 0;
    const std::int64_t at = row * samples + n;
    if (means != nullptr) power += means[at].re * means[at].re + means[at].im * means[at].im;
    out[at] = power;
  }
};

}  // namespace ensonify
