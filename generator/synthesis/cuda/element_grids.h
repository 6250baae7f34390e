// The grids of an array's elements from sounds at the origin. As on the processor
// (cpu/array_records.h), a group of neighboring elements shares the place of a sound on the grid,
// and its path to them is expanded about the group's middle. Each element sums moments of the
// sounds of a cell, which is the interval between two grid points: sums of value times powers of
// the place in the cell. A grid point is a sum of the moments of the cells that reach it, because
// the spreading kernel is a polynomial of the place.
//
// Functors are as in beam_kernels.h.
//
//   FindSounds      where the sounds of each point begin
//   PlaceInGroup    sounds as heard by one group
//   SumMoments      sounds -> moments of a cell at an element
//   SumCells        moments -> points of an element's grid
//   SoundList       sounds of all pings
//   ElementGrids    all of these
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "synthesis/cuda/array_kernels.h"
#include "synthesis/cuda/device_tables.h"
#include "synthesis/cuda/queue.h"

namespace ensonify {

// Writes begin [pings][2 points + 1]: the first sound of a ping at each point or later. Sounds with
// twice the period's delay or more are left out.
struct FindSounds {
  const Sound* sounds;
  const std::uint32_t* ping_begin;  // [pings + 1]
  int points;
  std::uint32_t* begin;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const std::int64_t ping = i / (2 * points + 1);
    const auto point = static_cast<double>(i % (2 * points + 1));
    std::uint32_t low = ping_begin[ping], high = ping_begin[ping + 1];
    while (low < high) {
      const std::uint32_t middle = low + (high - low) / 2;
      if (sounds[middle].points < point) {
        low = middle + 1;
      } else {
        high = middle;
      }
    }
    begin[i] = low;
  }
};

// Elements [first, first + count), at y = middle_m + (l + to_first) spacing_m.
struct DeviceGroup {
  int first, count;
  double middle_m, spacing_m;
  float to_first;
};

// A sound as heard by a group. With x = l + to_first, element l has
//   phase   turns 2^-32 + l slope 2^-32 + x^2 (bend[0] + x (bend[1] + x bend[2])), in turns
//   offset  offset + x (shift[0] + x shift[1]), from -1 to 1: the place in the cell
struct alignas(16) GroupPath {
  std::int32_t turns, slope;
  float bend[3], offset, shift[2];
  Complex32 value;
  std::int32_t is_near;  // not expanded, because the point is too near
};

// Where sounds lie, and what the paths of a group share.
struct SoundPlaces {
  const Sound* sounds;
  DeviceGroup group;
  double turns_per_m, points_per_m, exact_range_m;
  int width;
  float per_reach;

  // The place in the cell before point `first`, for an element that hears the sound later.
  ENSONIFY_HD float offset_at(const Sound& s, double later_m, std::int32_t first) const {
    const double edge = s.points + later_m * points_per_m - 0.5 * width;
    return static_cast<float>(2.0 * (first - edge) - 1.0) * per_reach;
  }
};

// The fractional part of turns, in units of 2^-32.
ENSONIFY_HD inline std::int32_t fixed_turns(double turns) {
  // The factor is a little less than 2^32, so that half a turn does not overflow.
  return static_cast<std::int32_t>((turns - std::rint(turns)) * 4294967040.0);
}

// Writes the path of each sound, and the point where its kernel begins. Sounds of zero get a point
// that no grid has.
struct PlaceInGroup {
  SoundPlaces places;
  GroupPath* path;
  std::int32_t* first;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const Sound& s = places.sounds[i];
    first[i] = std::numeric_limits<std::int32_t>::min();
    if (s.value.re == 0 && s.value.im == 0) return;
    const double y = places.group.middle_m, d = places.group.spacing_m;
    const double later_m = longer_way_m(s.range_m, s.along_m, y);
    first[i] = static_cast<std::int32_t>(
        std::ceil(s.points + later_m * places.points_per_m - 0.5 * places.width));
    GroupPath p{};
    p.value = s.value;
    p.is_near = s.range_m < places.exact_range_m ? 1 : 0;
    if (p.is_near == 0) {
      const double inverse = 1 / (s.range_m + later_m), m = (y - s.along_m) * inverse;
      const double across = (1 - m * m) * inverse, step = d * inverse;
      const double slope = -places.turns_per_m * d * m;
      const double bend = -places.turns_per_m * d * d * across;
      const double shift = -2 * places.points_per_m * d * places.per_reach;
      p.turns = fixed_turns(s.turns - places.turns_per_m * later_m +
                            static_cast<double>(places.group.to_first) * slope);
      p.slope = fixed_turns(slope);
      p.bend[0] = static_cast<float>(0.5 * bend);
      p.bend[1] = static_cast<float>(-0.5 * bend * m * step);
      p.bend[2] = static_cast<float>(-0.125 * bend * (1 - 5 * m * m) * step * step);
      p.offset = places.offset_at(s, later_m, first[i]);
      p.shift[0] = static_cast<float>(shift * m);
      p.shift[1] = static_cast<float>(shift * 0.5 * d * across);
    }
    path[i] = p;
  }
};

