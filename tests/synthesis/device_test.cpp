// What a device computes, run on the host: the functors that CUDA launches, against the reference.
#include "synthesis/device_fixture.h"
#include "synthesis/v8.h"

using namespace ensonify;
using namespace ensonify::test;

// Protects the series and its expected power: pulses, mixings, odd numbers of beams.
TEST_CASE("device: a ping is the reference's") {
  for (const PulseShape shape : {PulseShape::gaussian, PulseShape::flat, PulseShape::lfm,
                                 PulseShape::cw, PulseShape::table}) {
    for (const int beams : {1, 17, 40}) {
      CAPTURE(static_cast<int>(shape), beams);
      Sonar sonar = p900(beams, beams, 4);
      sonar.pulse = pulse_of(shape, sonar);
      if (beams == 17) sonar.normalization = Normalization::mean_square;
      const SynthesisSetup setup = setup_of(sonar);
      const ScattererList list =
          sorted_by_beam_and_delay(random_scatterers(sonar, 900, 0.01, 5), beams);
      PingTask task{&list, keys_of_ping(2), 3e-3, {}};
      const PingSeries got = one(*host_device(setup), task);
      const PingSeries expected = one(*make_reference_backend(setup), task);
      CHECK(relative(got.pressure_pa, expected.pressure_pa) < 1e-5);
      CHECK(relative(got.clean_power_pa2, expected.clean_power_pa2) < 1e-5);
    }
  }
}

// Protects the way from cells over nodes to beams, of echoes at rest and with Doppler, volumes, and
// expected power, where nodes are fewer than beams.
TEST_CASE("device: dense beams are sums of few nodes") {
  const Sonar sonar = p900(100, 17, 3);
  const SynthesisSetup setup = with_shifts(sonar, 2e-4);
  const BeamTables tables = make_beam_tables(setup);
  CHECK(tables.mixing.nodes < 60);
  CHECK(tables.power_mixing.nodes < 80);
  const ScattererList list =
      sorted_by_beam_and_delay(with_shifts(random_scatterers(sonar, 2000, 0.1, 7), 2e-4), 100);
  const VolumeEcho volume = volume_of(
      setup, [](int beam, int n) { return (beam + n) % 3 == 0 ? 1e-7 * (1 + n % 5) : 0.0; });
  const PingTask task{&list, keys_of_ping(3), 1e-3, {&volume, 1}};
  const PingSeries got = one(*host_device(setup), task);
  const PingSeries expected = one(*make_reference_backend(setup), task);
  CHECK(relative(got.pressure_pa, expected.pressure_pa) < 1e-5);
  CHECK(relative(got.clean_power_pa2, expected.clean_power_pa2) < 1e-5);
}

// Protects the threads of a grid's row: every point once, echoes before, over and after both ends
// of the period, gaps longer than a kernel, and none at all.
TEST_CASE("device: the threads of a row make the plain sums") {
  constexpr int kPoints = 100, kWidth = 7, kDegree = 2;
  std::vector<float> coefficient;
  for (int i = 0; i < (kDegree + 1) * kWidth; ++i) {
    coefficient.push_back(static_cast<float>(uniform(5, 0, i, 0)));
  }
  const DeviceKernel kernel{coefficient.data(), kWidth, kDegree, kPoints};
  std::vector<std::int32_t> first = {-7, -6, -2, -2, 0, 1, 31, 32, 33, 33, 64, 93, 95, 98, 99, 100};
  std::vector<Complex32> value;
  std::vector<float> offset;
  for (std::size_t e = 0; e < first.size(); ++e) {
    value.push_back({static_cast<float>(uniform(6, 0, e, 0)), static_cast<float>(e)});
    offset.push_back(static_cast<float>(2 * uniform(7, 0, e, 0) - 1));
  }
  const PlacedEchoes echoes{value.data(), offset.data(), first.data()};
  for (const std::uint32_t end : {0u, 1u, 9u, 16u}) {
    CAPTURE(end);
    std::vector<Complex32> expected(kPoints, {0, 0}), got(kPoints, {0, 0});
    std::vector<int> writes(kPoints);
    for (std::uint32_t e = 0; e < end; ++e) {
      for (int tap = 0; tap < kWidth; ++tap) {
        const int point = (first[e] + tap + 2 * kPoints) % kPoints;
        expected[point] += kernel_at(kernel, tap, offset[e]) * value[e];
      }
    }
    for (int lane = kGridLanes - 1; lane >= 0; --lane) {
      sum_in_lane(echoes, kernel, 0, end, lane, [&](std::int32_t point, Complex32 sum) {
        got[point] = sum;
        ++writes[point];
      });
    }
    CHECK(writes == std::vector<int>(kPoints, 1));
    for (int p = 0; p < kPoints; ++p) {
      CAPTURE(p);
      CHECK(std::abs(got[p].re - expected[p].re) < 1e-5);
      CHECK(std::abs(got[p].im - expected[p].im) < 1e-4);
    }
  }
}

TEST_CASE("device: volumes and noise are the reference's") {
  const Sonar sonar = p900(9, 9, 3);
  const SynthesisSetup setup = setup_of(sonar);
  const ScattererList list = sorted_by_beam_and_delay(random_scatterers(sonar, 50, 0.5, 6), 9);
  const VolumeEcho volume = volume_of(
      setup, [](int beam, int n) { return (beam + n) % 3 == 0 ? 1e-7 * (1 + n % 5) : 0.0; });
  const VolumeEcho more = volume_of(setup, [](int beam, int) { return beam == 8 ? 1e-7 : 0.0; });
  const std::vector<VolumeEcho> volumes{volume, more};
  const PingTask task{&list, keys_of_ping(4), 1e-2, volumes};
  const PingSeries got = one(*host_device(setup), task);
  const PingSeries expected = one(*make_reference_backend(setup), task);
  CHECK(relative(got.pressure_pa, expected.pressure_pa) < 1e-5);
  CHECK(relative(got.clean_power_pa2, expected.clean_power_pa2) < 1e-5);
}

