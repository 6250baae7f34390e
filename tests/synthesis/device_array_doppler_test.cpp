// Echoes that come back shifted to an array, by the functors of a device run on the host.
#include "catch.h"
#include "synthesis/array_fixture.h"
#include "synthesis/v8.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

ScattererList shifted(const Sonar& sonar, std::vector<Scatterer> items, double most) {
  return list_of(sonar, with_shifts(std::move(items), most));
}

template <class Values>
double error_of(const Values& obtained, const Values& expected, int samples) {
  REQUIRE(obtained.size() == expected.size());
  return compare(widened(obtained), widened(expected), samples, 0, samples).ratio();
}

// What beams and elements hear.
void require_reference(const SynthesisSetup& setup, PingTask task) {
  task.wants_clean = false;
  task.wants_channels = true;
  const PingSeries got = one(*host_device(setup), task);
  const PingSeries expected = one(*make_reference_backend(setup), task);
  const double series = error_of(got.pressure_pa, expected.pressure_pa, setup.record.samples);
  const double channels = error_of(got.channels_pa, expected.channels_pa, setup.record.samples);
  CAPTURE(series, channels);
  CHECK(series < 1e-5);
  CHECK(channels < 1e-5);
}

// Pings with shifts (1, 3, 4, 6), at rest (0, 2) and with nothing in them (5), with different
// wishes.
struct ArrayBatch {
  std::vector<ScattererList> lists;
  std::vector<PingTask> tasks;
};

ArrayBatch mixed_batch(const Sonar& sonar, std::span<const VolumeEcho> volumes) {
  ArrayBatch batch;
  const double most[] = {0, 3e-3, 0, 1e-3, 5e-3, 0, 5e-3};
  for (int p = 0; p < 7; ++p) {
    const std::vector<Scatterer> echoes = fan_echoes(sonar, p == 5 ? 0 : 12 * p + 10, 0.1, p);
    batch.lists.push_back(shifted(sonar, echoes, most[p]));
  }
  for (int p = 0; p < 7; ++p) {
    const double noise_pa2 = p % 2 == 0 ? 1e-3 : 0;
    batch.tasks.push_back(
        {&batch.lists[p], keys_of_ping(p), noise_pa2, {}, p != 3, p == 0 || p == 4});
    if (p == 2 || p == 6) batch.tasks[p].volumes = volumes;
  }
  return batch;
}

}  // namespace

// Protects the series in every mode, element by element: rising and falling shifts, echoes at rest
// between, volumes and noise beside, wrong and dead elements, and blocks of elements that are not
// full.
TEST_CASE("device: shifted echoes at an array are the reference's") {
  const Steering steering = GENERATE(Steering::true_delay, Steering::phase);
  const Focus focus = GENERATE(Focus::none, Focus::dynamic);
  const int elements = GENERATE(1, 21);
  CAPTURE(static_cast<int>(steering), static_cast<int>(focus), elements);
  Sonar sonar = line_array(elements, 7, 100, 2);
  sonar.array->steering = steering;
  sonar.array->focus = focus;
  sonar.array->element_width_m = 0.6e-3;
  if (elements > 1) {
    sonar.array->response[5] = 0;
    sonar.array->response[7] = {1.1, 0.2};
    sonar.array->spacing_m = 9e-3;
  }
  const SynthesisSetup setup = with_shifts(sonar, 4e-3);
  const ScattererList list = shifted(sonar, fan_echoes(sonar, 60, 0.1), 4e-3);
  const VolumeEcho water = volume_of(
      setup, [](int beam, int n) { return (n + beam) % 9 == 0 ? 1e-5 * (1 + n % 5) : 0.0; });
  require_reference(setup, {&list, keys_of_ping(1), 0, {}});
  require_reference(setup, {&list, keys_of_ping(1), 1e-3, {&water, 1}});
}

// Protects pulses whose spectrum is narrow, lopsided or fills the band.
TEST_CASE("device: an array's shifted pulses are the reference's") {
  for (const PulseShape shape : {PulseShape::flat, PulseShape::lfm, PulseShape::cw}) {
    CAPTURE(static_cast<int>(shape));
    Sonar sonar = line_array(18, 5, 90, 3);
    sonar.pulse = pulse_of(shape, sonar);
    if (shape == PulseShape::cw) sonar.pulse.duration_s = 3e-3;
    const ScattererList list = shifted(sonar, fan_echoes(sonar, 40, 0.05), 1.2e-2);
    require_reference(with_shifts(sonar, 1.2e-2), {&list, keys_of_ping(2), 0, {}});
  }
}

// Protects echoes beyond the announced shifts, or beyond any that is heard, and one alone.
TEST_CASE("device: an array's shifts that none announced are the reference's") {
  const Sonar sonar = line_array(18, 5, 90, 2);
  ScattererList list = shifted(sonar, fan_echoes(sonar, 40, 0.2), 8e-3);
  for (std::size_t i = 0; i < list.size(); i += 17) list.items[i].doppler = -0.06f;
  require_reference(setup_of(sonar), {&list, keys_of_ping(4), 1e-2, {}});
  Scatterer alone = target_at(sonar, 20, 5, 1);
  alone.doppler = -7e-3f;
  const ScattererList single = list_of(sonar, {alone});
  require_reference(setup_of(sonar), {&single, keys_of_ping(4), 0, {}});
}

