// Ensembles on a device: moments that it adds are those of its series. The device is the host.
#include <algorithm>
#include <complex>
#include <memory>
#include <utility>
#include <vector>

#include "core/moments.h"
#include "synthesis/array_fixture.h"
#include "synthesis/device_fixture.h"
#include "synthesis/ensemble_fixture.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

constexpr std::size_t kPlenty = std::size_t{1} << 40;

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

// A device with queues of its own kind; `last` is the one that was made last.
struct EnsembleDevice {
  HostQueue* last = nullptr;
  int made = 0;
  std::unique_ptr<Backend> backend;

  EnsembleDevice(const SynthesisSetup& setup, std::size_t limit_bytes, std::size_t says_free) {
    const auto make_queue = [this, limit_bytes, says_free] {
      auto queue = std::make_unique<HostQueue>(limit_bytes, says_free);
      last = queue.get();
      ++made;
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
  // An array holds the moments of at most four pings at once, whatever the memory.
  CHECK(2 * tight.last->launches > 3 * launches);
  const Moments half = added_there(ensemble, *device.backend, pool, none, 16, 8);
  CHECK(half.count == 16);
  CHECK(device.made == 2);
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
  auto sums = small.backend->moment_sums(none, pool);
  REQUIRE(sums);
  CHECK(sums->add(ensemble.tasks(0, 32), Workers(2)) == 0);
  Moments left = none;
  sums->read(left);
  check_same(left, none);
  sums.reset();  // and gives its memory back
  CHECK(small.backend->moment_sums(none, pool) != nullptr);
  CHECK(small.made == 3);
  const std::size_t values = none.values.size() * sizeof(double);
  const std::size_t tables = EnsembleDevice(ensemble.setup, kPlenty, kPlenty).last->peak;
  const EnsembleDevice tiny(ensemble.setup, tables + values, kPlenty);
  CHECK(tiny.backend->moment_sums(none, pool) == nullptr);
}

// Protects sequences that are made at the same time: each waits for a lane, and the lane keeps
// nothing of the scene before.
TEST_CASE("device: ensembles at the same time have moments of their own") {
  std::vector<DrawnEnsemble> scenes(2, ensembles()[0]);
  for (Scatterer& s : scenes[1].list.items) s.gain *= 2;
  const auto backend = host_device(scenes[0].setup);
  const PooledPixels pool = pool_of_scene(scenes[0], *backend);
  std::vector<Moments> expected, got(6, scenes[0].none());
  for (const DrawnEnsemble& scene : scenes) {
    expected.push_back(added_there(scene, *host_device(scene.setup), pool, scene.none(), 16, 8));
  }
  Workers(6).for_each(6, [&](std::size_t i) {
    const auto sums = backend->moment_sums(got[i], pool);
    sums->add(scenes[i % 2].tasks(0, 8), Workers(1));
    sums->add(scenes[i % 2].tasks(8, 16), Workers(1));
    sums->read(got[i]);
  });
  for (std::size_t i = 0; i < got.size(); ++i) check_same(got[i], expected[i % 2]);
}