// Protects against pings that see each other: each has its own keys, lists and wishes.
TEST_CASE("device: a batch is its pings one by one") {
  const Sonar sonar = p900(11, 11, 2);
  const SynthesisSetup setup = setup_of(sonar);
  std::vector<ScattererList> lists;
  std::vector<PingTask> tasks;
  for (int p = 0; p < 5; ++p) {
    lists.push_back(
        sorted_by_beam_and_delay(random_scatterers(sonar, p == 3 ? 0 : 40 * p + 9, 0.2, p), 11));
  }
  const VolumeEcho volume = volume_of(setup, [](int, int n) { return n == 7 ? 1e-6 : 0.0; });
  for (int p = 0; p < 5; ++p) {
    tasks.push_back({&lists[p], keys_of_ping(p), p == 1 ? 1e-3 : 0, {}, p != 2});
    if (p == 4) tasks[p].volumes = {&volume, 1};
  }
  const auto backend = host_device(setup);
  std::vector<PingSeries> together(5);
  backend->synthesize(tasks, together, Workers(2));
  for (int p = 0; p < 5; ++p) {
    CAPTURE(p);
    const PingSeries alone = one(*host_device(setup), tasks[p]);
    CHECK(together[p].pressure_pa == alone.pressure_pa);
    CHECK(together[p].clean_power_pa2 == alone.clean_power_pa2);
  }
  CHECK(together[2].clean_power_pa2.empty());
}

// Protects reproducibility: threads, earlier pings and the size of batches leave no trace.
TEST_CASE("device: results do not hang on batches, threads or what came before") {
  const Sonar sonar = p900(8, 8, 2);
  const SynthesisSetup setup = setup_of(sonar);
  std::vector<ScattererList> lists;
  std::vector<PingTask> tasks;
  for (int p = 0; p < 6; ++p) {
    lists.push_back(sorted_by_beam_and_delay(random_scatterers(sonar, 60, 0.2, p), 8));
  }
  for (int p = 0; p < 6; ++p) tasks.push_back({&lists[p], keys_of_ping(p), 1e-3, {}});
  std::vector<PingSeries> all(6), few(6), tight(6);
  host_device(setup)->synthesize(tasks, all, Workers(2));
  auto* small = new HostQueue(std::size_t{1} << 40, 1, 1);
  host_device(setup, small)->synthesize(tasks, few, Workers(1));
  // Says that it has plenty, and fails: batches shrink.
  auto* measured = new HostQueue();
  const auto alone = host_device(setup, measured);
  alone->synthesize({&tasks[0], 1}, {&few[0], 1}, Workers(1));
  auto* liar = new HostQueue(2 * measured->peak);
  const auto shrinking = host_device(setup, liar);
  shrinking->synthesize(tasks, tight, Workers(2));
  CHECK(liar->launches > 2 * measured->launches);
  for (int p = 0; p < 6; ++p) {
    CHECK(few[p].pressure_pa == all[p].pressure_pa);
    CHECK(tight[p].pressure_pa == all[p].pressure_pa);
    CHECK(tight[p].clean_power_pa2 == all[p].clean_power_pa2);
  }
}

// Protects callers that wait for the same device: each gets its own results.
TEST_CASE("device: pings of many threads at once are their own") {
  const Sonar sonar = p900(8, 8, 2);
  const SynthesisSetup setup = setup_of(sonar);
  constexpr int kPings = 24;
  std::vector<ScattererList> lists;
  for (int p = 0; p < kPings; ++p) {
    lists.push_back(sorted_by_beam_and_delay(random_scatterers(sonar, 60, 0.2, p), 8));
  }
  const auto backend = host_device(setup);
  std::vector<PingSeries> got(kPings);
  Workers(8).for_each(kPings, [&](std::size_t p) {
    const PingTask task{&lists[p], keys_of_ping(static_cast<std::uint32_t>(p)), 1e-3, {}};
    backend->synthesize({&task, 1}, {&got[p], 1}, Workers(1));
  });
  for (int p = 0; p < kPings; ++p) {
    const PingTask task{&lists[p], keys_of_ping(p), 1e-3, {}};
    CHECK(one(*host_device(setup), task).pressure_pa == got[p].pressure_pa);
  }
}

// Protects the callers that did not fail: a failure is told to all whose pings it was.
TEST_CASE("device: a ping that does not fit by itself is out of memory") {
  const Sonar sonar = p900(8, 8, 2);
  const SynthesisSetup setup = setup_of(sonar);
  const ScattererList list = sorted_by_beam_and_delay(random_scatterers(sonar, 60, 0.2, 1), 8);
  const PingTask task{&list, keys_of_ping(0), 0, {}};
  PingSeries series;
  auto* measured = new HostQueue();
  const auto whole = host_device(setup, measured);
  const std::size_t tables = measured->peak;
  whole->synthesize({&task, 1}, {&series, 1}, Workers(1));
  const auto backend = host_device(setup, new HostQueue((tables + measured->peak) / 2));
  CHECK_THROWS_AS(backend->synthesize({&task, 1}, {&series, 1}, Workers(1)), DeviceFailure);
}
