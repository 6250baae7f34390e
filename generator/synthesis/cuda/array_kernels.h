// The work of one thread of a device for an array, element by element. As in beam_kernels.h, each
// functor writes only its own results and adds up in a fixed order.
//
//   HearEchoes  HearCells   sounds at the origin, in the order of delays
//   PlaceSounds             the same sounds at an element: carrier's phase, place on the time grid
//   GatherSounds            sounds -> a point of an element's grid
//   DrawNoise               noise of an element
//   FilterElements          spectrum of a grid -> spectrum of a record, with noise
//   WidenRecords            -> spectrum of a record with twice the sampling rate
//   CutRecords              records without their ends
//   SumElements             elements -> beams
//   HearShifts              copies the sounds of Doppler echoes, and leaves their share at rest
#pragma once

#include "acoustics/pattern.h"
#include "synthesis/cuda/beam_kernels.h"
#include "synthesis/cuda/doppler_echoes.h"

namespace ensonify {

// A sound at the origin.
struct Sound {
  double range_m, along_m;  // the apparent range, and y of the apparent point
  double turns;             // of the carrier
  double points;            // on the time grid
  Complex32 value;
};

ENSONIFY_HD inline Complex32& value_of(Sound& sound) { return sound.value; }

// The length of the path from a point to y, minus the length of the path to the origin.
ENSONIFY_HD inline double longer_way_m(double range_m, double along_m, double y_m) {
  const double more = y_m * y_m - 2 * y_m * along_m;
  const double square = range_m * range_m + more;
  return more / (std::sqrt(square > 0 ? square : 0) + range_m);
}

ENSONIFY_HD inline Complex32 turned(Complex32 value, double turns) {
  const auto angle = static_cast<float>(2 * kPi * (turns - std::rint(turns)));
  return product(value, {std::cos(angle), std::sin(angle)});
}

struct HearEchoes {
  const EchoRecord* echoes;
  const ArrivalRecord* arrivals;
  const std::uint32_t* ping_of;  // [echoes]
  const BatchPing* pings;
  double frequency_hz, source_pa_m, points_per_s;
  double width_in_wavelengths;  // of an element
  bool means_only;
  Sound* out;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const EchoRecord& e = echoes[i];
    const ArrivalRecord& from = arrivals[i];
    const Complex32 a = amplitude_of(e, pings[ping_of[i]], means_only);
    const auto scale =
        static_cast<float>(source_pa_m * e.gain * sinc(width_in_wavelengths * from.cosine));
    out[i] = {from.range_m,
              from.range_m * from.cosine,
              -carrier_turns(frequency_hz, e.delay_s),
              e.delay_s * points_per_s,
              {scale * a.re, scale * a.im}};
  }
};

// out: [pings][samples][sectors]. energy: [pings][sectors][samples]. Amplitudes of volumes are
// drawn, so that only the differences between elements matter for their carrier phase.
struct HearCells {
  const float* energy;
  const BatchPing* pings;
  const std::uint64_t* volume_key;  // [pings]
  const double* cosine;             // [sectors]
  double source_pa_m, sample_m, points_per_sample;
  double width_in_wavelengths;
  int sectors, samples;
  Sound* out;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const auto sector = static_cast<int>(i % sectors);
    const auto n = static_cast<int>(i / sectors % samples);
    const std::int64_t ping = i / sectors / samples;
    const double u = cosine[sector], range_m = (n > 1 ? n : 1) * sample_m;
    out[i] = {range_m, range_m * u, 0, n * points_per_sample, {0, 0}};
    const double e = energy[(ping * sectors + sector) * samples + n];
    if (e == 0) return;
    const double rms = source_pa_m * std::sqrt(e) * sinc(width_in_wavelengths * u);
    out[i].value = narrow(cell_draw(volume_key[ping], pings[ping].speckle_ping, sector, n, rms));
  }
};

