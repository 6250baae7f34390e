// What the tests of a device compare.
//
//   one           a ping by itself
//   relative      relative L2 error; without a norm, the error's square
//   same_bytes    of values, of pings
//   with_shifts   a setup, and echoes of which two in three are shifted
//   check_same_at_rest  check_independent_of_batches   of batches with shifted pings
#pragma once

#include <cmath>
#include <complex>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "catch.h"
#include "core/random.h"
#include "synthesis/host_device.h"
#include "synthesis/ping_fixture.h"

namespace ensonify::test {

inline PingSeries one(const Backend& backend, const PingTask& task) {
  PingSeries series;
  backend.synthesize({&task, 1}, {&series, 1}, Workers(2));
  return series;
}

template <class Values>
double relative(const Values& got, const Values& expected) {
  REQUIRE(got.size() == expected.size());
  double error = 0, norm = 0;
  for (std::size_t i = 0; i < got.size(); ++i) {
    error += std::norm(std::complex<double>(got[i]) - std::complex<double>(expected[i]));
    norm += std::norm(std::complex<double>(expected[i]));
  }
  return norm > 0 ? std::sqrt(error / norm) : error;
}

template <class T, class A>
bool same_bytes(const std::vector<T, A>& a, const std::vector<T, A>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

inline bool same_bytes(const PingSeries& a, const PingSeries& b) {
  return same_bytes(a.pressure_pa, b.pressure_pa) &&
         same_bytes(a.clean_power_pa2, b.clean_power_pa2) &&
         same_bytes(a.channels_pa, b.channels_pa) && same_bytes(a.level_db, b.level_db);
}

inline SynthesisSetup with_shifts(const Sonar& sonar, double most) {
  SynthesisSetup setup = setup_of(sonar);
  setup.min_doppler = -most;
  setup.max_doppler = most;
  return setup;
}

// Every third at rest, the others shifted by up to `most` to either side.
inline std::vector<Scatterer> with_shifts(std::vector<Scatterer> scatterers, double most) {
  for (std::size_t i = 0; i < scatterers.size(); ++i) {
    if (i % 3 == 0) continue;
    scatterers[i].doppler = static_cast<float>(most * (2 * uniform(71, 0, i, 0) - 1));
  }
  return scatterers;
}

// Protects echoes at rest, of tasks 0, 2 and 5 of 7: what else a batch or a setup has leaves no bit
// of them changed.
inline void check_same_at_rest(const SynthesisSetup& setup, std::span<const PingTask> tasks) {
  const auto backend = host_device(setup);
  std::vector<PingSeries> together(7);
  backend->synthesize(tasks, together, Workers(2));
  for (const int p : {0, 2, 5}) {
    CAPTURE(p);
    CHECK(same_bytes(together[p], one(*host_device(setup_of(setup.sonar)), tasks[p])));
    CHECK(same_bytes(together[p], one(*backend, tasks[p])));
  }
}

// Protects reproducibility of 7 tasks: nodes that other pings need, threads, the order of batches
// and their size leave no trace.
inline void check_independent_of_batches(const SynthesisSetup& setup,
                                         std::span<const PingTask> tasks) {
  std::vector<PingSeries> together(7), few(7), tight(7);
  host_device(setup)->synthesize(tasks, together, Workers(2));
  const auto single = host_device(setup, new HostQueue(std::size_t{1} << 40, 1, 1));
  single->synthesize(tasks, few, Workers(1));
  auto* measured = new HostQueue();
  const auto alone = host_device(setup, measured);
  alone->synthesize(tasks.last(1), {&tight[6], 1}, Workers(1));
  // Says that it has plenty, and fails: batches shrink.
  const auto shrinking = host_device(setup, new HostQueue(2 * measured->peak));
  shrinking->synthesize(tasks, tight, Workers(2));
  for (int p = 6; p >= 0; --p) {
    CAPTURE(p);
    CHECK(same_bytes(few[p], together[p]));
    CHECK(same_bytes(tight[p], together[p]));
    CHECK(same_bytes(one(*alone, tasks[p]), together[p]));
  }
}

}  // namespace ensonify::test
