// The work of one thread of a device for an array, element by element. As in beam_kernels.h, each
// functor writes only its own results and adds up in a fixed order.
//
//   longer_way_m  phasor  turned
//   HearEchoes  HearCells   sounds at the origin, in the order of delays
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

// e^(i 2 pi turns) for a few turns.
ENSONIFY_HD inline Complex32 phasor(float turns) {
  const float quarters = 4 * turns, whole = std::rint(quarters);
  const float x = (quarters - whole) * 1.57079632679f, z = x * x;
  const float s = ((-1.9515295891e-4f * z + 8.3321608736e-3f) * z - 1.6666654611e-1f) * z * x + x;
  const float c =
      ((2.443315711809948e-5f * z - 1.388731625493765e-3f) * z + 4.166664568298827e-2f) * z * z -
      0.5f * z + 1;
  const auto quadrant = static_cast<std::int32_t>(whole);
  const float re = (quadrant & 1) != 0 ? s : c, im = (quadrant & 1) != 0 ? c : s;
  return {((quadrant + 1) & 2) != 0 ? -re : re, (quadrant & 2) != 0 ? -im : im};
}

ENSONIFY_HD inline Complex32 turned(Complex32 value, double turns) {
  return product(value, phasor(static_cast<float>(turns - std::rint(turns))));
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

// Writes the first `near` samples of beams [pings][beams][samples] from fine [pings][elements][2
// transform]: the sum of every element's record at its steering delay, with the phases of delay and
// focus.
struct SumElements {
  const Complex32* fine;
  const std::int32_t* begin;  // [beams][elements], index into 2 transform
  const ElementTaps* tap;     // [beams][elements]
  const Complex32* steering;  // [beams][elements]; used without focus
  const float* weight;        // [elements]; used with focus
  const double *y_m, *cosine;
  double sample_m, turns_per_m;
  int beams, elements, near, samples, transform;
  bool focused;
  Complex32* out;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const auto n = static_cast<int>(i % near);
    const std::int64_t row = i / near, ping = row / beams;
    const auto beam = static_cast<int>(row % beams);
    const double range_m = (n > 1 ? n : 1) * sample_m;
    Complex32 sum{0, 0};
    for (int e = 0; e < elements; ++e) {
      const std::int64_t at = std::int64_t{beam} * elements + e;
      const Complex32 heard =
          record_at(fine + (ping * elements + e) * 2 * transform, 2 * n + begin[at], tap[at]);
      Complex32 w = steering[at];
      if (focused) {
        const double later_m = longer_way_m(range_m, range_m * cosine[beam], y_m[e]);
        w = turned({weight[e], 0}, later_m * turns_per_m);
      }
      sum += product(w, heard);
    }
    out[row * samples + n] = sum;
  }

  // The record at half sample `half`, which is in [0, 4 transform).
  ENSONIFY_HD Complex32 record_at(const Complex32* record, int half,
                                  const ElementTaps& taps) const {
    if (half >= 2 * transform) half -= 2 * transform;
    Complex32 sum{0, 0};
    ENSONIFY_UNROLL
    for (int m = 0; m < kElementTaps; ++m) {
      const int at = half + m;
      sum += taps.of_tap[m] * record[at < 2 * transform ? at : at - 2 * transform];
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
