// The seam between scatterers and time series.
//
// A backend takes batches of pings. A ping is a list of scatterers with no ray grid in it and the
// keys of its random numbers; out come the series and its expected power. How the sonar moved while
// the sound travelled is in the delays, arrivals and shifts of the scatterers. Every backend draws
// xi from the same keys and is measured against the reference.
//
//   SynthesisSetup   what all pings of a sequence share
//   PingTask         one ping to synthesize
//   PingSeries       its result
//   SynthesisMemory  what that takes beside
//   Backend          the seam
//   make_..._backend the implementations
#pragma once

#include <complex>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/runtime.h"
#include "core/scatterers.h"
#include "core/sonar.h"

namespace ensonify {

struct SynthesisSetup {
  Sonar sonar;
  Water water;
  Record record;
  // Relative L2 error of a record that the CPU backend may make, and tenfold within any tenth of
  // the record, against the reference; 1e-3 to 1e-7. Under 1e-6 it works in double precision.
  double tolerance = 1e-5;
  SimdLevel simd = best_simd_level();
  // Between which the shifts of scatterers are expected. Both 0: none is shifted. What lies outside
  // is synthesized too, in more memory than announced.
  double min_doppler = 0, max_doppler = 0;
};

// Whether the CPU backend can hold the tolerance for shifted echoes; the reference always can.
bool can_shift(const SynthesisSetup& setup);

struct RandomKeys {
  std::uint64_t speckle = 0;       // stream_key(seed, Stream::speckle, sequence)
  std::uint32_t speckle_ping = 0;  // counter; 0 for every ping where the pattern is frozen
  std::uint64_t noise = 0;         // stream_key(seed, Stream::noise, sequence)
  std::uint32_t noise_ping = 0;
  std::uint64_t volume = 0;  // stream_key(seed, Stream::volume, sequence); pings as for speckle
};

struct PingTask {
  const ScattererList* scatterers = nullptr;
  RandomKeys keys;
  double noise_power_pa2 = 0;  // E|p|^2 of the noise in every sample; 0: none
  std::span<const VolumeEcho> volumes;
  bool wants_clean = true;      // without, clean_power_pa2 stays empty
  bool wants_channels = false;  // of an array: without, channels_pa stays empty
  // The samples go through sonar.adc, where there is one, before anything is made of them; channels
  // do not.
  bool converts = false;
  // The picture alone is asked for: level_db may come in place of pressure_pa.
  bool only_level = false;
};

struct PingSeries {
  std::vector<std::complex<float>> pressure_pa;  // [beams x samples], complex baseband
  std::vector<float> clean_power_pa2;            // [beams x samples], expected, without noise
  std::vector<std::complex<float>> channels_pa;  // [elements x samples], what each element hears
  // [samples x beams], image_level_db of |pressure_pa|^2, which is empty then. Otherwise empty.
  std::vector<float> level_db;
};

// What a backend keeps in memory beside tasks and results.
struct SynthesisMemory {
  std::uint64_t shared_bytes = 0;  // tables
  std::uint64_t ping_bytes = 0;    // more for each ping at once
  std::uint64_t echo_bytes = 0;    // more for each scatterer of these
  std::uint64_t thread_bytes = 0;  // more for each thread
};

class Backend {
 public:
  virtual ~Backend() = default;

  virtual SynthesisMemory memory(bool has_volumes) const = 0;

  // series[i] becomes the result of tasks[i]; both spans have the same length.
  // p_j(t_n) = S0 sum_i B_az(theta_i - theta_j)/N_j a_i gain_i e^(-i 2 pi f_c tau_i) s(t_n - tau_i)
  // over all scatterers i, s of a shifted one that of doppler_spectrum, weights at cell centers
  // (Choi et al. 2021, Eq 8-22), plus volumes, plus noise. Volumes: one scatterer at t_n in each
  // sector, drawn with the sum of the energies. clean_j(t_n) = |the same sum over the means|^2
  //              + S0^2 sum_i (B_az/N_j)^2 variance_i gain_i^2 |s(t_n - tau_i)|^2, volumes
  //              included; the first with shifts, the second without: |s| is stretched by
  //              1 + doppler, nothing else.
  // With sonar.array both are what synthesis/beamforming.h says, summed over all elements: a
  // volume's scatterer is at the sector's azimuth, elevation 0 and range c t_n / 2, and noise is
  // drawn for every element and every sample of the record's period. channels_pa are the elements'
  // p_n(t), noise included, before any delay. Throws std::bad_alloc where memory does not suffice.
  virtual void synthesize(std::span<const PingTask> tasks, std::span<PingSeries> series,
                          const Workers& workers) const = 0;
};

// Double precision, term by term: what every other backend is measured against. Seconds a ping.
std::unique_ptr<Backend> make_reference_backend(const SynthesisSetup& setup);

// Deposit on a time grid, FFT, and mixing in as few sums as the tolerance allows. May be called
// from several threads at once. Series that are handed in again keep their memory: then nothing is
// allocated.
std::unique_ptr<Backend> make_cpu_backend(const SynthesisSetup& setup);

}  // namespace ensonify