// Protects expected power: means with their shifts, exactly, and the rest without, as the CPU has
// it.
TEST_CASE("device: an array's expected power has the shifts of means") {
  Sonar sonar = line_array(20, 9, 60, 2);
  sonar.array->focus = GENERATE(Focus::none, Focus::dynamic);
  const SynthesisSetup setup = with_shifts(sonar, 1e-2);
  ScattererList list = shifted(sonar, fan_echoes(sonar, 40, 0.6), 1e-2);
  const VolumeEcho water =
      volume_of(setup, [](int beam, int n) { return beam == 5 && n % 20 == 10 ? 1e-9 * n : 0.0; });
  const PingTask whole{&list, keys_of_ping(1), 0, {&water, 1}};
  const auto got = one(*host_device(setup), whole).clean_power_pa2;
  CHECK(worst_db(got, one(*make_cpu_backend(setup), whole).clean_power_pa2) < 0.002);
  for (Scatterer& s : list.items) {
    s.standard_deviation = 0;
    s.mean = {0.01f, 0.004f};
  }
  const PingTask means{&list, keys_of_ping(1), 0, {}};
  const auto exact = one(*make_reference_backend(setup), means).clean_power_pa2;
  const auto of_means = one(*host_device(setup), means).clean_power_pa2;
  CHECK(error_of(of_means, exact, setup.record.samples) < 2e-5);
  CHECK(worst_db(of_means, exact) < 0.001);
}

// Protects echoes at rest: what else a batch or a setup has leaves no bit of them changed.
TEST_CASE("device: an array's ping at rest is the same bytes among shifted ones") {
  const Sonar sonar = line_array(20, 6, 60, 1);
  const SynthesisSetup setup = with_shifts(sonar, 5e-3);
  const VolumeEcho volume = volume_of(setup, [](int, int n) { return n == 7 ? 1e-6 : 0.0; });
  const ArrayBatch batch = mixed_batch(sonar, {&volume, 1});
  check_same_at_rest(setup, batch.tasks);
}

// Protects reproducibility of the shifted ones: nodes that other pings need, threads, the order of
// batches and their size leave no trace.
TEST_CASE("device: an array's shifted pings do not hang on batches") {
  const Sonar sonar = line_array(20, 6, 60, 1);
  const SynthesisSetup setup = with_shifts(sonar, 5e-3);
  const VolumeEcho volume = volume_of(setup, [](int, int n) { return n == 7 ? 1e-6 : 0.0; });
  const ArrayBatch batch = mixed_batch(sonar, {&volume, 1});
  check_independent_of_batches(setup, batch.tasks);
}

// Protects pings that fit from what earlier ones of another kind have left behind.
TEST_CASE("device: an array's ping fits that fits alone") {
  const Sonar sonar = line_array(20, 6, 60, 1);
  const SynthesisSetup setup = with_shifts(sonar, 5e-3);
  const ScattererList many = shifted(sonar, fan_echoes(sonar, 500, 0.1), 0);
  const ScattererList few = shifted(sonar, fan_echoes(sonar, 40, 0.1), 5e-3);
  const PingTask first{&many, keys_of_ping(0), 0, {}, false};
  const PingTask second{&few, keys_of_ping(1), 1e-3, {}, true, true};
  std::size_t peak = 0;
  for (const PingTask& task : {first, second}) {
    auto* queue = new HostQueue();
    const auto backend = host_device(setup, queue);
    one(*backend, task);
    peak = std::max(peak, queue->peak);
  }
  auto* plenty = new HostQueue();
  const auto unhindered = host_device(setup, plenty);
  one(*unhindered, first);
  const PingSeries expected = one(*unhindered, second);
  REQUIRE(plenty->peak > 1.1 * peak);
  const auto tight = host_device(setup, new HostQueue(peak));
  one(*tight, first);
  CHECK(same_bytes(one(*tight, second), expected));
}

// Protects the estimate by which batches are cut to the device's memory.
TEST_CASE("device: an array's shifted pings take what they announce") {
  const Sonar sonar = line_array(24, 16, 60, 2);
  const SynthesisSetup setup = with_shifts(sonar, 5e-3);
  ScattererList list = list_of(sonar, fan_echoes(sonar, 500, 0.3));
  for (std::size_t i = 0; i < list.size(); ++i) list.items[i].doppler = i % 2 == 0 ? 5e-3f : -4e-3f;
  PingTask task{&list, keys_of_ping(0), 1e-3, {}};
  task.wants_channels = true;
  HostQueue probe;
  const ArrayProgram<HostQueue> program(probe, setup);
  const std::uint64_t announced = program.ping_bytes(list.size(), false);
  const std::vector<PingTask> tasks(4, task);
  std::vector<PingSeries> series(4);
  std::size_t peak[2] = {};
  for (const int more : {0, 1}) {
    auto* queue = new HostQueue();
    const auto backend = host_device(setup, queue);
    backend->synthesize(std::span(tasks).first(1 + 3 * more), std::span(series).first(1 + 3 * more),
                        Workers(1));
    peak[more] = queue->peak;
  }
  const double each = static_cast<double>(peak[1] - peak[0]) / 3;
  CAPTURE(each, announced);
  CHECK(each <= 1.01 * announced);
  CHECK(each >= 0.8 * announced);
}
