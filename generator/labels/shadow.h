// Labels of what is hidden, in polar coordinates: rows are samples, columns beams.
//
//   HiddenInput   HiddenLabels  hidden_labels   shadows, and which instances a pixel would hold
//   InstanceSets  resample                      several instances a pixel
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/ping.h"
#include "core/scatterers.h"
#include "labels/polar.h"

namespace ensonify {

// Pixels with any number of instances, row-major: many share a set.
struct InstanceSets {
  int rows = 0, columns = 0;
  std::vector<std::uint32_t> set;  // 0: no instance

  // Blocks of the polar image number their sets for themselves, from block * stride on.
  using Tables = std::vector<std::vector<std::vector<std::uint16_t>>>;
  std::uint32_t stride = 1;
  std::shared_ptr<const Tables> of_block;

  // The instances of one pixel's set, by id.
  std::span<const std::uint16_t> instances(std::uint32_t set_number) const {
    return (*of_block)[set_number / stride][set_number % stride];
  }
};

struct HiddenInput {
  const PolarInput& heard;
  const HiddenEchoes& hidden;
  // Read where noise is given: the power that echoes of energy 1 give a pixel of beam j at the
  // pulse's peak, Pa^2 m^2, and |s(t)|^2 of the pulse at the kPulseSteps + 1 times from -1/b to
  // 1/b.
  std::span<const double> power_per_energy;  // [beams]
  std::span<const double> pulse_power;
};
inline constexpr int kPulseSteps = 64;

struct HiddenLabels {
  std::vector<std::uint16_t> shadow;  // [samples x beams]: the instance that casts it; 0: none
  InstanceSets amodal;
};

// A pixel hears and would hear the direct echoes of its own sector within c/2b of its sample.
// Shadow: where the energy of the hidden echoes that one instance alone keeps away is above that of
// all that are heard, volumes included, and, where noise is given, their power not under the
// noise's. Its occluder is the instance that keeps most energy away, ties go to the lower id.
// Amodal: the instances with any energy, heard or hidden, each with power not under the noise's
// where noise is given, and the pixel's own label. `image` is polar_image's.
HiddenLabels hidden_labels(const HiddenInput& input, const LabelledImage& image,
                           const Workers& workers);

// As labels/cartesian.h resamples.
InstanceSets resample(const InstanceSets& polar, const CartesianGrid& grid,
                      const std::vector<std::int32_t>& map);

}  // namespace ensonify