// out: [block's elements][count].
struct PlaceSounds {
  const Sound* sounds;
  std::int64_t count;
  const double* y_m;  // of the block's first element on
  double turns_per_m, points_per_m;
  int width;
  PlacedEchoes out;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const Sound& s = sounds[i % count];
    const double later_m = longer_way_m(s.range_m, s.along_m, y_m[i / count]);
    out.value[i] = turned(s.value, s.turns - later_m * turns_per_m);
    place_echo(s.points + later_m * points_per_m, 1, width, out.offset[i], out.first[i]);
  }
};

// The first of sounds [begin, end) at `points` or later.
ENSONIFY_HD inline std::int64_t first_at(const Sound* sounds, std::int64_t begin, std::int64_t end,
                                         double points) {
  while (begin < end) {
    const std::int64_t middle = begin + (end - begin) / 2;
    if (sounds[middle].points < points) {
      begin = middle + 1;
    } else {
      end = middle;
    }
  }
  return begin;
}

// Writes or adds to grid [pings][elements][points], for pings that use it. The count is pings times
// the block's elements times points. A sound at an element's grid point arrives at the origin
// within `reach` of it.
struct GatherSounds {
  const Sound* sounds;
  PlacedEchoes placed;
  std::int64_t count;
  const std::uint32_t* begin;  // [pings + 1]
  const unsigned char* uses;   // [pings]; null: all
  DeviceKernel kernel;
  double points_per_m;
  const double* y_m;  // of the block's first element on
  int elements, first_element, block;
  bool adds;
  Complex32* grid;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const auto point = static_cast<std::int32_t>(i % kernel.points);
    const auto element = static_cast<int>(i / kernel.points % block);
    const std::int64_t ping = i / kernel.points / block;
    if (uses != nullptr && uses[ping] == 0) return;
    const double y = y_m[element];
    // 0.01 is more than the rounding errors.
    const double reach = (y < 0 ? -y : y) * points_per_m + 0.01 + 0.5 * kernel.width;
    Complex32* at = grid + ((ping * elements) + first_element + element) * kernel.points + point;
    Complex32 sum = adds ? *at : Complex32{0, 0};
    add(ping, element, point, reach, sum);
    // Adds sounds that wrap around the ends of the period.
    if (point + kernel.points <= kernel.points + reach) {
      add(ping, element, point + kernel.points, reach, sum);
    }
    if (point - kernel.points >= -reach) add(ping, element, point - kernel.points, reach, sum);
    *at = sum;
  }

  ENSONIFY_HD void add(std::int64_t ping, int element, std::int32_t point, double reach,
                       Complex32& sum) const {
    const std::int64_t end = begin[ping + 1];
    const std::int64_t own = element * count;
    for (std::int64_t s = first_at(sounds, begin[ping], end, point - reach);
         s < end && sounds[s].points <= point + reach; ++s) {
      const std::int32_t tap = point - placed.first[own + s];
      if (tap < 0 || tap >= kernel.width) continue;
      const float w = kernel_at(kernel, tap, placed.offset[own + s]);
      sum += w * placed.value[own + s];
    }
  }
};

// out: [pings][elements][transform]. Draws noise for the whole period, so that a delayed record has
// the same noise power at its ends. Divides it by the length, which the spectrum needs.
struct DrawNoise {
  const BatchPing* pings;
  const float* factor;  // [elements]
  int elements, transform;
  Complex32* out;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const auto n = static_cast<int>(i % transform);
    const auto element = static_cast<int>(i / transform % elements);
    const BatchPing& ping = pings[i / transform / elements];
    const double rms = static_cast<double>(ping.noise_rms) * factor[element] / transform;
    out[i] = {0, 0};
    if (rms == 0) return;
    out[i] = narrow(cell_draw(ping.noise_key, ping.noise_ping, element, n, rms));
  }
};

