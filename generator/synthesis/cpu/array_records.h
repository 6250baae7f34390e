// From scatterers and volumes to what every element hears.
//
//   ArrayEchoes       a ping's scatterers as the origin sees them
//   gather_echoes
//   RecordScratch     memory of one worker
//   element_spectra   spectra of the elements' records, pulse and noise in them
//   element_series    and back to samples
#pragma once

#include <complex>

#include "core/parallel.h"
#include "synthesis/cpu/array_plan.h"
#include "synthesis/cpu/echoes.h"
#include "synthesis/cpu/pool.h"

namespace ensonify {

struct ArrayEchoes {
  AlignedBuffer<double> range_m, along_m, turns, position;
  AlignedBuffer<float> re, im;  // a gain E(u) S0
  std::size_t count = 0;
};

// A chunk of points with what each is worth.
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

// spectra: [elements][bins], k = 0 first. Volumes and noise where the amplitude is drawn.
void element_spectra(const ArrayPlan& plan, const Kernels& kernels, const PingTask& task,
                     const ArrayEchoes& echoes, EchoAmplitude amplitude, Pool<RecordScratch>& pool,
                     const Workers& workers, AlignedBuffer<std::complex<double>>& spectra);

// series: [elements][samples].
void element_series(const ArrayPlan& plan, const AlignedBuffer<std::complex<double>>& spectra,
                    Pool<RecordScratch>& pool, const Workers& workers, std::complex<float>* series);

std::uint64_t record_scratch_bytes(const ArrayPlan& plan);

}  // namespace ensonify
