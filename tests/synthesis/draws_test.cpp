// Pings of one scene that are synthesized together: each is the ping that it would be alone.
#include <cstring>
#include <utility>

#include "catch.h"
#include "synthesis/ping_fixture.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

struct DrawnScene {
  SynthesisSetup setup;
  ScattererList list;
  std::vector<VolumeEcho> water;

  PingTask task(std::uint32_t ping) const {
    PingTask result{&list, keys_of_ping(ping, 4), 1e-6, water};
    result.keys.noise = stream_key(4, Stream::noise, 0);
    result.keys.noise_ping = ping;
    result.wants_clean = false;
    return result;
  }
};

DrawnScene drawn_scene(bool equal_beams, bool has_echoes, bool has_water) {
  Sonar sonar = p900(70, 14, 3);
  if (!equal_beams) {
    for (int j = 0; j < 70; ++j) sonar.azimuth_rad.push_back(0.003 * (j - 35) + 4e-6 * j * j);
  }
  DrawnScene scene{setup_of(sonar), {}, {}};
  // Some cells of beams are empty, and a row of nodes hears nothing.
  std::vector<Scatterer> scatterers =
      has_echoes ? random_scatterers(sonar, 700, 0.4, 31) : std::vector<Scatterer>();
  for (Scatterer& s : scatterers) s.beam = 30 + s.beam / 2;
  scene.list = sorted_by_beam_and_delay(std::move(scatterers), 70);
  if (has_water) {
    scene.water.push_back(
        volume_of(scene.setup, [](int beam, int n) { return 1e-9 * (beam + n); }));
  }
  return scene;
}

std::vector<PingSeries> drawn_together(const Backend& backend, const std::vector<PingTask>& tasks,
                                       int threads) {
  std::vector<PingSeries> series(tasks.size());
  backend.synthesize(tasks, series, Workers(threads));
  return series;
}

bool same_bits(const PingSeries& a, const PingSeries& b) {
  return a.clean_power_pa2.empty() && b.clean_power_pa2.empty() &&
         a.pressure_pa.size() == b.pressure_pa.size() &&
         std::memcmp(a.pressure_pa.data(), b.pressure_pa.data(),
                     a.pressure_pa.size() * sizeof(a.pressure_pa[0])) == 0;
}

}  // namespace

// Protects the bytes of ensembles from batches, threads and instruction sets: a realization is the
// same alone, in a batch of any size, and next to any others.
TEST_CASE("draws that are made together are those made alone") {
  const bool equal_beams = GENERATE(true, false);
  const int content = GENERATE(1, 2, 3);  // echoes, volumes, both
  DrawnScene scene = drawn_scene(equal_beams, content != 2, content != 1);
  for (const SimdLevel level : {SimdLevel::sse4, SimdLevel::avx2, SimdLevel::avx512}) {
    if (level > best_simd_level()) continue;
    INFO(simd_level_name(level) << " content " << content);
    scene.setup.simd = level;
    const auto backend = make_cpu_backend(scene.setup);
    CHECK(backend->draws_at_once() == 8);
    std::vector<PingSeries> alone;
    for (std::uint32_t ping = 0; ping < 17; ++ping) {
      alone.push_back(drawn_together(*backend, {scene.task(ping)}, 1)[0]);
    }
    CHECK_FALSE(same_bits(alone[0], alone[1]));
    using Pings = std::pair<std::uint32_t, std::uint32_t>;
    for (const auto& [first, last] : {Pings{0, 2}, {3, 8}, {5, 16}, {0, 17}}) {
      std::vector<PingTask> tasks;
      for (std::uint32_t i = first; i < last; ++i) tasks.push_back(scene.task(i));
      const auto together = drawn_together(*backend, tasks, static_cast<int>(1 + last % 4));
      for (std::uint32_t i = first; i < last; ++i) {
        INFO("ping " << i << " of " << first << " to " << last);
        REQUIRE(same_bits(together[i - first], alone[i]));
      }
    }
  }
}

// Protects pings that are not draws of one scene, or want more than the series, in the same call.
TEST_CASE("draws are found among other pings of a batch") {
  const DrawnScene one = drawn_scene(true, true, true), other = drawn_scene(true, true, false);
  const auto backend = make_cpu_backend(one.setup);
  std::vector<PingTask> tasks = {one.task(0), one.task(1),   other.task(2), other.task(3),
                                 one.task(4), other.task(5), one.task(6)};
  tasks[1].wants_clean = true;
  tasks[4].volumes = {};
  const auto together = drawn_together(*backend, tasks, 2);
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    INFO(i);
    const auto alone = drawn_together(*backend, {tasks[i]}, 1)[0];
    CHECK(together[i].pressure_pa == alone.pressure_pa);
    CHECK(together[i].clean_power_pa2 == alone.clean_power_pa2);
  }
  CHECK_FALSE(together[1].clean_power_pa2.empty());
}

// Protects tolerances that single precision cannot hold: they have their own method, ping by ping.
TEST_CASE("draws in double precision are those made alone") {
  DrawnScene scene = drawn_scene(true, true, true);
  scene.setup.tolerance = 1e-7;
  const auto backend = make_cpu_backend(scene.setup);
  CHECK(backend->draws_at_once() == 1);
  const auto together = drawn_together(*backend, {scene.task(0), scene.task(1)}, 2);
  CHECK(same_bits(together[0], drawn_together(*backend, {scene.task(0)}, 1)[0]));
  CHECK(same_bits(together[1], drawn_together(*backend, {scene.task(1)}, 1)[0]));
}
