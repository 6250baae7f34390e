// An array as a device computes it, run on the host, against the reference.
#include <numeric>

#include "catch.h"
#include "synthesis/array_fixture.h"

using namespace ensonify;
using namespace ensonify::test;

// Protects the series in every mode, element by element: noise, volumes, shading, wide elements,
// wrong and dead ones, near echoes, and blocks of elements that are not full.
TEST_CASE("device: an array's series are the reference's") {
  const Steering steering = GENERATE(Steering::true_delay, Steering::phase);
  const Focus focus = GENERATE(Focus::none, Focus::dynamic);
  const int elements = GENERATE(1, 21, 48);
  Sonar sonar = line_array(elements, 7, 100, 2);
  sonar.array->steering = steering;
  sonar.array->focus = focus;
  sonar.array->shading.kind = Shading::hann;
  sonar.array->element_width_m = 0.6e-3;
  if (elements > 1) {
    sonar.array->response[5] = 0;
    sonar.array->response[7] = {1.1, 0.2};
  }
  if (elements == 21) sonar.array->spacing_m = 9e-3;
  const SynthesisSetup setup = setup_of(sonar);
  const ScattererList list = list_of(sonar, fan_echoes(sonar, 60, 0.1));
  const VolumeEcho water = volume_of(
      setup, [](int beam, int n) { return (n + beam) % 9 == 0 ? 1e-5 * (1 + n % 5) : 0.0; });
  for (const bool has_volumes : {false, true}) {
    PingTask task{&list, keys_of_ping(1), has_volumes ? 1e-3 : 0.0, {}, false};
    if (has_volumes) task.volumes = {&water, 1};
    task.wants_channels = true;
    const PingSeries got = one(*host_device(setup), task);
    const PingSeries expected = one(*make_reference_backend(setup), task);
    const double series = relative(got.pressure_pa, expected.pressure_pa);
    const double channels = relative(got.channels_pa, expected.channels_pa);
    CAPTURE(static_cast<int>(steering), static_cast<int>(focus), elements, has_volumes, series,
            channels);
    CHECK(series < 1e-5);
    CHECK(channels < 1e-5);
    CHECK(got.clean_power_pa2.empty());
  }
}

// Protects points so near that no group of elements shares their path, and echoes whose kernels
// reach across the ends of the period or lie behind it.
TEST_CASE("device: an array's echoes at the ends of the period are the reference's") {
  Sonar sonar = line_array(70, 3, 100, 1);
  const SynthesisSetup setup = setup_of(sonar);
  std::vector<Scatterer> items = {target_at(sonar, 20, 0, 0.04), target_at(sonar, -30, 10, 0.11),
                                  target_at(sonar, -10, 5, 0.6)};
  for (const double samples : {0.01, setup.record.transform - 1.5, setup.record.transform + 9.0}) {
    Scatterer s = target_at(sonar, 5 + samples / 10, 0, 0.3);
    s.delay_s = samples / sonar.bandwidth_hz;
    items.push_back(s);
  }
  const ScattererList list = list_of(sonar, items);
  PingTask task{&list, keys_of_ping(1), 0, {}, false};
  task.wants_channels = true;
  const PingSeries got = one(*host_device(setup), task);
  const PingSeries expected = one(*make_reference_backend(setup), task);
  CHECK(relative(got.channels_pa, expected.channels_pa) < 1e-5);
  CHECK(relative(got.pressure_pa, expected.pressure_pa) < 1e-5);
}

// Protects beams from nodes in every quarter of the record by itself, from samples that are sums of
// all elements over all lengths of stretches, with echoes as strong far as near.
TEST_CASE("device: an array's beams from nodes are the reference's near and far") {
  Sonar sonar = line_array(100, 5, 80, 12);
  sonar.array->steering = GENERATE(Steering::true_delay, Steering::phase);
  sonar.array->focus = GENERATE(Focus::none, Focus::dynamic);
  const SynthesisSetup setup = setup_of(sonar);
  REQUIRE(make_array_tables(setup).nodes.count > 0);
  std::vector<Scatterer> items = fan_echoes(sonar, 40, 0.1);
  for (std::size_t i = 0; i < items.size(); ++i) {
    items[i].gain = 1;
    items[i].delay_s = (0.2 + 0.3 * static_cast<double>(i)) / 750;
    items[i].received_path_m = static_cast<float>(items[i].delay_s * 750);
  }
  const ScattererList list = list_of(sonar, items);
  const PingTask task{&list, keys_of_ping(1), 0, {}, false};
  const PingSeries got = one(*host_device(setup), task);
  const PingSeries expected = one(*make_reference_backend(setup), task);
  const int samples = setup.record.samples;
  for (int quarter = 0; quarter < 4; ++quarter) {
    std::vector<std::complex<float>> part, exact;
    for (std::size_t i = 0; i < got.pressure_pa.size(); ++i) {
      if (static_cast<int>(i % samples) * 4 / samples != quarter) continue;
      part.push_back(got.pressure_pa[i]);
      exact.push_back(expected.pressure_pa[i]);
    }
    CAPTURE(quarter);
    CHECK(relative(part, exact) < 1e-5);
  }
}

