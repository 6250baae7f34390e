// The CPU backend's ways of making one ping, of sectors or of an array.
//
//   Pool             scratch memory that outlives its use
//   SynthesisTables  what all ways start from
//   PingSynthesis    make_double_synthesis  make_fast_synthesis
//                    make_double_array_synthesis  make_array_synthesis
#pragma once

#include <complex>
#include <memory>
#include <mutex>
#include <vector>

#include "synthesis/backend.h"
#include "synthesis/beamforming.h"

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
      // Room for all that are out, so that giving one back cannot fail.
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

// What all of them start from.
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
};

// Double precision throughout, every beam transformed: within 1e-7 of the reference.
std::unique_ptr<PingSynthesis> make_double_synthesis(const SynthesisTables& tables);

// As few sums as the tolerance allows, single precision but for the transforms. None where that
// cannot hold the tolerance.
std::unique_ptr<PingSynthesis> make_fast_synthesis(const SynthesisTables& tables);

// Single precision but for the transforms. None where that cannot hold the tolerance.
std::unique_ptr<PingSynthesis> make_array_synthesis(const SynthesisTables& tables);

// Double precision and the definition's own sum over elements, after a deposit for each: within
// 1e-7 of the reference, but a minute where the other takes a second.
std::unique_ptr<PingSynthesis> make_double_array_synthesis(const SynthesisTables& tables);

}  // namespace ensonify
