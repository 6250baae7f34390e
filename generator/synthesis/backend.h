// The interface between scatterers and time series.
//
// A backend takes batches of pings. A ping consists of a list of scatterers, without any ray grid,
// and the keys of its random numbers. The results are the time series and its expected power. The
// delays, arrivals and Doppler of the scatterers include the motion of the sonar while the sound
// travels. Every backend draws xi from the same keys and is compared with the reference.
//
//   SynthesisSetup   what all pings of a sequence share
//   PingTask         one ping to synthesize
//   PingSeries       its result
//   SynthesisMemory  the memory that a backend needs in addition to these
//   MomentSums       moments of realizations that the backend itself adds
//   Backend          the interface
//   make_..._backend the implementations
#pragma once

#include <complex>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/runtime.h"
#include "core/samples.h"
#include "core/scatterers.h"
#include "core/sonar.h"

namespace ensonify {

struct Moments;       // core/moments.h
struct PooledPixels;  // likewise

struct SynthesisSetup {
  Sonar sonar;
  Water water;
  Record record;
  // Largest relative L2 error of a record of the CPU backend against the reference, from 1e-7 to
  // 1e-3. Within any tenth of the record, ten times this error is allowed. Below 1e-6 the backend
  // works in double precision.
  double tolerance = 1e-5;
  SimdLevel simd = best_simd_level();
  // The limits between which the Doppler of scatterers is expected. Both are 0 if no scatterer has
  // Doppler. Scatterers outside of the limits are synthesized too, but take more memory than
  // memory() returns.
  double min_doppler = 0, max_doppler = 0;
};

// Whether the CPU backend can hold the tolerance for Doppler echoes. The reference always can.
bool can_shift(const SynthesisSetup& setup);

struct RandomKeys {
  // stream_key(seed, Stream::speckle, sequence), mixed with the speckle seed if there is one
  std::uint64_t speckle = 0;
  std::uint32_t speckle_ping = 0;  // counter; 0 for every ping if the pattern is frozen
  std::uint64_t noise = 0;         // stream_key(seed, Stream::noise, sequence)
  std::uint32_t noise_ping = 0;
  std::uint64_t volume = 0;  // likewise, of Stream::volume; pings as for speckle
};

struct PingTask {
  const ScattererList* scatterers = nullptr;
  RandomKeys keys;
  double noise_power_pa2 = 0;  // E|p|^2 of the noise in every sample; 0: none
  std::span<const VolumeEcho> volumes;
  bool wants_clean = true;      // if false, clean_power_pa2 stays empty
  bool wants_channels = false;  // for an array; if false, channels_pa stays empty
  // Whether sonar.adc, if the sonar has one, rounds the samples before they are used. It does not
  // apply to channels.
  bool converts = false;
  // Only the image is needed: the backend may return level_db in place of pressure_pa.
  bool only_level = false;
};

// A backend may keep its own memory in the arrays, which then may outlive the backend.
struct PingSeries {
  Series pressure_pa;                  // [beams x samples], complex baseband
  SampleArray<float> clean_power_pa2;  // [beams x samples], expected, without noise
  Series channels_pa;                  // [elements x samples], what each element hears
  // [samples x beams], image_level_db of |pressure_pa|^2. Exactly one of level_db and pressure_pa
  // is filled.
  SampleArray<float> level_db;
};

// The memory that a backend uses in addition to tasks and results.
struct SynthesisMemory {
  std::uint64_t shared_bytes = 0;  // tables
  std::uint64_t ping_bytes = 0;    // for each ping in work at the same time
  std::uint64_t echo_bytes = 0;    // for each scatterer of these pings
  std::uint64_t thread_bytes = 0;  // for each thread
};

// Moments of realizations of one scene, whose series stay with the backend. They have the bits that
// add_block and add_pooled of core/moments.h make from the series of synthesize().
class MomentSums {
 public:
  virtual ~MomentSums() = default;

  // Adds the series of tasks that follow the realizations in the moments. All tasks have the same
  // scatterers and volumes, and want only the series. Every call but the last has whole blocks
  // (kMomentBlock). Returns the number of tasks that were added, from the first on: whole blocks if
  // memory does not suffice for all. One thread at a time. Throws DeviceFailure.
  virtual std::size_t add(std::span<const PingTask> tasks, const Workers& workers) = 0;
  // Writes values and count of moments that have the size of those at the start.
  virtual void read(Moments& moments) = 0;
};

class Backend {
 public:
  virtual ~Backend() = default;

  virtual SynthesisMemory memory(bool has_volumes) const = 0;

  // Writes the result of tasks[i] to series[i]. Both spans have the same length. The pressure is
  //   p_j(t_n) = S0 sum_i B_az(theta_i - theta_j)/N_j a_i gain_i e^(-i 2 pi f_c tau_i)
  //                 s(t_n - tau_i)
  // over all scatterers i, with weights at the centers of beam cells (Choi et al. 2021, Eq 8-22),
  // plus volumes, plus noise. For a scatterer with Doppler, s is the pulse of doppler_spectrum.
  // Volumes have one scatterer at t_n in each beam cell, drawn with the sum of their energies.
  // The expected power is
  //   clean_j(t_n) = |the same sum over the means|^2
  //                  + S0^2 sum_i (B_az/N_j)^2 variance_i gain_i^2 |s(t_n - tau_i)|^2,
  // volumes included. The first term includes Doppler. The second does not, because Doppler only
  // stretches |s| by 1 + doppler.
  // With sonar.array, both are the sums over all elements of synthesis/beamforming.h. There, a
  // volume's scatterer has the azimuth of the beam cell, elevation 0 and range c t_n / 2, and noise
  // is drawn for every element and every sample of the record's period. channels_pa are the
  // elements' p_n(t) with noise, before any delay. Throws std::bad_alloc if memory does not
  // suffice.
  virtual void synthesize(std::span<const PingTask> tasks, std::span<PingSeries> series,
                          const Workers& workers) const = 0;

  // How many pings with the same scatterers and volumes, of which only the series is wanted, one
  // call makes at less cost than as many calls. Such a batch takes ping_bytes, echo_bytes and
  // thread_bytes of memory() for each of its pings at most.
  virtual int draws_at_once() const { return 1; }

  // Sums that start from `moments`, whose realizations are whole blocks, and do not outlive the
  // backend. Null if the backend makes series only, or lacks the memory. May wait until other sums
  // are destroyed. Throws DeviceFailure.
  virtual std::unique_ptr<MomentSums> moment_sums(const Moments& /*moments*/,
                                                  const PooledPixels& /*pool*/) const {
    return nullptr;
  }

  // The memory of a device that is missing for one ping with this many scatterers; 0: none is
  // missing, or the backend has no device.
  virtual std::uint64_t missing_bytes(std::uint64_t /*scatterers*/, bool /*has_volumes*/) const {
    return 0;
  }
};

// The reference for every other backend: double precision, term by term. It takes seconds per ping.
std::unique_ptr<Backend> make_reference_backend(const SynthesisSetup& setup);

// Deposits echoes on a time grid, transforms it by FFT, and mixes beams in as few sums as the
// tolerance allows. Several threads may call it at once. A PingSeries that is passed in again keeps
// its memory, so that nothing is allocated.
std::unique_ptr<Backend> make_cpu_backend(const SynthesisSetup& setup);

}  // namespace ensonify