// Protects noise to the edges of the band, where nothing filters it.
TEST_CASE("device: noise of an array is the reference's") {
  Sonar sonar = line_array(30, 5, 120, 1);
  sonar.array->response[3] = 0;
  const SynthesisSetup setup = setup_of(sonar);
  const ScattererList nothing = sorted_by_beam_and_delay({}, sonar.beam_count);
  const PingTask task{&nothing, keys_of_ping(1), 1e-3, {}, false};
  const PingSeries got = one(*host_device(setup), task);
  CHECK(relative(got.pressure_pa, one(*make_reference_backend(setup), task).pressure_pa) < 1e-5);
}

// Protects pulses that are not symmetric, and wide bands.
TEST_CASE("device: an array's pulses are the reference's") {
  for (const PulseShape shape : {PulseShape::flat, PulseShape::lfm, PulseShape::table}) {
    CAPTURE(static_cast<int>(shape));
    Sonar sonar = line_array(18, 5, 90, 1, 200e3);
    sonar.pulse = pulse_of(shape, sonar);
    const SynthesisSetup setup = setup_of(sonar);
    const ScattererList list = list_of(sonar, fan_echoes(sonar, 40, 0.05));
    const PingTask task{&list, keys_of_ping(2), 0, {}, false};
    const PingSeries got = one(*host_device(setup), task);
    CHECK(relative(got.pressure_pa, one(*make_reference_backend(setup), task).pressure_pa) < 1e-5);
  }
}

// Protects expected power. The pattern at a sample's range leaves out how an echo is spread by the
// ways across the array: that shows in lobes and is a few percent of the whole. The CPU leaves out
// the same; means are exact.
TEST_CASE("device: an array's expected power is the CPU's, and near the reference's", "[figure]") {
  Sonar sonar = line_array(64, 12, 60, 3);
  sonar.array->focus = GENERATE(Focus::none, Focus::dynamic);
  sonar.array->steering = GENERATE(Steering::true_delay, Steering::phase);
  sonar.array->element_width_m = 0.6e-3;
  sonar.array->response[9] = 0;
  const SynthesisSetup setup = setup_of(sonar);
  ScattererList list = list_of(sonar, fan_echoes(sonar, 40, 0.6));
  const VolumeEcho water =
      volume_of(setup, [](int beam, int n) { return beam == 5 && n % 40 == 20 ? 1e-9 * n : 0.0; });
  const PingTask whole{&list, keys_of_ping(1), 0, {&water, 1}};
  const auto got = one(*host_device(setup), whole).clean_power_pa2;
  CHECK(worst_db(got, one(*make_cpu_backend(setup), whole).clean_power_pa2) < 0.002);
  // So near that kernels reach across the record's start.
  Scatterer at_once = target_at(sonar, 10, 0, 0.5);
  at_once.delay_s = 1e-6;
  at_once.standard_deviation = 1;
  at_once.mean = 0;
  const ScattererList close = list_of(sonar, {at_once});
  const VolumeEcho first = volume_of(setup, [](int, int n) { return n == 0 ? 1e-4 : 0.0; });
  for (const bool has_volume : {false, true}) {
    PingTask task{has_volume ? &list : &close, keys_of_ping(1), 0, {}};
    if (has_volume) task.volumes = {&first, 1};
    const double error = worst_db(one(*host_device(setup), task).clean_power_pa2,
                                  one(*make_cpu_backend(setup), task).clean_power_pa2);
    CAPTURE(has_volume);
    CHECK(error < 0.002);
  }
  const auto exact = one(*make_reference_backend(setup), whole).clean_power_pa2;
  CHECK(relative(got, exact) < 0.05);
  CHECK(std::accumulate(got.begin(), got.end(), 0.0) ==
        Approx(std::accumulate(exact.begin(), exact.end(), 0.0)).epsilon(0.02));
  for (Scatterer& s : list.items) s.standard_deviation = 0;
  const PingTask means{&list, keys_of_ping(1), 0, {}};
  CHECK(worst_db(one(*host_device(setup), means).clean_power_pa2,
                 one(*make_reference_backend(setup), means).clean_power_pa2) < 0.001);
}

