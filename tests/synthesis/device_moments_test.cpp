// Ensembles on a device: moments that it adds are those of its series. The device is the host.
#include <algorithm>
#include <complex>
#include <memory>
#include <utility>
#include <vector>

#include "core/moments.h"
#include "synthesis/array_fixture.h"
#include "synthesis/device_fixture.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

constexpr std::size_t kPlenty = std::size_t{1} << 40;

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

DrawnEnsemble ensemble_of(const SynthesisSetup& setup, std::vector<Scatterer> scatterers,
                          int lags) {
  DrawnEnsemble ensemble{setup, {}, {}, lags};
  ensemble.list = sorted_by_beam_and_delay(std::move(scatterers), setup.sonar.beam_count);
  ensemble.water.push_back(volume_of(setup, [](int beam, int n) { return 1e-10 * (beam + n); }));
  return ensemble;
}

// Pixels of which some are pooled.
PooledPixels pool_of_scene(const DrawnEnsemble& ensemble, const Backend& backend) {
  PingTask task = ensemble.tasks(0, 1)[0];
  task.wants_clean = true;
  const PingSeries series = one(backend, task);
  return pool_of({series.clean_power_pa2.begin(), series.clean_power_pa2.end()}, 15);
}

// What the processor adds from the series of a backend.
Moments moments_of_series(const DrawnEnsemble& ensemble, const Backend& backend,
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
Moments added_there(const DrawnEnsemble& ensemble, const Backend& backend, const PooledPixels& pool,
                    Moments moments, std::uint32_t last, std::uint32_t each) {
  const auto sums = backend.moment_sums(moments, pool);
  REQUIRE(sums);
  for (auto first = static_cast<std::uint32_t>(moments.count); first < last; first += each) {
    const auto tasks = ensemble.tasks(first, std::min(first + each, last));
    REQUIRE(sums->add(tasks, Workers(2)) == tasks.size());
  }
  sums->read(moments);
  return moments;
}

void check_same(const Moments& got, const Moments& expected) {
  CHECK(got.count == expected.count);
  CHECK(same_bytes(got.values, expected.values));
}

// Of every sum over pixels and every pooled sum.
void check_near(const Moments& got, const Moments& expected) {
  for (int moment = 0; moment < kMoments; ++moment) {
    std::vector<double> a, b;
    for (int beam = 0; beam < got.beams; ++beam) {
      const auto row = static_cast<MomentRow>(moment);
      a.insert(a.end(), got.of(row, beam).begin(), got.of(row, beam).end());
      b.insert(b.end(), expected.of(row, beam).begin(), expected.of(row, beam).end());
    }
    CAPTURE(moment);
    CHECK(relative(a, b) < 1e-4);
  }
}

std::vector<DrawnEnsemble> ensembles() {
  Sonar beams = p900(7, 7, 1);
  Sonar converted = beams;
  converted.adc = Adc{12, 100};
  const Sonar array = line_array(5, 6, 30, 1);
  const auto near = [](const Sonar& sonar) { return random_scatterers(sonar, 60, 0.2, 31); };
  return {ensemble_of(setup_of(beams), near(beams), 3),
          ensemble_of(setup_of(converted), near(converted), 0),
          ensemble_of(with_shifts(beams, 1e-3), with_shifts(near(beams), 1e-3), 1),
          ensemble_of(setup_of(array), fan_echoes(array, 40, 0.2), 2)};
}

}  // namespace

// A device with queues of its own kind; `last` is the queue that was made last.
struct EnsembleDevice {
  HostQueue* last = nullptr;
  std::unique_ptr<Backend> backend;

  EnsembleDevice(const SynthesisSetup& setup, std::size_t limit_bytes, std::size_t says_free) {
    const auto make_queue = [this, limit_bytes, says_free] {
      auto queue = std::make_unique<HostQueue>(limit_bytes, says_free);
      last = queue.get();
      return queue;
    };
    backend = make_device_backend<HostQueue>(make_queue, setup);
  }
};

