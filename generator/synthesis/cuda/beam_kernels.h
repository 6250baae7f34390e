// The work of one thread of a device for beams from ideal beam cells, called sectors in the code.
// Each functor is called once for every index below its count, writes only its own results and adds
// up in a fixed order. Therefore results do not change from run to run. The tests run the same
// functors on the host.
//
//   PlaceEchoes    drawn amplitude, carrier's phase, place on the time grid
//   PlacePowers    expected energy of an echo, place on the time grid
//   GatherSeries   echoes -> a point of a sector's grid; GatherPowers has two sectors per row
//   DrawVolumes    the echoes of volumes; VolumePowers
//   FilterSeries   spectrum of a grid -> spectrum of a record; FilterPowers
//   MixSeries      sectors -> beams, with noise; MixPowers
#pragma once

#include <cmath>
#include <cstdint>

#include "acoustics/propagation.h"
#include "core/units.h"
#include "synthesis/cuda/queue.h"

namespace ensonify {

// The echoes of a batch, with values and places on the time grid.
struct PlacedEchoes {
  Complex32* value;
  float* offset;        // in [-1, 1), as in EchoArrays
  std::int32_t* first;  // grid point, may be negative
};

ENSONIFY_HD inline void place_echo(double delay_s, double points_per_s, int width, float& offset,
                                   std::int32_t& first) {
  const double edge = delay_s * points_per_s - 0.5 * width;
  const double begin = std::ceil(edge);
  first = static_cast<std::int32_t>(begin);
  offset = static_cast<float>(2.0 * (begin - edge) - 1.0);
}

struct PlaceEchoes {
  const EchoRecord* echoes;
  const std::uint32_t* ping_of;  // [echoes]
  const BatchPing* pings;
  double frequency_hz, source_pa_m, points_per_s;
  int width;
  bool means_only;
  PlacedEchoes out;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const EchoRecord& e = echoes[i];
    const Complex32 a = amplitude_of(e, pings[ping_of[i]], means_only);
    const double re = a.re, im = a.im;
    if (re != 0 || im != 0) {
      const double angle = -2 * kPi * carrier_turns(frequency_hz, e.delay_s);
      const double c = std::cos(angle), s = std::sin(angle), scale = source_pa_m * e.gain;
      out.value[i] = {static_cast<float>(scale * (re * c - im * s)),
                      static_cast<float>(scale * (re * s + im * c))};
    } else {
      out.value[i] = {0, 0};
    }
    place_echo(e.delay_s, points_per_s, width, out.offset[i], out.first[i]);
  }
};

struct PlacePowers {
  const EchoRecord* echoes;
  const DirectionRecord* directed;  // order of the echoes; null: the order of the batch
  double source_pa_m, points_per_s;
  int width;
  PlacedEchoes out;  // of the value, only re

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const EchoRecord& e = echoes[directed != nullptr ? directed[i].echo : i];
    const double rms = source_pa_m * e.deviation * e.gain;
    out.value[i] = {static_cast<float>(rms * rms), 0};
    place_echo(e.delay_s, points_per_s, width, out.offset[i], out.first[i]);
  }
};

// The first of echoes [begin, end) whose kernel reaches a grid point or lies behind it. The echoes
// are sorted by `first`. The point may be outside of the grid.
ENSONIFY_HD inline std::uint32_t first_reaching(const PlacedEchoes& echoes,
                                                const DeviceKernel& kernel, std::uint32_t begin,
                                                std::uint32_t end, std::int32_t point) {
  std::uint32_t low = begin, high = end;
  while (low < high) {
    const std::uint32_t middle = low + (high - low) / 2;
    if (echoes.first[middle] > point - kernel.width) {
      high = middle;
    } else {
      low = middle + 1;
    }
  }
  return low;
}

// The sum of value times kernel at a grid point, over echoes [begin, end).
ENSONIFY_HD inline Complex32 sum_at(const PlacedEchoes& echoes, const DeviceKernel& kernel,
                                    std::uint32_t begin, std::uint32_t end, std::int32_t point) {
  Complex32 sum{0, 0};
  for (std::uint32_t low = first_reaching(echoes, kernel, begin, end, point);
       low < end && echoes.first[low] <= point; ++low) {
    const float w = kernel_at(kernel, point - echoes.first[low], echoes.offset[low]);
    sum += w * echoes.value[low];
  }
  return sum;
}

// The same, with echoes that wrap around the ends of the period.
ENSONIFY_HD inline Complex32 wrapped_sum_at(const PlacedEchoes& echoes, const DeviceKernel& kernel,
                                            std::uint32_t begin, std::uint32_t end,
                                            std::int32_t point) {
  Complex32 sum = sum_at(echoes, kernel, begin, end, point);
  for (const std::int32_t other : {point - kernel.points, point + kernel.points}) {
    if (other < -kernel.width || other >= kernel.points + kernel.width) continue;
    sum += sum_at(echoes, kernel, begin, end, other);
  }
  return sum;
}

