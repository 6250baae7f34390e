// Realizations of one scene, and their moments from series and from a backend that adds them.
//
//   DrawnEnsemble  ensemble_of
//   pool_of_scene
//   moments_of_series   what the processor adds from the series of a backend
//   added_there         what the backend adds itself
#pragma once

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "catch.h"
#include "core/moments.h"
#include "synthesis/device_fixture.h"

namespace ensonify::test {

// Realizations of one scene with means, noise and water.
struct DrawnEnsemble {
  SynthesisSetup setup;
  ScattererList list;
  std::vector<VolumeEcho> water;
  int lags = 0;

  std::vector<PingTask> tasks(std::uint32_t first, std::uint32_t last) const {
    std::vector<PingTask> result;
    for (std::uint32_t ping = first; ping < last; ++ping) {
      PingTask task{&list, keys_of_ping(ping, 4), 1e-6, water};
      task.keys.noise = stream_key(4, Stream::noise, 0);
      task.keys.noise_ping = ping;
      task.wants_clean = false;
      task.converts = true;
      result.push_back(task);
    }
    return result;
  }
  Moments none() const { return {setup.sonar.beam_count, setup.record.samples, lags}; }
};

inline DrawnEnsemble ensemble_of(const SynthesisSetup& setup, std::vector<Scatterer> scatterers,
                                 int lags) {
  DrawnEnsemble ensemble{setup, {}, {}, lags};
  ensemble.list = sorted_by_beam_and_delay(std::move(scatterers), setup.sonar.beam_count);
  ensemble.water.push_back(volume_of(setup, [](int beam, int n) { return 1e-10 * (beam + n); }));
  return ensemble;
}

// Pixels of which some are pooled.
inline PooledPixels pool_of_scene(const DrawnEnsemble& ensemble, const Backend& backend) {
  PingTask task = ensemble.tasks(0, 1)[0];
  task.wants_clean = true;
  const PingSeries series = one(backend, task);
  return pool_of({series.clean_power_pa2.begin(), series.clean_power_pa2.end()}, 15);
}

// What the processor adds from the series of a backend.
inline Moments moments_of_series(const DrawnEnsemble& ensemble, const Backend& backend,
                                 const PooledPixels& pool, std::uint32_t pings) {
  Moments moments = ensemble.none();
  for (std::uint32_t first = 0; first < pings; first += kMomentBlock) {
    const auto tasks = ensemble.tasks(first, std::min(first + kMomentBlock, pings));
    std::vector<PingSeries> made(tasks.size());
    backend.synthesize(tasks, made, Workers(2));
    std::vector<decltype(PingSeries::pressure_pa)> series;
    for (PingSeries& ping : made) series.push_back(std::move(ping.pressure_pa));
    add_block(series, first, 0, moments.beams, moments);
    add_pooled(series, pool, 0, moments.beams, moments);
    moments.count += series.size();
  }
  return moments;
}

// Adds pings [moments.count, last) in calls of at most `each`.
inline Moments added_there(const DrawnEnsemble& ensemble, const Backend& backend,
                           const PooledPixels& pool, Moments moments, std::uint32_t last,
                           std::uint32_t each) {
  const auto sums = backend.moment_sums(moments, pool);
  REQUIRE(sums);
  for (auto first = static_cast<std::uint32_t>(moments.count); first < last; first += each) {
    const auto tasks = ensemble.tasks(first, std::min(first + each, last));
    REQUIRE(sums->add(tasks, Workers(2)) == tasks.size());
  }
  sums->read(moments);
  return moments;
}

}  // namespace ensonify::test