// Writes or adds to spectrum [pings][elements][transform], from grids [pings][elements][points].
struct FilterElements {
  const Complex32* grid;
  const Complex32 *filter, *response;  // filter: [transform], bin 0 first; response: [elements]
  int elements, points, transform;
  bool adds;
  Complex32* spectrum;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const auto k = static_cast<int>(i % transform);
    const std::int64_t row = i / transform;
    const int at = k < transform / 2 ? k : points - transform + k;
    const Complex32 heard =
        product(response[row % elements], product(grid[row * points + at], filter[k]));
    const Complex32 noise = adds ? spectrum[i] : Complex32{0, 0};
    spectrum[i] = {noise.re + heard.re, noise.im + heard.im};
  }
};

// Writes wide [rows][2 transform] from spectrum [rows][transform].
// correction: [transform / 2 + 1].
struct WidenRecords {
  const Complex32* spectrum;
  const float* correction;
  int transform;
  Complex32* wide;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const auto k = static_cast<int>(i % (2 * transform));
    const Complex32* from = spectrum + i / (2 * transform) * transform;
    const int half = transform / 2, below = 2 * transform - k;
    wide[i] = {0, 0};
    if (k < half) wide[i] = correction[k] * from[k];
    if (below > half) return;
    wide[i] = correction[below] * from[transform - below];
  }
};

// Writes out [rows][samples] from record [rows][transform].
struct CutRecords {
  const Complex32* record;
  int samples, transform;
  Complex32* out;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    out[i] = record[i / samples * transform + i % samples];
  }
};

constexpr int kElementTaps = 8;

// Writes beams [pings][beams][samples] from fine [pings][elements][2 transform]: the sum of every
// element's record at its steering delay, with the phases of delay and focus.
struct SumElements {
  const Complex32* fine;
  const std::int32_t* begin;  // [beams][elements], index into 2 transform
  const float* tap;           // [beams][elements][kElementTaps]
  const Complex32* steering;  // [beams][elements]; used without focus
  const float* weight;        // [elements]; used with focus
  const double *y_m, *cosine;
  double sample_m, turns_per_m;
  int beams, elements, samples, transform;
  bool focused;
  Complex32* out;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const auto n = static_cast<int>(i % samples);
    const std::int64_t row = i / samples, ping = row / beams;
    const auto beam = static_cast<int>(row % beams);
    const double range_m = (n > 1 ? n : 1) * sample_m;
    Complex32 sum{0, 0};
    for (int e = 0; e < elements; ++e) {
      const std::int64_t at = std::int64_t{beam} * elements + e;
      const Complex32 heard = record_at(fine + (ping * elements + e) * 2 * transform,
                                        2 * n + begin[at], tap + at * kElementTaps);
      Complex32 w = steering[at];
      if (focused) {
        const double later_m = longer_way_m(range_m, range_m * cosine[beam], y_m[e]);
        w = turned({weight[e], 0}, later_m * turns_per_m);
      }
      sum += product(w, heard);
    }
    out[i] = sum;
  }

  // The record at half sample `half`, which is in [0, 4 transform).
  ENSONIFY_HD Complex32 record_at(const Complex32* record, int half, const float* taps) const {
    Complex32 sum{0, 0};
    for (int m = 0; m < kElementTaps; ++m) {
      int at = half + m;
      while (at >= 2 * transform) at -= 2 * transform;
      sum += taps[m] * record[at];
    }
    return sum;
  }
};

// Runs after HearEchoes.
struct HearShifts {
  const DopplerRecord* shifts;
  const EchoRecord* echoes;
  DeviceNodes nodes;
  double points_per_s;  // of the nodes' grids
  Sound* at_rest;       // [echoes]
  Complex32* value;     // [shifts], as are the next two
  NodePlace* place;
  Sound* out;  // all but the value

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const DopplerRecord& shift = shifts[i];
    Sound& sound = at_rest[shift.echo];
    place[i] = node_place(nodes, shift.doppler);
    value[i] = sound.value;
    out[i] = sound;
    out[i].points = echoes[shift.echo].delay_s * points_per_s;
    sound.value = scaled(node_weight(nodes, place[i], 0), value[i]);
  }
};

}  // namespace ensonify