// Writes grid [pings][sectors][points].
struct GatherSeries {
  PlacedEchoes echoes;
  const BatchPing* pings;
  const std::uint32_t* offset;
  DeviceKernel kernel;
  int sectors;
  Complex32* grid;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const auto point = static_cast<std::int32_t>(i % kernel.points);
    const std::int64_t row = i / kernel.points;
    const std::uint32_t* at = offset + pings[row / sectors].first_offset + row % sectors;
    grid[i] = wrapped_sum_at(echoes, kernel, at[0], at[1], point);
  }
};

// Writes grid [pings][ceil(sectors / 2)][points]. re is an even sector, im the odd sector after it.
struct GatherPowers {
  PlacedEchoes echoes;
  const BatchPing* pings;
  const std::uint32_t* offset;
  DeviceKernel kernel;
  int sectors;
  Complex32* grid;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const auto point = static_cast<std::int32_t>(i % kernel.points);
    const int rows = (sectors + 1) / 2;
    const std::int64_t row = i / kernel.points;
    const auto sector = static_cast<int>(row % rows) * 2;
    const std::uint32_t* at = offset + pings[row / rows].first_offset + sector;
    const float even = wrapped_sum_at(echoes, kernel, at[0], at[1], point).re;
    const bool has_odd = sector + 1 < sectors;
    grid[i] = {even, has_odd ? wrapped_sum_at(echoes, kernel, at[1], at[2], point).re : 0.0f};
  }
};

// Writes cells [pings][sectors][transform], zero from `samples` on, from
// energy [pings][sectors][samples].
struct DrawVolumes {
  const float* energy;
  const BatchPing* pings;
  const std::uint64_t* volume_key;  // [pings]
  double source_pa_m;
  int sectors, samples, transform;
  Complex32* cells;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const auto n = static_cast<int>(i % transform);
    const std::int64_t row = i / transform;
    cells[i] = {0, 0};
    if (n >= samples) return;
    const double e = energy[row * samples + n];
    if (e == 0) return;
    const std::int64_t ping = row / sectors;
    cells[i] = narrow(cell_draw(volume_key[ping], pings[ping].speckle_ping, row % sectors, n,
                                source_pa_m * std::sqrt(e)));
  }
};

// Writes cells [pings][ceil(sectors / 2)][transform], two sectors per row.
struct VolumePowers {
  const float* energy;
  double source_pa_m;
  int sectors, samples, transform;
  Complex32* cells;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const auto n = static_cast<int>(i % transform);
    const int rows = (sectors + 1) / 2;
    const std::int64_t row = i / transform;
    const std::int64_t sector = row / rows * sectors + row % rows * 2;
    const bool has_odd = row % rows * 2 + 1 < sectors;
    const auto power = static_cast<float>(source_pa_m * source_pa_m);
    cells[i] = {0, 0};
    if (n >= samples) return;
    const float* e = energy + sector * samples + n;
    cells[i] = {power * e[0], has_odd ? power * e[samples] : 0.0f};
  }
};

ENSONIFY_HD inline Complex32 product(Complex32 a, Complex32 b) {
  return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}

// Writes record [rows][transform] from the transforms of grids [rows][points] and, unless null, of
// cells [rows][transform]. filter and cell_filter: [transform], bin 0 first.
struct FilterSeries {
  const Complex32* grid;
  const Complex32* cells;
  const Complex32 *filter, *cell_filter;
  int points, transform;
  Complex32* record;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const auto k = static_cast<int>(i % transform);
    const std::int64_t row = i / transform;
    const int at = k < transform / 2 ? k : points - transform + k;
    Complex32 sum = product(grid[row * points + at], filter[k]);
    if (cells != nullptr) {
      sum += product(cells[i], cell_filter[k]);
    }
    record[i] = sum;
  }
};

// |s|^2 has twice the bandwidth, so that bins above those of the record are added one period lower.
// The filters of a row r start at (r % row_filters) * filter_stride.
struct FilterPowers {
  const Complex32* grid;
  const Complex32* cells;
  const Complex32 *filter, *upper_filter, *cell_filter;
  int rows, row_filters, filter_stride, points, transform;
  Complex32* record;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const auto k = static_cast<int>(i % transform);
    const std::int64_t row = i / transform;
    const std::int64_t own = row % rows % row_filters * filter_stride;
    const Complex32* from = grid + row * points;
    Complex32 sum = product(from[k], filter[own + k]);
    if (k > 0) {
      sum += product(from[points - transform + k], upper_filter[own + k]);
    }
    if (cells != nullptr) {
      sum += product(cells[i], cell_filter[k]);
    }
    record[i] = sum;
  }
};

// A thread computes one sample of this number of neighboring beams, and reads the sample of each
// sector once for all of them.
constexpr int kBeamsAThread = 16;

// The weights of kBeamsAThread sectors in these beams. They are a band, which fits into registers.
struct WeightBand {
  float w[2 * kBeamsAThread - 1];

