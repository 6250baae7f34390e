// Makes the records of an array's elements from scatterers and volumes, and beams from the records.
//
//   ElementGroups  choose_groups      neighboring elements that share the place of an echo
//   ArrayPlan  make_array_plan        what all pings of one array share
//   BeamTaps   make_beam_taps         how beams read the elements' records
//   ArrayEchoes  gather_echoes        a ping's scatterers as seen from the origin
//   RecordScratch                     the memory of one worker
//   element_spectra  element_series   spectra of the elements' records with pulse and noise, and
//                                     their samples
//   FineRecords  make_fine_records    records with twice the sampling rate
//   direct_beams                      sums of all elements for some of the samples
#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/parallel.h"
#include "synthesis/beamforming.h"
#include "synthesis/cpu/kernels.h"
#include "synthesis/cpu/node_sums.h"
#include "synthesis/cpu/ping_synthesis.h"
#include "synthesis/cpu/spread_kernel.h"
#include "synthesis/fft.h"

namespace ensonify {

// The larger |azimuth| of the two outer beams.
inline double furthest_beam_rad(const Sonar& sonar) {
  return std::max(std::abs(beam_azimuth_rad(sonar, 0)),
                  std::abs(beam_azimuth_rad(sonar, sonar.beam_count - 1)));
}

// For every beam and element: the taps that interpolate the element's record, at twice its sampling
// rate, at the steering delay.
struct BeamTaps {
  int pad = 0;                      // additional samples at both ends of the record
  std::vector<double> correction;   // [k = 0 .. M/2], for the record's spectrum; even in k
  std::vector<std::int32_t> begin;  // [beams][elements], in half samples
  std::vector<float> tap;           // [beams][elements][kBeamTaps]
};

BeamTaps make_beam_taps(const SynthesisSetup& setup, const ArrayGeometry& geometry);

// The elements of a group hear an echo at almost the same time, so that one place of the kernel
// suffices for all, if its polynomials hold for offsets up to `reach`.
struct ElementGroups {
  int elements = 0;  // of one group; 0 if no group is small enough
  double reach = 1;
  WidePolynomials wide;
  double exact_range_m = 0;  // the expansion of paths does not hold for nearer points
};

// The largest groups, of at most `most` elements, that hold the setup's tolerance.
ElementGroups choose_groups(const SynthesisSetup& setup, const SpreadKernel& spread, int most);

// What a plan suits. Each echo is deposited once for each element. On a processor, a grid of twice
// the length therefore costs less than a kernel of two vectors.
struct ArrayLimits {
  int kernel_width = 8;  // is preferred, where a kernel exists
  int group_elements = kGroupElements;
};

struct ArrayPlan {
  SynthesisSetup setup;
  ArrayGeometry geometry;
  SpreadKernel spread;
  GroupKernel kernel;  // points to `coefficient`
  std::vector<float> coefficient;
  int group_elements = 0;                    // elements of one group
  double exact_range_m = 0;                  // nearer points are deposited one element at a time
  std::vector<std::complex<double>> filter;  // [M], k = 0 first: pulse, with the kernel undone
  BeamTaps taps;
  ComplexFft grid_forward, record_forward, record_backward, fine_backward;

  int elements() const { return static_cast<int>(geometry.y_m.size()); }
  int beams() const { return setup.sonar.beam_count; }
  int samples() const { return setup.record.samples; }
  int bins() const { return setup.record.transform; }
  int groups() const { return (elements() + group_elements - 1) / group_elements; }
  double points_per_s() const { return setup.sonar.bandwidth_hz * spread.points / bins(); }

  // `turns_per_m` has the sign of the phases.
  GroupLine line(int first_element, int count, double turns_per_m) const;
};

// The value of the spreading kernel at a tap, from its polynomials.
double group_kernel_at(const GroupKernel& kernel, int tap, double offset);

// Null if single precision or the expansion about groups cannot hold the tolerance.
std::shared_ptr<const ArrayPlan> make_array_plan(const SynthesisTables& tables,
                                                 const ArrayLimits& limits = {});

// The least distance from a point to the nearest element at which a group with `group_elements` can
// be expanded about its middle.
double expansion_clearance_m(const SynthesisSetup& setup, int group_elements);

struct ArrayEchoes {
  AlignedBuffer<double> range_m, along_m, turns, position;
  AlignedBuffer<float> re, im;  // a gain E(u) S0
  std::size_t count = 0;
};

// A chunk of points with their complex amplitudes.
struct PointChunk {
  alignas(64) double range_m[kPointChunk], along_m[kPointChunk], turns[kPointChunk],
      position[kPointChunk];
  alignas(64) float re[kPointChunk], im[kPointChunk];
  std::uint32_t key_low[kPointChunk], key_high[kPointChunk];
  PathArrays paths;

  PointArrays arrays() const { return {range_m, along_m, turns, position}; }
};

struct RecordScratch {
  AlignedBuffer<float> grid;
  AlignedBuffer<std::complex<double>> spectrum, record;
  PointChunk chunk;
};

void gather_echoes(const ArrayPlan& plan, const Kernels& kernels, const PingTask& task,
                   EchoAmplitude amplitude, Pool<PointChunk>& pool, const Workers& workers,
                   ArrayEchoes& echoes);

// spectra: [elements][bins], k = 0 first. Includes volumes and noise if `amplitude` is drawn.
void element_spectra(const ArrayPlan& plan, const Kernels& kernels, const PingTask& task,
                     const ArrayEchoes& echoes, EchoAmplitude amplitude, Pool<RecordScratch>& pool,
                     const Workers& workers, AlignedBuffer<std::complex<double>>& spectra);

// series: [elements][samples].
void element_series(const ArrayPlan& plan, const AlignedBuffer<std::complex<double>>& spectra,
                    Pool<RecordScratch>& pool, const Workers& workers, std::complex<float>* series);

std::uint64_t record_scratch_bytes(const ArrayPlan& plan);

struct FineRecords {
  AlignedBuffer<float> planes;  // [elements][re, im][even, odd half samples][stride]
  std::int64_t stride = 0;
};

// Makes samples [0, samples) and the margins that beams need at both ends.
void make_fine_records(const ArrayPlan& plan, const AlignedBuffer<std::complex<double>>& spectra,
                       int samples, Pool<RecordScratch>& pool, const Workers& workers,
                       FineRecords& fine);

// Writes samples [0, samples) of series [beams][plan.samples()].
void direct_beams(const ArrayPlan& plan, const Kernels& kernels, const FineRecords& fine,
                  int samples, const Workers& workers, std::complex<float>* series);

std::uint64_t fine_bytes(const ArrayPlan& plan, int samples);

}  // namespace ensonify
