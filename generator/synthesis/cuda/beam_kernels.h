// The work of one thread of a device for beams from ideal beam cells, called sectors in the code.
// Each functor is called once for every index below its count, writes only its own results and adds
// up in a fixed order. Therefore results do not change from run to run. The tests run the same
// functors on the host.
//
//   PlaceEchoes    drawn amplitude, carrier's phase, place on the time grid
//   PlacePowers    expected energy of an echo, place on the time grid
//   GatherSeries   echoes -> the grid of a sector; GatherPowers has two sectors per row
//   DrawVolumes    the echoes of volumes; VolumePowers
//   FilterSeries   spectrum of a grid -> spectrum of a record; FilterPowers
//   ConvertSeries  the receiver's ADC, for beams of every receiver
#pragma once

#include <cmath>
#include <cstdint>

#include "acoustics/propagation.h"
#include "core/units.h"
#include "synthesis/adc.h"
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

// A row of a grid is the work of this number of threads, a warp of a device. Every thread follows
// the echoes in their order and computes the points lane, lane + kGridLanes, and so on. No kernel
// is wider, so that an echo reaches at most one of its points at a time.
constexpr int kGridLanes = 32;

// Calls write(point, sum) for the points of a thread: the sum of value times kernel over echoes
// [begin, end), which wrap around the ends of the period.
template <class Write>
ENSONIFY_HD inline void sum_in_lane(const PlacedEchoes& echoes, const DeviceKernel& kernel,
                                    std::uint32_t begin, std::uint32_t end, int lane,
                                    const Write& write) {
  std::int32_t point = lane;
  Complex32 sum{0, 0};
  const auto finish = [&] {
    for (const std::int32_t other : {point - kernel.points, point + kernel.points}) {
      if (other < -kernel.width || other >= kernel.points + kernel.width) continue;
      sum += sum_at(echoes, kernel, begin, end, other);
    }
    write(point, sum);
    point += kGridLanes;
    sum = {0, 0};
  };
  for (std::uint32_t e = begin; e < end && point < kernel.points; ++e) {
    const std::int32_t first = echoes.first[e];
    while (point < first && point < kernel.points) finish();
    const std::int32_t tap = point - first;
    if (point >= kernel.points || tap >= kernel.width) continue;
    sum += kernel_at(kernel, tap, echoes.offset[e]) * echoes.value[e];
  }
  while (point < kernel.points) finish();
}

// Writes grid [pings][sectors][points]. The count is pings times sectors times kGridLanes.
struct GatherSeries {
  PlacedEchoes echoes;
  const BatchPing* pings;
  const std::uint32_t* offset;
  DeviceKernel kernel;
  int sectors;
  Complex32* grid;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const std::int64_t row = i / kGridLanes;
    const std::uint32_t* at = offset + pings[row / sectors].first_offset + row % sectors;
    Complex32* own = grid + row * kernel.points;
    sum_in_lane(echoes, kernel, at[0], at[1], static_cast<int>(i % kGridLanes),
                [&](std::int32_t point, Complex32 sum) { own[point] = sum; });
  }
};

// Writes grid [pings][ceil(sectors / 2)][points]. re is an even sector, im the odd sector after it.
// The count is pings times rows times kGridLanes.
struct GatherPowers {
  PlacedEchoes echoes;
  const BatchPing* pings;
  const std::uint32_t* offset;
  DeviceKernel kernel;
  int sectors;
  Complex32* grid;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const int rows = (sectors + 1) / 2, lane = static_cast<int>(i % kGridLanes);
    const std::int64_t row = i / kGridLanes;
    const auto sector = static_cast<int>(row % rows) * 2;
    const std::uint32_t* at = offset + pings[row / rows].first_offset + sector;
    Complex32* own = grid + row * kernel.points;
    sum_in_lane(echoes, kernel, at[0], at[1], lane, [&](std::int32_t point, Complex32 sum) {
      own[point] = {sum.re, 0};
    });
    if (sector + 1 == sectors) return;
    sum_in_lane(echoes, kernel, at[1], at[2], lane,
                [&](std::int32_t point, Complex32 sum) { own[point].im = sum.re; });
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

// A power without the negative values that rounding errors of the kernel may cause, plus |means|^2
// unless null.
ENSONIFY_HD inline float finished_power(float power, const Complex32* means, std::int64_t at) {
  power = power > 0 ? power : 0;
  if (means != nullptr) power += means[at].re * means[at].re + means[at].im * means[at].im;
  return power;
}

struct ConvertSeries {
  Converter converter;
  Complex32* series;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    series[i] = {converted(converter, series[i].re), converted(converter, series[i].im)};
  }
};

}  // namespace ensonify
