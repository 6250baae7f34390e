// The groups of stages that are timed. Times of stages and references are of one thread.
//
//   Bench                      a case ready to run
//   trace_ping  trace_behind  scatterers_of  drawn_amplitudes   the first stages of a ping
//   time_backend_stages  time_plain_methods  check_plain_methods  time_file_stages
//   check_array  time_plain_array  time_array_stages             of the case of an array
#pragma once

#include <complex>
#include <optional>
#include <vector>

#include "bench/bench.h"
#include "bench/kernels.h"
#include "bench/machine.h"
#include "bench/plain.h"
#include "synthesis/backend.h"
#include "trace/scatter.h"
#include "trace/tracer.h"

namespace ensonify {

// A case ready to run.
struct Bench {
  Bench(const BenchCase& bench_case, const BenchOptions& bench_options,
        const MachineReport& machine_report);

  const BenchOptions& options;
  const MachineReport& machine;
  SynthesisSetup setup;
  World world;
  Tracer tracer;
  Fan fan;
  SurfaceScattering scattering;
  RandomKeys keys;
  Pose pose = bench_pose();
};

// The first stages of a ping, as the pipeline calls them.
std::vector<Hit> trace_ping(const Bench& bench, const Workers& workers);
HitsBehind trace_behind(const Bench& bench, const std::vector<Hit>& hits, const Workers& workers);
ScattererList scatterers_of(const Bench& bench, const std::vector<Hit>& hits,
                            const Workers& workers);

std::vector<std::complex<float>> drawn_amplitudes(const ScattererList& list,
                                                  const RandomKeys& keys);

// What is inside the backend, its stages called one by one: `speckle`, `ray_sum` (scatterers to the
// spectra of sectors), `mixing` and `fft` (spectra to series), of the series alone.
void time_backend_stages(const Bench& bench, const ScattererList& list, CaseReport& report);

struct PlainTimes {
  double direct_ms = 0, recurrence_ms = 0;  // whole synthesis: ray sum, mixing, transforms
};

// ray_sum_direct, ray_sum_recurrence, mixing_full and fft_rows, appended to `references` where it
// is given. If all scatterers at all bins take too long, evenly spread beam cells represent all.
PlainTimes time_plain_methods(const Bench& bench, const ScattererList& list,
                              const std::vector<std::complex<float>>& amplitude,
                              const Workers& workers, std::vector<Timing>* references);

// Fills the errors of the plain methods' spectra; `exact` as of exact_spectra.
void check_plain_methods(const Bench& bench, const ScattererList& list,
                         const std::vector<std::complex<float>>& amplitude,
                         const std::vector<std::complex<double>>& exact, const Workers& workers,
                         CaseReport& report);

// Images, labels, encoders, hashing and writing. Error (io): a file cannot be written.
Status time_file_stages(const Bench& bench, const ScattererList& list, const std::vector<Hit>& hits,
                        const PingSeries& series, const std::filesystem::path& folder,
                        CaseReport& report);

// Of `beams` beams evenly spread over the fan, every element and bin summed.
SeriesError check_array(const Bench& bench, const ScattererList& list,
                        const std::vector<std::complex<float>>& amplitude, const PingSeries& series,
                        int beams, const Workers& workers);

// Spectra of all elements by plain sums: a few elements are timed, over a few of the sectors, and
// scaled. The cost of their beams is neglected.
PlainTimes time_plain_array(const Bench& bench, const ScattererList& list,
                            const std::vector<std::complex<float>>& amplitude,
                            const Workers& workers, CaseReport* report);

// speckle, ray_sum_and_fft, mixing: of the array's own kind.
void time_array_stages(const Bench& bench, const ScattererList& list, CaseReport& report);

}  // namespace ensonify
