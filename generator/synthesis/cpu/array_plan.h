// What all pings of one array share.
//
//   ArrayPlan  make_array_plan
//   BeamTaps   make_beam_taps   where beams find the elements' records
#pragma once

#include <complex>
#include <cstdint>
#include <memory>
#include <vector>

#include "synthesis/array.h"
#include "synthesis/cpu/fft.h"
#include "synthesis/cpu/kernels.h"
#include "synthesis/cpu/ping_synthesis.h"
#include "synthesis/cpu/spread_kernel.h"

namespace ensonify {

// For every beam and element: the taps that read the element's record, twice as dense as its
// samples, at the steering delay.
struct BeamTaps {
  int pad = 0;                      // samples that the record is longer at either end
  std::vector<double> correction;   // [k = 0 .. M/2], of the record's spectrum; even in k
  std::vector<std::int32_t> begin;  // [beams][elements], in half samples
  std::vector<float> tap;           // [beams][elements][kBeamTaps]
};

BeamTaps make_beam_taps(const SynthesisSetup& setup, const ArrayGeometry& geometry);

struct ArrayPlan {
  SynthesisSetup setup;
  ArrayGeometry geometry;
  SpreadKernel spread;
  GroupKernel kernel;  // of `coefficient`
  std::vector<float> coefficient;
  int group_elements = 0;                    // that one group has
  double exact_range_m = 0;                  // nearer points are deposited one element at a time
  std::vector<std::complex<double>> filter;  // [M], k = 0 first: pulse, kernel undone
  BeamTaps taps;
  ComplexFft grid_forward, record_forward, record_backward, fine_backward;

  int elements() const { return static_cast<int>(geometry.y_m.size()); }
  int beams() const { return setup.sonar.beam_count; }
  int samples() const { return setup.record.samples; }
  int bins() const { return setup.record.transform; }
  int groups() const { return (elements() + group_elements - 1) / group_elements; }
  double points_per_s() const { return setup.sonar.bandwidth_hz * spread.points / bins(); }

  // `turns_per_m` with the sign that phases get.
  GroupLine line(int first_element, int count, double turns_per_m) const;
};

// The spreading kernel at a tap, by its polynomials.
double group_kernel_at(const GroupKernel& kernel, int tap, double offset);

// None where single precision or the expansion about groups cannot hold the tolerance.
std::shared_ptr<const ArrayPlan> make_array_plan(const SynthesisTables& tables);

// How far a point must be from the nearest element for a group of so many to be expanded about its
// middle.
double expansion_clearance_m(const SynthesisSetup& setup, int group_elements);

}  // namespace ensonify