// Writes moment [pings][points][2 kTerms][group.count] for pings from first_ping on. The count is
// pings times points times group.count.
template <int kTerms>
struct SumMoments {
  SoundPlaces places;
  const GroupPath* path;
  const std::int32_t* first;   // of each sound
  const std::uint32_t* begin;  // from FindSounds
  const unsigned char* uses;   // [pings of the batch]; null: all
  int points, first_ping;
  int before, behind;  // a kernel from point p on has its sound in [p + before, p + behind)
  Complex32* moment;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const int count = places.group.count;
    const auto element = static_cast<int>(i % count);
    const auto cell = static_cast<std::int32_t>(i / count % points);
    const std::int64_t ping = first_ping + i / count / points;
    if (uses != nullptr && uses[ping] == 0) return;
    Complex32 sum[2 * kTerms] = {};
    for (int turn = -1; turn <= 1; ++turn) {
      const std::int32_t point = cell + turn * points;
      const int low = point + before, high = point + behind;
      if (high <= 0 || low >= 2 * points) continue;
      const std::uint32_t* at = begin + ping * (2 * points + 1);
      const std::uint32_t end = at[high < 2 * points ? high : 2 * points];
      // Threads of other cells look for their sounds at the same time, and add them together.
      for (std::uint32_t s = at[low > 0 ? low : 0]; s < end; ++s) {
        while (s < end && first[s] != point) ++s;
        if (s == end) break;
        add(s, point, element, sum);
      }
    }
    Complex32* to = moment + (i / count) * 2 * kTerms * count + element;
    ENSONIFY_UNROLL
    for (int k = 0; k < 2 * kTerms; ++k) to[k * count] = sum[k];
  }

  ENSONIFY_HD void add(std::uint32_t s, std::int32_t point, int element, Complex32* sum) const {
    const GroupPath p = path[s];
    const float x = places.group.to_first + static_cast<float>(element);
    Complex32 value;
    float offset;
    if (p.is_near == 0) {
      const auto fixed = static_cast<std::int32_t>(static_cast<std::uint32_t>(p.turns) +
                                                   static_cast<std::uint32_t>(element) *
                                                       static_cast<std::uint32_t>(p.slope));
      value = product(p.value, phasor(static_cast<float>(fixed) * 0x1p-32f +
                                      x * x * (p.bend[0] + x * (p.bend[1] + x * p.bend[2]))));
      offset = p.offset + x * (p.shift[0] + x * p.shift[1]);
    } else {
      const Sound& sound = places.sounds[s];
      const double y_m = places.group.middle_m + static_cast<double>(x) * places.group.spacing_m;
      const double later_m = longer_way_m(sound.range_m, sound.along_m, y_m);
      value = turned(p.value, sound.turns - later_m * places.turns_per_m);
      offset = places.offset_at(sound, later_m, point);
    }
    ENSONIFY_UNROLL
    for (int k = 0; k < 2 * kTerms; ++k) {
      sum[k] += value;
      value = offset * value;
    }
  }
};

// Writes or adds to the grids [pings][elements][points] of a group, from the moments of pings from
// first_ping on. The count is pings times ceil(points / kPointsAThread) times group.count.
struct SumCells {
  const Complex32* moment;
  const PointWeights* weight;  // [width + kPointsAThread - 1][2 terms]
  const unsigned char* uses;   // [pings of the batch]; null: all
  DeviceGroup group;
  int powers, width, points, elements, first_ping;  // powers: 2 terms
  bool adds;
  Complex32* grid;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const int count = group.count, blocks = (points + kPointsAThread - 1) / kPointsAThread;
    const auto element = static_cast<int>(i % count);
    const auto point = static_cast<int>(i / count % blocks) * kPointsAThread;
    const std::int64_t ping = i / count / blocks;
    if (uses != nullptr && uses[first_ping + ping] == 0) return;
    const Complex32* of_ping = moment + ping * points * powers * count + element;
    Complex32 sum[kPointsAThread] = {};
    for (int d = 0; d < width + kPointsAThread - 1; ++d) {
      int cell = point - (width - 1) + d;
      if (cell < 0) cell += points;
      if (cell >= points) cell -= points;
      const Complex32* at = of_ping + std::int64_t{cell} * powers * count;
      for (int k = 0; k < powers; ++k) {
        const PointWeights w = weight[d * powers + k];
        const Complex32 m = at[k * count];
        ENSONIFY_UNROLL
        for (int j = 0; j < kPointsAThread; ++j) sum[j] += w.of_point[j] * m;
      }
    }
    Complex32* to =
        grid + ((first_ping + ping) * elements + group.first + element) * points + point;
    ENSONIFY_UNROLL
    for (int j = 0; j < kPointsAThread; ++j) {
      if (point + j >= points) continue;
      to[j] = adds ? Complex32{to[j].re + sum[j].re, to[j].im + sum[j].im} : sum[j];
    }
  }
};

