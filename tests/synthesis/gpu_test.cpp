// The CUDA backend on a device, against the CPU backend. Where none answers these tests say so and
// are counted as skipped; what they launch runs on the host in the device_*_test files.
#include "catch.h"
#include "core/scatterers.h"
#include "core/units.h"
#include "synthesis/array_fixture.h"
#include "synthesis/cuda_backend.h"
#include "synthesis/ensemble_fixture.h"
#include "synthesis/ping_fixture.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

bool has_device() {
  const auto devices = cuda_devices();
  if (!devices) WARN("skipped: " << devices.error().message);
  return devices.ok();
}

std::unique_ptr<Backend> device(const SynthesisSetup& setup) {
  auto backend = make_cuda_backend(setup);
  REQUIRE(backend);
  return std::move(*backend);
}

// Everything that a ping may hold.
void compare(const SynthesisSetup& setup, const ScattererList& list, bool wants_channels = false) {
  const VolumeEcho volume =
      volume_of(setup, [](int beam, int n) { return (beam + n) % 7 == 0 ? 1e-9 * n : 0.0; });
  PingTask task{&list, keys_of_ping(3), 1e-3, {&volume, 1}};
  task.wants_channels = wants_channels;
  const auto backend = device(setup);
  const PingSeries got = one(*backend, task), expected = one(*make_cpu_backend(setup), task);
  CHECK(relative(got.pressure_pa, expected.pressure_pa) < 1e-4);
  CHECK(relative(got.channels_pa, expected.channels_pa) < 1e-4);
  if (!setup.sonar.array) CHECK(relative(got.clean_power_pa2, expected.clean_power_pa2) < 1e-4);
  const PingSeries again = one(*backend, task), anew = one(*device(setup), task);
  CHECK(again.pressure_pa == got.pressure_pa);
  CHECK(anew.pressure_pa == got.pressure_pa);
  CHECK(anew.clean_power_pa2 == got.clean_power_pa2);
}

}  // namespace

TEST_CASE("gpu: beams of every pulse are the CPU's, and the same each time") {
  if (!has_device()) return;
  for (const PulseShape shape : {PulseShape::gaussian, PulseShape::flat, PulseShape::lfm,
                                 PulseShape::cw, PulseShape::table}) {
    CAPTURE(static_cast<int>(shape));
    Sonar sonar = p900(65, 65, 8);
    sonar.pulse = pulse_of(shape, sonar);
    compare(setup_of(sonar), sorted_by_beam_and_delay(random_scatterers(sonar, 9000, 0.1, 5), 65));
  }
}

TEST_CASE("gpu: shifted echoes are the CPU's") {
  if (!has_device()) return;
  Sonar sonar = p900(16, 16, 12);
  sonar.pulse = {PulseShape::cw, 4e-3, 0.1, {}};
  SynthesisSetup setup = setup_of(sonar);
  setup.min_doppler = -4e-3;
  setup.max_doppler = 4e-3;
  std::vector<Scatterer> echoes = random_scatterers(sonar, 800, 1, 7);
  for (std::size_t i = 0; i < echoes.size(); i += 2) {
    echoes[i].doppler = static_cast<float>(8e-3 * (uniform(4, 0, i, 0) - 0.5));
  }
  compare(setup, sorted_by_beam_and_delay(echoes, 16));
}

TEST_CASE("gpu: an array is the CPU's in every mode") {
  if (!has_device()) return;
  for (const Focus focus : {Focus::none, Focus::dynamic}) {
    for (const Steering steering : {Steering::true_delay, Steering::phase}) {
      CAPTURE(static_cast<int>(focus), static_cast<int>(steering));
      Sonar sonar = line_array(64, 30, 60, 6);
      sonar.array->focus = focus;
      sonar.array->steering = steering;
      sonar.array->response[9] = 0;
      sonar.array->response[20] = {0.9, 0.2};
      std::vector<Scatterer> echoes = random_scatterers(sonar, 3000, 0.6, 5);
      for (Scatterer& s : echoes) {
        s.arrival.azimuth_rad = static_cast<float>(beam_azimuth_rad(sonar, s.beam));
        s.received_path_m = static_cast<float>(s.delay_s * 750);
      }
      compare(setup_of(sonar), sorted_by_beam_and_delay(echoes, 30), true);
    }
  }
}

TEST_CASE("gpu: shifted echoes at an array are the CPU's") {
  if (!has_device()) return;
  SynthesisSetup setup = setup_of(line_array(64, 30, 60, 6));
  setup.min_doppler = -4e-3;
  setup.max_doppler = 4e-3;
  std::vector<Scatterer> echoes = fan_echoes(setup.sonar, 800, 0.6);
  for (std::size_t i = 0; i < echoes.size(); i += 2) {
    echoes[i].doppler = static_cast<float>(8e-3 * (uniform(4, 0, i, 0) - 0.5));
  }
  compare(setup, list_of(setup.sonar, echoes), true);
}