  // `weight` points to the weight of the first sector in the first beam.
  ENSONIFY_HD explicit WeightBand(const float* weight) {
    ENSONIFY_UNROLL
    for (int d = 0; d < 2 * kBeamsAThread - 1; ++d) w[d] = weight[d - kBeamsAThread + 1];
  }
  ENSONIFY_HD float of(int sector, int beam) const { return w[sector - beam + kBeamsAThread - 1]; }
};

// The weights of equal beams: weight [2 beams - 1] with a margin of kBeamsAThread at both ends. The
// weight of sector s in beam j is at s - j + beams - 1.
struct BandOfWeights {
  const float* weight;
  int beams;

  ENSONIFY_HD WeightBand at(int sector, int beam) const {
    return WeightBand(weight + sector - beam + beams - 1);
  }
};

// The weights of kBeamsAThread sectors in these beams, in rows of a matrix.
struct WeightBlock {
  const float* weight;
  int columns;

  ENSONIFY_HD float of(int sector, int beam) const {
    return weight[static_cast<std::int64_t>(beam) * columns + sector];
  }
};

// The weights of unequal beams: weight [columns][columns], beam by beam, with zeros beyond the last
// beam and sector; columns is a multiple of kBeamsAThread.
struct MatrixOfWeights {
  const float* weight;
  int columns;

  ENSONIFY_HD WeightBlock at(int sector, int beam) const {
    return {weight + static_cast<std::int64_t>(beam) * columns + sector, columns};
  }
};

// Writes beams [pings][beams][samples] from records [pings][sectors][transform]. The count is pings
// times ceil(beams / kBeamsAThread) times samples.
template <class Weights>
struct MixSeries {
  const Complex32* record;
  const BatchPing* pings;
  Weights weights;
  const float* scale;
  int beams, samples, transform;
  bool adds_noise;
  Complex32* out;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const auto n = static_cast<int>(i % samples);
    const int blocks = (beams + kBeamsAThread - 1) / kBeamsAThread;
    const auto first = static_cast<int>(i / samples % blocks) * kBeamsAThread;
    const std::int64_t ping = i / samples / blocks;
    Complex32 sum[kBeamsAThread] = {};
    for (int s = 0; s < beams; s += kBeamsAThread) {
      const auto band = weights.at(s, first);
      ENSONIFY_UNROLL
      for (int t = 0; t < kBeamsAThread; ++t) {
        const bool is_there = s + t < beams;
        const Complex32 p =
            is_there ? record[(ping * beams + s + t) * transform + n] : Complex32{0, 0};
        ENSONIFY_UNROLL
        for (int b = 0; b < kBeamsAThread; ++b) {
          sum[b] += band.of(t, b) * p;
        }
      }
    }
    ENSONIFY_UNROLL
    for (int b = 0; b < kBeamsAThread; ++b) {
      const int beam = first + b;
      if (beam >= beams) continue;
      Complex32 p = scale[beam] * sum[b];
      if (adds_noise && pings[ping].noise_rms != 0) {
        const BatchPing& own = pings[ping];
        p += narrow(cell_draw(own.noise_key, own.noise_ping, beam, n, own.noise_rms));
      }
      out[(ping * beams + beam) * samples + n] = p;
    }
  }
};

// A power without the negative values that rounding errors of the kernel may cause, plus |means|^2
// unless null.
ENSONIFY_HD inline float finished_power(float power, const Complex32* means, std::int64_t at) {
  power = power > 0 ? power : 0;
  if (means != nullptr) power += means[at].re * means[at].re + means[at].im * means[at].im;
  return power;
}

// Writes powers [pings][beams][samples] from records [pings][ceil(sectors / 2)][transform]. Adds
// |means|^2, [pings][beams][samples], unless null. weights and scale are squares.
template <class Weights>
struct MixPowers {
  const Complex32* record;
  const Complex32* means;
  Weights weights;
  const float* scale;
  int beams, samples, transform;
  float* out;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const auto n = static_cast<int>(i % samples);
    const int blocks = (beams + kBeamsAThread - 1) / kBeamsAThread, rows = (beams + 1) / 2;
    const auto first = static_cast<int>(i / samples % blocks) * kBeamsAThread;
    const std::int64_t ping = i / samples / blocks;
    float sum[kBeamsAThread] = {};
    for (int s = 0; s < beams; s += kBeamsAThread) {
      const auto band = weights.at(s, first);
      ENSONIFY_UNROLL
      for (int t = 0; t < kBeamsAThread; t += 2) {
        const int row = (s + t) / 2;
        const Complex32 p =
            row < rows ? record[(ping * rows + row) * transform + n] : Complex32{0, 0};
        ENSONIFY_UNROLL
        for (int b = 0; b < kBeamsAThread; ++b) {
          sum[b] += band.of(t, b) * p.re + band.of(t + 1, b) * p.im;
        }
      }
    }
    ENSONIFY_UNROLL
    for (int b = 0; b < kBeamsAThread; ++b) {
      if (first + b >= beams) continue;
      const std::int64_t at = (ping * beams + first + b) * samples + n;
      out[at] = finished_power(scale[first + b] * sum[b], means, at);
    }
  }
};

}  // namespace ensonify
