// The CPU backend: chooses the method and the vector instructions for a setup.
#include <algorithm>
#include <optional>

#include "acoustics/pulse.h"
#include "core/error.h"
#include "core/runtime.h"
#include "synthesis/adc.h"
#include "synthesis/cpu/doppler_synthesis.h"
#include "synthesis/cpu/kernels.h"
#include "synthesis/cpu/ping_synthesis.h"
#include "synthesis/fft.h"

namespace ensonify {

namespace sse4 {
extern const Kernels kKernels;
}
namespace avx2 {
extern const Kernels kKernels;
}
namespace avx512 {
extern const Kernels kKernels;
}

const Kernels& kernels_of(SimdLevel level) {
  ENSONIFY_ASSERT(level <= best_simd_level());
  if (level == SimdLevel::avx512) return avx512::kKernels;
  return level == SimdLevel::avx2 ? avx2::kKernels : sse4::kKernels;
}

namespace {

using Complex = std::complex<double>;

// Below this tolerance, single precision is not sufficient.
constexpr double kFinestFast = 1e-6;

// pulse_autospectrum by FFT: the Fourier coefficients of |s|^2, from samples at twice the rate.
std::vector<Complex> fast_autospectrum(const std::vector<Complex>& spectrum) {
  const int count = static_cast<int>(spectrum.size());
  AlignedBuffer<Complex> samples(2 * spectrum.size());
  std::copy(spectrum.begin(), spectrum.end(), samples.begin());
  ComplexFft(2 * count, FftDirection::backward).run(samples.data());
  for (Complex& s : samples) s = std::norm(s);
  ComplexFft(2 * count, FftDirection::forward).run(samples.data());
  std::vector<Complex> autospectrum(samples.begin(), samples.begin() + count);
  for (Complex& q : autospectrum) q /= 2.0 * count;
  return autospectrum;
}

std::unique_ptr<PingSynthesis> make_unshifted(const SynthesisTables& tables) {
  std::unique_ptr<PingSynthesis> fast;
  if (tables.setup.sonar.array) {
    if (tables.setup.tolerance >= kFinestFast) fast = make_array_synthesis(tables);
    return fast ? std::move(fast) : make_double_array_synthesis(tables);
  }
  if (tables.setup.tolerance >= kFinestFast) fast = make_fast_synthesis(tables);
  return fast ? std::move(fast) : make_double_synthesis(tables);
}

bool may_shift(const SynthesisSetup& setup) {
  return setup.min_doppler != 0 || setup.max_doppler != 0;
}

std::unique_ptr<PingSynthesis> make_synthesis(const SynthesisSetup& setup) {
  SynthesisTables tables{
      setup, make_mixing(setup.sonar), pulse_spectrum(setup.sonar, setup.record.transform), {}};
  tables.autospectrum = fast_autospectrum(tables.spectrum);
  if (!may_shift(setup)) return make_unshifted(tables);
  std::unique_ptr<PingSynthesis> shifted = make_doppler_synthesis(tables, make_unshifted);
  ENSONIFY_ASSERT(shifted != nullptr);  // can_shift
  return shifted;
}

bool any_shifted(const ScattererList& list) {
  return std::any_of(list.items.begin(), list.items.end(),
                     [](const Scatterer& s) { return s.doppler != 0; });
}

// Whether both are draws of one scene, of which only the series is wanted.
bool are_draws(const PingTask& a, const PingTask& b) {
  const auto wants_series = [](const PingTask& task) {
    return !task.wants_clean && !task.wants_channels;
  };
  return wants_series(a) && wants_series(b) && a.scatterers == b.scatterers &&
         a.volumes.data() == b.volumes.data() && a.volumes.size() == b.volumes.size();
}

// The number of tasks from the first on that are draws of one scene; 1 if it is alone.
std::size_t draws_in_front(std::span<const PingTask> tasks) {
  std::size_t count = 1;
  while (count < tasks.size() && are_draws(tasks[0], tasks[count])) ++count;
  return count;
}

class CpuBackend final : public Backend {
 public:
  explicit CpuBackend(const SynthesisSetup& setup)
      : cells_(std::size_t(setup.sonar.beam_count) * setup.record.samples),
        can_shift_(may_shift(setup)),
        adc_(setup.sonar.adc),
        synthesis_(make_synthesis(setup)) {}

  SynthesisMemory memory(bool has_volumes) const override {
    return synthesis_->memory(has_volumes);
  }

  void synthesize(std::span<const PingTask> tasks, std::span<PingSeries> series,
                  const Workers& workers) const override {
    ENSONIFY_ASSERT(tasks.size() == series.size());
    for (std::size_t first = 0; first < tasks.size();) {
      const std::size_t count = draws_in_front(tasks.subspan(first));
      run(tasks.subspan(first, count), series.subspan(first, count), workers);
      first += count;
    }
  }

  int draws_at_once() const override { return synthesis_->draws_at_once(); }

 private:
  // One task, or draws of one scene.
  void run(std::span<const PingTask> tasks, std::span<PingSeries> series,
           const Workers& workers) const {
    for (const VolumeEcho& volume : tasks[0].volumes) {
      ENSONIFY_ASSERT(volume.energy.size() == cells_);
    }
    ENSONIFY_ASSERT(can_shift_ || !any_shifted(*tasks[0].scatterers));
    if (tasks.size() == 1) {
      synthesis_->run(tasks[0], series[0], workers);
    } else {
      synthesis_->run_draws(tasks, series, workers);
    }
    for (std::size_t i = 0; i < tasks.size(); ++i) {
      series[i].level_db.clear();
      if (tasks[i].converts && adc_) quantise(*adc_, series[i].pressure_pa);
    }
  }

  std::size_t cells_;
  bool can_shift_;
  std::optional<Adc> adc_;
  std::unique_ptr<PingSynthesis> synthesis_;
};

}  // namespace

bool can_shift(const SynthesisSetup& setup) {
  const DopplerPulse pulse = make_doppler_pulse(setup.sonar, setup.record.transform);
  return choose_doppler_nodes(pulse, setup.tolerance).degree > 0;
}

std::unique_ptr<Backend> make_cpu_backend(const SynthesisSetup& setup) {
  return std::make_unique<CpuBackend>(setup);
}

}  // namespace ensonify