TEST_CASE("gpu: many pings at once are each their own") {
  if (!has_device()) return;
  const Sonar sonar = p900(128, 128, 20);
  const SynthesisSetup setup = setup_of(sonar);
  std::vector<ScattererList> lists;
  std::vector<PingTask> tasks;
  for (int p = 0; p < 40; ++p) {
    lists.push_back(sorted_by_beam_and_delay(random_scatterers(sonar, 500 * (p % 4), 1, p), 128));
  }
  for (int p = 0; p < 40; ++p) tasks.push_back({&lists[p], keys_of_ping(p), 1e-3, {}});
  const auto backend = device(setup), alone = device(setup);
  std::vector<PingSeries> together(tasks.size());
  backend->synthesize(tasks, together, Workers(2));
  for (const int p : {0, 1, 2, 3, 39}) {
    CHECK(one(*alone, tasks[p]).pressure_pa == together[p].pressure_pa);
  }
}

// Protects what is made of series before they come down.
TEST_CASE("gpu: the converter and the levels are the CPU's") {
  if (!has_device()) return;
  Sonar sonar = p900(64, 64, 12);
  sonar.adc = Adc{24, 190};
  const SynthesisSetup setup = setup_of(sonar);
  const ScattererList list = sorted_by_beam_and_delay(random_scatterers(sonar, 9000, 0.1, 5), 64);
  PingTask task{&list, keys_of_ping(3), 1e-3, {}};
  task.converts = true;
  const auto backend = device(setup);
  const PingSeries series = one(*backend, task);
  CHECK(relative(series.pressure_pa, one(*make_cpu_backend(setup), task).pressure_pa) < 1e-4);
  task.only_level = true;
  const PingSeries picture = one(*backend, task);
  CHECK(picture.pressure_pa.empty());
  REQUIRE(picture.level_db.size() == series.pressure_pa.size());
  for (int n = 0; n < setup.record.samples; ++n) {
    for (int j = 0; j < 64; ++j) {
      const std::complex<float> p = series.pressure_pa[j * setup.record.samples + n];
      REQUIRE(picture.level_db[n * 64 + j] ==
              Approx(image_level_db(p.real() * p.real() + p.imag() * p.imag())).margin(1e-3));
    }
  }
}

// Protects the numbers of ensembles: their sums on the device have the processor's order and
// rounding.
TEST_CASE("gpu: moments are those of the device's series, to the bit") {
  if (!has_device()) return;
  for (Sonar sonar : {p900(64, 64, 6), line_array(32, 30, 60, 3)}) {
    sonar.adc = Adc{16, 150};
    const SynthesisSetup setup = setup_of(sonar);
    const DrawnEnsemble ensemble = ensemble_of(setup, fan_echoes(sonar, 4000, 0.5), 5);
    const auto backend = device(setup);
    const PooledPixels pool = pool_of_scene(ensemble, *backend);
    const Moments expected = moments_of_series(ensemble, *backend, pool, 203);
    for (const std::uint32_t each : {8u, 64u}) {
      const Moments got = added_there(ensemble, *backend, pool, ensemble.none(), 203, each);
      CHECK(got.count == expected.count);
      CHECK(same_bytes(got.values, expected.values));
    }
  }
}

// Protects results from the copies of one lane beside the sums of the other.
TEST_CASE("gpu: many threads at once get what each asked for") {
  if (!has_device()) return;
  const Sonar sonar = p900(128, 128, 20);
  const SynthesisSetup setup = setup_of(sonar);
  std::vector<ScattererList> lists;
  for (int p = 0; p < 64; ++p) {
    lists.push_back(sorted_by_beam_and_delay(random_scatterers(sonar, 400 * (p % 5), 1, p), 128));
  }
  const auto backend = device(setup), alone = device(setup);
  std::vector<PingSeries> got(lists.size());
  Workers(16).for_each(lists.size(), [&](std::size_t p) {
    const PingTask task{&lists[p], keys_of_ping(static_cast<std::uint32_t>(p)), 1e-3, {}};
    backend->synthesize({&task, 1}, {&got[p], 1}, Workers(1));
  });
  for (std::size_t p = 0; p < lists.size(); ++p) {
    const PingTask task{&lists[p], keys_of_ping(static_cast<std::uint32_t>(p)), 1e-3, {}};
    CHECK(one(*alone, task).pressure_pa == got[p].pressure_pa);
  }
}