// Protects patterns that the device keeps for later batches, and those for which it has no room.
TEST_CASE("device: an array's expected power is the same with patterns kept or made anew") {
  Sonar sonar = line_array(20, 18, 60, 1);
  const SynthesisSetup setup = setup_of(sonar);
  const ScattererList list = list_of(sonar, fan_echoes(sonar, 40, 0.1));
  const PingTask task{&list, keys_of_ping(1), 0, {}};
  PingBatch batch;
  fill_batch(setup, {&task, 1}, Workers(1), batch);
  const ArrayTables tables = make_array_tables(setup);
  HostQueue queue;
  REQUIRE(make_array_power_tables(setup).blocks.size() > 1);
  DeviceBuffer<EchoRecord, HostQueue> echoes(queue);
  DeviceBuffer<double, HostQueue> y_m(queue), cosine(queue);
  echoes.put(batch.echoes);
  y_m.put(tables.y_m);
  cosine.put(tables.beam_cosine);
  ScattererList diffuse = list;
  for (Scatterer& s : diffuse.items) s.mean = 0;
  const PingTask without_means{&diffuse, keys_of_ping(1), 0, {}};
  const SampleArray<float> exact = one(*host_device(setup), without_means).clean_power_pa2;
  for (const std::uint64_t kept_bytes : {std::uint64_t{0}, kKeptPatternBytes}) {
    ArrayPowerProgram<HostQueue> power(queue, setup, kept_bytes);
    for (int batches = 0; batches < 2; ++batches) {
      power.run(batch, {echoes.data(), nullptr, y_m.data(), cosine.data(), nullptr});
      SampleArray<float> got(exact.size());
      queue.download(got.data(), power.powers(), got.size() * sizeof(float));
      queue.wait();
      CAPTURE(kept_bytes, batches);
      CHECK(got == exact);
    }
  }
}

// Protects against pings that see each other, and batches that show: each has its own keys, lists
// and wishes.
TEST_CASE("device: an array's batch is its pings one by one") {
  Sonar sonar = line_array(34, 6, 60, 1);
  const SynthesisSetup setup = setup_of(sonar);
  const VolumeEcho volume = volume_of(setup, [](int, int n) { return n == 7 ? 1e-6 : 0.0; });
  std::vector<ScattererList> lists;
  std::vector<PingTask> tasks;
  for (int p = 0; p < 5; ++p) {
    lists.push_back(list_of(sonar, fan_echoes(sonar, p == 3 ? 0 : 9 + 20 * p, 0.1, p)));
  }
  for (Scatterer& s : lists[2].items) s.mean = 0;
  for (int p = 0; p < 5; ++p) {
    tasks.push_back({&lists[p], keys_of_ping(p), p == 1 ? 1e-3 : 0, {}, p != 2, p == 0 || p == 4});
    if (p == 4) tasks[p].volumes = {&volume, 1};
  }
  std::vector<PingSeries> together(5), few(5);
  host_device(setup)->synthesize(tasks, together, Workers(2));
  host_device(setup, new HostQueue(std::size_t{1} << 40, 1, 1))->synthesize(tasks, few, Workers(1));
  const auto again = host_device(setup);
  for (int p = 0; p < 5; ++p) {
    CAPTURE(p);
    const PingSeries alone = one(*again, tasks[p]);
    CHECK(together[p].pressure_pa == alone.pressure_pa);
    CHECK(together[p].clean_power_pa2 == alone.clean_power_pa2);
    CHECK(together[p].channels_pa == alone.channels_pa);
    CHECK(few[p].pressure_pa == alone.pressure_pa);
    CHECK(few[p].clean_power_pa2 == alone.clean_power_pa2);
    CHECK(few[p].channels_pa == alone.channels_pa);
  }
  CHECK(together[1].channels_pa.empty());
  CHECK(together[2].clean_power_pa2.empty());
  CHECK(together[4].channels_pa.size() == std::size_t(34) * setup.record.samples);
}

// Protects the estimate by which batches are cut to the device's memory: what a ping takes beside
// the tables is not more than was said.
TEST_CASE("device: an array's pings take what they announce") {
  Sonar sonar = line_array(GENERATE(24, 40), 16, 60, 2);
  const SynthesisSetup setup = setup_of(sonar);
  const ScattererList list = list_of(sonar, fan_echoes(sonar, 500, 0.3));
  const VolumeEcho volume = volume_of(setup, [](int, int n) { return n == 7 ? 1e-6 : 0.0; });
  PingTask task{&list, keys_of_ping(0), 1e-3, {}};
  task.wants_channels = true;
  for (const bool has_volumes : {false, true}) {
    CAPTURE(has_volumes);
    if (has_volumes) task.volumes = {&volume, 1};
    HostQueue probe;
    const ArrayProgram<HostQueue> program(probe, setup);
    const std::uint64_t announced = program.ping_bytes(list.size(), has_volumes);
    const std::vector<PingTask> tasks(4, task);
    auto* queue = new HostQueue();
    const auto backend = host_device(setup, queue);
    std::vector<PingSeries> series(4);
    backend->synthesize(std::span(tasks).first(1), std::span(series).first(1), Workers(1));
    const std::size_t first = queue->peak;
    auto* queue_of_four = new HostQueue();
    const auto backend_of_four = host_device(setup, queue_of_four);
    backend_of_four->synthesize(tasks, series, Workers(1));
    const double each = static_cast<double>(queue_of_four->peak - first) / 3;
    CHECK(each <= 1.01 * announced);
    CHECK(each >= 0.8 * announced);
  }
}