// Sounds on the device in the order of their delays. Those of a ping start at begin[ping].
struct SoundList {
  const Sound* sounds;
  std::int64_t count;
  const std::uint32_t* begin;  // [pings + 1]
};

// Pings whose moments are in memory at once. Few, so that these stay in the device's cache.
inline constexpr int kMomentPings = 4;

template <class Queue>
class ElementGrids {
 public:
  ElementGrids(Queue& queue, const SynthesisSetup& setup) : queue_(queue), setup_(setup) {}

  // Device memory for each sound.
  static constexpr std::uint64_t sound_bytes() { return sizeof(GroupPath) + sizeof(std::int32_t); }
  // Device memory for each ping.
  static std::uint64_t ping_bytes(std::uint64_t points) {
    return (2 * points + 1) * sizeof(std::uint32_t);
  }

  // Writes or adds to grid [pings][elements][groups.points], for pings that use it. `weight` holds
  // groups.weight on the device. uses: [pings]; null: all.
  void gather(std::int64_t pings, const SoundList& list, const DeviceGroups& groups,
              const PointWeights* weight, const unsigned char* uses, bool adds, Complex32* grid) {
    const std::int64_t at_once = std::min<std::int64_t>(pings, kMomentPings);
    path_.need(list.count);
    first_.need(list.count);
    begin_.need(pings * (2 * groups.points + 1));
    moment_.need(at_once * groups.points * 2 * groups.terms * groups.elements);
    queue_.run(pings * (2 * groups.points + 1),
               FindSounds{list.sounds, list.begin, groups.points, begin_.data()});
    const int elements = setup_.sonar.array->elements;
    for (int first = 0; first < elements; first += groups.elements) {
      const SoundPlaces places = places_of(list, groups, first);
      queue_.run(list.count, PlaceInGroup{places, path_.data(), first_.data()});
      for (std::int64_t ping = 0; ping < pings; ping += at_once) {
        const std::int64_t count = std::min(at_once, pings - ping);
        sum_moments(places, groups, uses, static_cast<int>(ping), count);
        const int blocks = (groups.points + kPointsAThread - 1) / kPointsAThread;
        queue_.run(
            count * blocks * places.group.count,
            SumCells{moment_.data(), weight, uses, places.group, 2 * groups.terms, groups.width,
                     groups.points, elements, static_cast<int>(ping), adds, grid});
      }
    }
  }

  // Releases the buffers of batches.
  void drop_buffers() {
    path_.drop();
    first_.drop();
    begin_.drop();
    moment_.drop();
  }

 private:
  SoundPlaces places_of(const SoundList& list, const DeviceGroups& groups, int first) const {
    const Sonar& sonar = setup_.sonar;
    const double c = setup_.water.sound_speed_m_s, spacing_m = sonar.array->spacing_m;
    const int elements = sonar.array->elements;
    const int count = std::min(groups.elements, elements - first);
    const double middle_m = (first + (count - 1) / 2.0 - (elements - 1) / 2.0) * spacing_m;
    const double points_per_s = sonar.bandwidth_hz * groups.points / setup_.record.transform;
    return {list.sounds,
            {first, count, middle_m, spacing_m, -static_cast<float>(count - 1) / 2},
            sonar.frequency_hz / c,
            points_per_s / c,
            groups.exact_range_m,
            groups.width,
            groups.per_reach};
  }

  void sum_moments(const SoundPlaces& places, const DeviceGroups& groups, const unsigned char* uses,
                   int first_ping, std::int64_t pings) {
    // 0.01 is more than the rounding errors.
    const double reach = std::abs(places.group.middle_m) * places.points_per_m + 0.01;
    const auto run = [&]<int kTerms>(std::integral_constant<int, kTerms>) {
      queue_.run(pings * groups.points * places.group.count,
                 SumMoments<kTerms>{
                     places, path_.data(), first_.data(), begin_.data(), uses, groups.points,
                     first_ping, static_cast<int>(std::floor(0.5 * groups.width - 1 - reach)),
                     static_cast<int>(std::floor(0.5 * groups.width + reach)) + 1, moment_.data()});
    };
    for_terms(groups.terms, run);
  }

  // Registers have to be counted when a kernel is compiled.
  template <class Run>
  static void for_terms(int terms, const Run& run) {
    if (terms <= 3) return run(std::integral_constant<int, 3>());
    if (terms == 4) return run(std::integral_constant<int, 4>());
    if (terms == 5) return run(std::integral_constant<int, 5>());
    if (terms == 6) return run(std::integral_constant<int, 6>());
    if (terms == 7) return run(std::integral_constant<int, 7>());
    run(std::integral_constant<int, 8>());
  }

  Queue& queue_;
  SynthesisSetup setup_;
  DeviceBuffer<GroupPath, Queue> path_{queue_};
  DeviceBuffer<std::int32_t, Queue> first_{queue_};
  DeviceBuffer<std::uint32_t, Queue> begin_{queue_};
  DeviceBuffer<Complex32, Queue> moment_{queue_};
};

}  // namespace ensonify