// Protects the numbers of ensembles: a device adds what its series would give, to the bit, and
// neither the size of batches nor a pause leaves a trace. Only the moments come down.
TEST_CASE("device: moments are those of its series, in batches of any size") {
  const DrawnEnsemble ensemble = ensembles()[GENERATE(0, 1, 2, 3)];
  const EnsembleDevice device(ensemble.setup, kPlenty, kPlenty), tight(ensemble.setup, kPlenty, 1);
  const PooledPixels pool = pool_of_scene(ensemble, *device.backend);
  const Moments none = ensemble.none();
  const Moments expected = moments_of_series(ensemble, *device.backend, pool, 29);
  check_same(added_there(ensemble, *device.backend, pool, none, 29, 64), expected);
  CHECK(device.last->downloaded_bytes == expected.values.size() * sizeof(double));
  const int launches = device.last->launches;
  check_same(added_there(ensemble, *tight.backend, pool, none, 29, 64), expected);
  CHECK(tight.last->launches > 2 * launches);
  const Moments half = added_there(ensemble, *device.backend, pool, none, 16, 8);
  CHECK(half.count == 16);
  check_same(added_there(ensemble, *device.backend, pool, half, 29, 64), expected);
}

TEST_CASE("device: moments are those of the processor") {
  const DrawnEnsemble ensemble = ensembles()[0];
  const auto device = host_device(ensemble.setup), cpu = make_cpu_backend(ensemble.setup);
  CHECK(cpu->moment_sums(ensemble.none(), {}) == nullptr);
  const PooledPixels pool = pool_of_scene(ensemble, *cpu);
  const Moments expected = moments_of_series(ensemble, *cpu, pool, 20);
  check_near(added_there(ensemble, *device, pool, ensemble.none(), 20, 64), expected);
}

// Protects ensembles on small devices: batches shrink down to a block, and what does not fit then
// is left to the caller.
TEST_CASE("device: an ensemble takes the memory that there is") {
  const DrawnEnsemble ensemble = ensembles()[0];
  const EnsembleDevice plenty(ensemble.setup, kPlenty, kPlenty);
  const PooledPixels pool = pool_of_scene(ensemble, *plenty.backend);
  const Moments none = ensemble.none();
  const Moments expected = added_there(ensemble, *plenty.backend, pool, none, 32, 64);
  const std::size_t whole = plenty.last->peak;
  const EnsembleDevice blocks(ensemble.setup, kPlenty, 1);
  added_there(ensemble, *blocks.backend, pool, none, 8, 8);
  const std::size_t least = blocks.last->peak;
  REQUIRE(least < whole);
  for (const std::size_t limit : {least, (least + whole) / 2}) {
    const EnsembleDevice shrinking(ensemble.setup, limit, kPlenty);
    check_same(added_there(ensemble, *shrinking.backend, pool, none, 32, 64), expected);
  }
  const EnsembleDevice small(ensemble.setup, least - 1, kPlenty);
  const auto sums = small.backend->moment_sums(none, pool);
  REQUIRE(sums);
  CHECK(sums->add(ensemble.tasks(0, 32), Workers(2)) == 0);
  Moments left = none;
  sums->read(left);
  check_same(left, none);
  const std::size_t values = none.values.size() * sizeof(double);
  const std::size_t tables = EnsembleDevice(ensemble.setup, kPlenty, kPlenty).last->peak;
  const EnsembleDevice tiny(ensemble.setup, tables + values, kPlenty);
  CHECK(tiny.backend->moment_sums(none, pool) == nullptr);
}

// Protects sequences that are made at the same time: each waits for a lane and has its own moments.
TEST_CASE("device: ensembles at the same time have moments of their own") {
  DrawnEnsemble ensemble = ensembles()[0];
  const auto backend = host_device(ensemble.setup);
  const PooledPixels pool = pool_of_scene(ensemble, *backend);
  const Moments expected = added_there(ensemble, *backend, pool, ensemble.none(), 9, 8);
  std::vector<Moments> got(5, ensemble.none());
  Workers(5).for_each(5, [&](std::size_t i) {
    const auto sums = backend->moment_sums(ensemble.none(), pool);
    sums->add(ensemble.tasks(0, 8), Workers(1));
    sums->add(ensemble.tasks(8, 9), Workers(1));
    sums->read(got[i]);
  });
  for (const Moments& moments : got) check_same(moments, expected);
}
