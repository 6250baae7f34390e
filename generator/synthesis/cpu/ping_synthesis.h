// The methods of the CPU backend for one ping, from beam cells or from an array.
//
//   Pool             scratch memory that is reused
//   SynthesisTables  the input of all methods
//   PingSynthesis    make_double_synthesis  make_fast_synthesis
//                    make_double_array_synthesis  make_array_synthesis
#pragma once

#include <complex>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "synthesis/backend.h"
#include "synthesis/beamforming.h"
#include "synthesis/cpu/doppler_nodes.h"

namespace ensonify {

template <class T>
class Pool {
 public:
  class Lease {
   public:
    Lease(Pool& pool, std::unique_ptr<T> item) : pool_(pool), item_(std::move(item)) {}
    ~Lease() { pool_.give(std::move(item_)); }
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    T& operator*() { return *item_; }
    T* operator->() { return item_.get(); }

   private:
    Pool& pool_;
    std::unique_ptr<T> item_;
  };

  Lease take() {
    {
      const std::lock_guard lock(mutex_);
      if (!idle_.empty()) {
        std::unique_ptr<T> item = std::move(idle_.back());
        idle_.pop_back();
        return Lease(*this, std::move(item));
      }
      // Reserves space for all objects in use, so that returning one cannot fail.
      idle_.reserve(++made_);
    }
    return Lease(*this, std::make_unique<T>());
  }

 private:
  void give(std::unique_ptr<T> item) {
    const std::lock_guard lock(mutex_);
    idle_.push_back(std::move(item));
  }

  std::mutex mutex_;
  std::vector<std::unique_ptr<T>> idle_;
  std::size_t made_ = 0;
};

// The input of all methods.
struct SynthesisTables {
  SynthesisSetup setup;
  Mixing mixing;
  std::vector<std::complex<double>> spectrum;      // pulse_spectrum
  std::vector<std::complex<double>> autospectrum;  // pulse_autospectrum
};

class PingSynthesis {
 public:
  virtual ~PingSynthesis() = default;
  virtual SynthesisMemory memory(bool has_volumes) const = 0;
  virtual void run(const PingTask& task, PingSeries& series, const Workers& workers) const = 0;

  // How many pings run_draws makes at less cost than run, and their results: those of run. The
  // tasks have the same scatterers and volumes, and none wants more than the series.
  virtual int draws_at_once() const { return 1; }
  virtual void run_draws(std::span<const PingTask> tasks, std::span<PingSeries> series,
                         const Workers& workers) const {
    for (std::size_t i = 0; i < tasks.size(); ++i) run(tasks[i], series[i], workers);
  }

  // Synthesizes echoes with Doppler, and the memory for this with a number of nodes. False or empty
  // if the method has no better way than one run for each node.
  virtual bool run_shifted(const PingTask&, const NodeSpectra&, PingSeries&, const Workers&) const {
    return false;
  }
  virtual std::optional<SynthesisMemory> shifted_memory(bool /*has_volumes*/,
                                                        std::uint64_t /*nodes*/) const {
    return std::nullopt;
  }
};

// Works in double precision throughout and transforms every beam. Within 1e-7 of the reference.
std::unique_ptr<PingSynthesis> make_double_synthesis(const SynthesisTables& tables);

// Uses as few sums as the tolerance allows, and single precision except in transforms. Null if this
// cannot hold the tolerance.
std::unique_ptr<PingSynthesis> make_fast_synthesis(const SynthesisTables& tables);

// Uses single precision except in transforms. Null if this cannot hold the tolerance.
std::unique_ptr<PingSynthesis> make_array_synthesis(const SynthesisTables& tables);

// Deposits echoes for each element and sums elements as in the definition, in double precision.
// Within 1e-7 of the reference, but takes a minute where make_array_synthesis takes a second.
std::unique_ptr<PingSynthesis> make_double_array_synthesis(const SynthesisTables& tables);

}  // namespace ensonify
