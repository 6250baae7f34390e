// Echoes that come back shifted, by the functors of a device run on the host.
#include "synthesis/cpu/doppler_nodes.h"
#include "synthesis/cuda/doppler_echoes.h"
#include "synthesis/device_fixture.h"
#include "synthesis/v8.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

ScattererList shifted(std::vector<Scatterer> scatterers, double most, int beams) {
  return sorted_by_beam_and_delay(with_shifts(std::move(scatterers), most), beams);
}

// Of the whole record and, tenfold, of each tenth that holds something.
void require_plain_reference(const SynthesisSetup& setup, const PingTask& task) {
  const int samples = setup.record.samples;
  const PingSeries got = one(*host_device(setup), task);
  const PingSeries expected = one(*make_reference_backend(setup), task);
  require_within(widened(got.pressure_pa), widened(expected.pressure_pa), samples, 2e-5, 2e-4, 1e-4,
                 5);
  require_within(widened(got.clean_power_pa2), widened(expected.clean_power_pa2), samples, 2e-5,
                 1e-3, 1e-6, 5);
}

// Lists of a batch: some of shifted echoes, one of none, one with nothing in it.
struct Batch {
  std::vector<ScattererList> lists;
  std::vector<PingTask> tasks;
};

Batch mixed_batch(const Sonar& sonar) {
  Batch batch;
  const double most[] = {0, 3e-3, 0, 1e-3, 5e-3, 0, 5e-3};
  for (int p = 0; p < 7; ++p) {
    const int count = p == 5 ? 0 : 30 * p + 40;
    batch.lists.push_back(
        most[p] == 0
            ? sorted_by_beam_and_delay(random_scatterers(sonar, count, 0.2, p), sonar.beam_count)
            : shifted(random_scatterers(sonar, count, 0.2, p), most[p], sonar.beam_count));
  }
  for (int p = 0; p < 7; ++p) {
    batch.tasks.push_back({&batch.lists[p], keys_of_ping(p), p % 2 == 0 ? 1e-9 : 0, {}, p != 3});
  }
  return batch;
}

}  // namespace

// Protects the series and its expected power (means with shifts, the rest without) for every pulse
// and window, with echoes at rest between.
TEST_CASE("device: shifted echoes are the reference's") {
  for (const PulseShape shape :
       {PulseShape::gaussian, PulseShape::flat, PulseShape::lfm, PulseShape::cw}) {
    for (const Window window : {Window::none, Window::hamming}) {
      CAPTURE(static_cast<int>(shape), static_cast<int>(window));
      Sonar sonar = p900(9, 9, 4);
      sonar.pulse = pulse_of(shape, sonar);
      sonar.window = window;
      const ScattererList list = shifted(random_scatterers(sonar, 400, 0.3, 5), 4e-3, 9);
      require_plain_reference(with_shifts(sonar, 4e-3), {&list, keys_of_ping(2), 0, {}});
    }
  }
}

// Protects narrow spectra: the shift takes all of a long burst to another place in the band, up to
// its edge at 1.6e-2.
TEST_CASE("device: a shifted burst of 10 ms is the reference's") {
  const double most = GENERATE(1e-3, 1.5e-2);
  Sonar sonar = p900(3, 3, 12);
  sonar.pulse.shape = PulseShape::cw;
  sonar.pulse.duration_s = 10e-3;
  const ScattererList list = shifted(random_scatterers(sonar, 60, 1, 26), most, 3);
  require_plain_reference(with_shifts(sonar, most), {&list, keys_of_ping(1), 0, {}});
}

// Protects means alone, whose power is all from the shifted series, and one echo at the band's
// edge.
TEST_CASE("device: shifted means are the reference's") {
  Sonar sonar = p900(4, 4, 6);
  sonar.pulse.shape = PulseShape::cw;
  sonar.pulse.duration_s = 4e-3;
  const double doppler = GENERATE(-1.3e-2, 2e-4, 1.2e-2);
  std::vector<Scatterer> targets;
  for (int i = 0; i < 8; ++i) {
    targets.push_back(point_target(sonar, i % 4, 0.6 + 0.65 * i, -20));
    targets.back().doppler = static_cast<float>(doppler);
  }
  const ScattererList list = sorted_by_beam_and_delay(targets, 4);
  require_plain_reference(with_shifts(sonar, 1.3e-2), {&list, keys_of_ping(1), 0, {}});
}

// Protects volumes, noise and echoes beyond the announced shifts, or beyond any that is heard.
TEST_CASE("device: shifts that none announced are the reference's, with volumes and noise") {
  const Sonar sonar = p900(9, 9, 3);
  const SynthesisSetup setup = setup_of(sonar);
  ScattererList list = shifted(random_scatterers(sonar, 200, 0.3, 6), 8e-3, 9);
  for (std::size_t i = 0; i < list.size(); i += 17) list.items[i].doppler = -0.06f;
  const std::vector<VolumeEcho> volumes = {volume_of(
      setup, [](int beam, int n) { return (beam + n) % 3 == 0 ? 1e-7 * (1 + n % 5) : 0.0; })};
  require_plain_reference(setup, {&list, keys_of_ping(4), 1e-2, volumes});
}

// Protects echoes at rest: what else a batch or a setup has leaves no bit of them changed.
TEST_CASE("device: a ping at rest is the same bytes among shifted ones") {
  const Sonar sonar = p900(11, 11, 2);
  const Batch batch = mixed_batch(sonar);
  check_same_at_rest(with_shifts(sonar, 5e-3), batch.tasks);
}

// Protects reproducibility of the shifted ones: nodes that other pings need, threads, the order of
// batches and their size leave no trace.
TEST_CASE("device: shifted pings do not hang on batches, threads or what came before") {
  const Sonar sonar = p900(11, 11, 2);
  const SynthesisSetup setup = with_shifts(sonar, 5e-3);
  const Batch batch = mixed_batch(sonar);
  check_independent_of_batches(setup, batch.tasks);
}

// Protects the arithmetic that is written again for a device.
TEST_CASE("device: what a shift gives to nodes is weights_at") {
  for (const DopplerNodes nodes : {DopplerNodes{4, 2e-3}, DopplerNodes{24, 7.3e-4}}) {
    std::vector<double> place;
    for (int q = 0; q <= nodes.degree; ++q) place.push_back(node_doppler(nodes, q) / nodes.width);
    const DeviceNodes on_device{place.data(), nodes.degree, nodes.width};
    for (const double eta : {0.0, 1e-9, 7e-4, 2e-3, 3.1e-3, -1e-9, -2e-3, -5.5e-3, 0.03}) {
      const DopplerWeights expected = weights_at(nodes, eta);
      const NodePlace obtained = node_place(on_device, eta);
      REQUIRE(obtained.first == expected.first_node);
      REQUIRE(obtained.step == expected.step);
      for (int q = -2; q <= nodes.degree + 2; ++q) {
        const bool inside = q >= 0 && q <= nodes.degree;
        const double weight = inside ? expected.value[q] : 0.0;
        CHECK(node_weight(on_device, obtained, obtained.first + q * obtained.step) ==
              Approx(weight).margin(1e-9));
      }
    }
  }
}
