// From the elements' records to beams, sample by sample and element by element.
//
//   FineRecords     records twice as dense as their samples
//   make_fine_records
//   direct_beams    sums of all elements for some of the samples
#pragma once

#include <complex>

#include "core/parallel.h"
#include "synthesis/cpu/array_plan.h"
#include "synthesis/cpu/array_records.h"

namespace ensonify {

struct FineRecords {
  AlignedBuffer<float> planes;  // [elements][re, im][even, odd half samples][stride]
  std::int64_t stride = 0;
};

// Of samples [0, samples) and what beams need around them.
void make_fine_records(const ArrayPlan& plan, const AlignedBuffer<std::complex<double>>& spectra,
                       int samples, Pool<RecordScratch>& pool, const Workers& workers,
                       FineRecords& fine);

// series [beams][plan.samples()], of samples [0, samples) only.
void direct_beams(const ArrayPlan& plan, const Kernels& kernels, const FineRecords& fine,
                  int samples, const Workers& workers, std::complex<float>* series);

std::uint64_t fine_bytes(const ArrayPlan& plan, int samples);

}  // namespace ensonify
