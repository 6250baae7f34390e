// What goes up to a device, and what its functions work on: plain structs and pointers.
//
//   EchoRecord    one scatterer
//   ShiftRecord   one that comes back shifted
//   BatchPing    one ping of a batch
//   ArrivalRecord  DirectionRecord  SectorRecord   for an array
//   amplitude_of
//   DeviceKernel  a spreading kernel as polynomials
//   Complex32
#pragma once

#include <cstdint>

#include "core/host_device.h"
#include "core/random.h"

namespace ensonify {

struct Complex32 {
  float re, im;
};

// A scatterer, as a ping's list has it, without what synthesis does not need.
struct EchoRecord {
  double delay_s;
  std::uint64_t key;
  float mean_re, mean_im, deviation, gain;
};

// What a shifted scatterer has beside.
struct ShiftRecord {
  std::uint32_t echo;  // of the batch's
  float doppler;
};

// Where its sound seems to come from: so far away, at that cosine with the line.
struct ArrivalRecord {
  double range_m, cosine;
};

// A scatterer in the order of directions, by its index in the batch, and its cell of a PowerGrid.
struct DirectionRecord {
  std::uint32_t echo, cell;
};

// How much of a sector each of two nodes has.
struct SectorRecord {
  std::uint32_t sector;
  float even, odd;
};

// Sector j of the ping has echoes [offset[j], offset[j + 1]) of the batch's.
struct BatchPing {
  std::uint64_t speckle_key, noise_key;
  std::uint32_t speckle_ping, noise_ping;
  float noise_rms;
  std::uint32_t first_offset;  // where the ping's [sectors + 1] begin among the batch's offsets
};

// Amplitude of an echo: its mean alone, or with what is drawn.
ENSONIFY_HD inline Complex32 amplitude_of(const EchoRecord& echo, const BatchPing& ping,
                                          bool means_only) {
  if (means_only || echo.deviation == 0) return {echo.mean_re, echo.mean_im};
  const ComplexDraw xi = complex_normal(ping.speckle_key, ping.speckle_ping, echo.key, 0);
  return {static_cast<float>(echo.mean_re + echo.deviation * xi.re),
          static_cast<float>(echo.mean_im + echo.deviation * xi.im)};
}

// coefficient [degree + 1][width], highest power of the offset first.
struct DeviceKernel {
  const float* coefficient;
  int width, degree, points;
};

// The value of a kernel's point `tap` for an echo.
ENSONIFY_HD inline float kernel_at(const DeviceKernel& kernel, int tap, float offset) {
  const float* c = kernel.coefficient + tap;
  float sum = 0;
  for (int d = 0; d <= kernel.degree; ++d, c += kernel.width) sum = sum * offset + *c;
  return sum;
}

}  // namespace ensonify
