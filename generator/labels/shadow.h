// Labels of hidden instances, in polar coordinates: rows are samples, columns beams.
//
//   HiddenInput   HiddenLabels  hidden_labels   shadow masks and amodal masks
//   InstanceSets                                several instances per pixel
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

// Pixels with any number of instances, row-major. Many pixels share the same set.
struct InstanceSets {
  int rows = 0, columns = 0;
  std::vector<std::uint32_t> set;  // 0: no instance

  // Each block of the polar image numbers its own sets, from block * stride on.
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
  // Needed if noise is given: the power that echoes of energy 1 give a pixel of beam j at the
  // pulse's peak, Pa^2 m^2, and |s(t)|^2 of the pulse at the kPulseSteps + 1 times from -1/b to
  // 1/b.
  std::span<const double> power_per_energy;  // [beams]
  std::span<const double> pulse_power;
};
inline constexpr int kPulseSteps = 64;

struct HiddenLabels {
  std::vector<std::uint16_t> shadow;  // [samples x beams]: the occluder; 0: none
  InstanceSets amodal;
};

// A pixel hears, or would hear without occluders, the direct echoes of its beam cell within c/2b of
// its sample. Shadow: a pixel is in shadow if the energy of the echoes that a single instance hides
// exceeds that of all echoes that are heard, including volumes, and if their power is not below the
// noise, where given. The occluder is the instance that hides the most energy; the lower id wins if
// two are equal. Amodal: the pixel's own label, and all instances with any energy, heard or hidden.
// If noise is given, instances with a power below it are left out. `image` is that of polar_image.
HiddenLabels hidden_labels(const HiddenInput& input, const LabelledImage& image,
                           const Workers& workers);

}  // namespace ensonify
