// The CPU backend's array against sums of its own: the definition in synthesis/beamforming.h,
// element by element in the frequency domain.
#include <cmath>

#include "catch.h"
#include "synthesis/array_fixture.h"
#include "synthesis/draw.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

using Complex = std::complex<double>;

struct Judged {
  double relative = 0, worst_tenth = 0;
};

// Relative L2, and of each tenth of the record against its own norm (those under 1e-6 left out).
template <class Values>
Judged judge(const std::vector<Complex>& exact, const Values& values, int rows) {
  const std::size_t samples = exact.size() / rows;
  double wrong[10] = {}, norm[10] = {}, all_wrong = 0, all = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    const std::size_t tenth = i % samples * 10 / samples;
    const double e = std::norm(Complex(values[i]) - exact[i]);
    wrong[tenth] += e;
    norm[tenth] += std::norm(exact[i]);
    all_wrong += e;
    all += std::norm(exact[i]);
  }
  Judged result{std::sqrt(all_wrong / all), 0};
  for (int t = 0; t < 10; ++t) {
    if (norm[t] < 1e-12 * all) continue;
    result.worst_tenth = std::max(result.worst_tenth, std::sqrt(wrong[t] / norm[t]));
  }
  return result;
}

// Chosen beams of a ping, in double precision.
class ExactArray {
 public:
  ExactArray(const SynthesisSetup& setup, const PingTask& task)
      : setup_(setup), geometry_(make_array_geometry(setup.sonar)), bins_(setup.record.transform) {
    const int elements = setup.sonar.array->elements;
    spectra_.resize(elements);
    const std::vector<Complex> pulse = pulse_spectrum(setup.sonar, bins_);
    Workers(2).for_each(elements, [&](std::size_t n) {
      spectra_[n].resize(bins_);
      for (const Scatterer& s : task.scatterers->items) {
        add(n, pulse, apparent_point_m(s),
            unit_vector(s.arrival.azimuth_rad, s.arrival.elevation_rad).y, s.delay_s, true,
            Complex(draw_amplitude(s, task.keys)) * double(s.gain));
      }
      add_cells(n, pulse, task);
      if (task.noise_power_pa2 > 0 && geometry_.response[n] != 0.0) add_noise(n, task);
    });
  }

  std::vector<Complex> channel(int n) const { return record(spectra_[n]); }

  std::vector<Complex> beam(int j) const {
    const ArrayReceiver& array = *setup_.sonar.array;
    const double azimuth = beam_azimuth_rad(setup_.sonar, j), c = setup_.water.sound_speed_m_s;
    std::vector<Complex> sum(setup_.record.samples);
    for (std::size_t n = 0; n < spectra_.size(); ++n) {
      const double y = geometry_.y_m[n], later = steering_delay_s(y, azimuth, c);
      std::vector<Complex> turned = spectra_[n];
      const Complex step = std::polar(1.0, 2 * kPi * setup_.sonar.bandwidth_hz / bins_ * later);
      Complex z = std::polar(1.0, -kPi * setup_.sonar.bandwidth_hz * later);
      if (array.steering == Steering::true_delay) {
        for (Complex& p : turned) {
          p *= z;
          z *= step;
        }
      }
      const std::vector<Complex> series = record(turned);
      for (int t = 0; t < setup_.record.samples; ++t) {
        double delay_s = later;
        if (array.focus == Focus::dynamic) {
          delay_s += focus_delay_s(y, azimuth, focus_range_m(setup_.sonar, setup_.water, t), c);
        }
        const double turns = carrier_turns(setup_.sonar.frequency_hz, delay_s);
        sum[t] += std::polar(geometry_.weight[n], 2 * kPi * turns) * series[t];
      }
    }
    return sum;
  }

 private:
  void add(std::size_t n, const std::vector<Complex>& pulse, Vec3 apparent_m, double u,
           double delay_s, bool carrier, Complex amplitude) {
    const Sonar& sonar = setup_.sonar;
    const double c = setup_.water.sound_speed_m_s;
    const double later = element_delay_s(apparent_m, geometry_.y_m[n], c);
    const double pattern = element_pattern(u, sonar.array->element_width_m, c / sonar.frequency_hz);
    const double turns = carrier_turns(sonar.frequency_hz, (carrier ? delay_s : 0.0) + later);
    const double bin_hz = sonar.bandwidth_hz / bins_;
    const Complex step = std::polar(1.0, -2 * kPi * carrier_turns(bin_hz, delay_s + later));
    Complex z = amplitude * geometry_.response[n] * pattern * source_pressure_pa_m(sonar) *
                std::polar(1.0, -2 * kPi * turns + kPi * sonar.bandwidth_hz * (delay_s + later));
    for (int m = 0; m < bins_; ++m) {
      spectra_[n][m] += z * pulse[m];
      z *= step;
    }
  }

  void add_cells(std::size_t n, const std::vector<Complex>& pulse, const PingTask& task) {
    for (int cell = 0;
         !task.volumes.empty() && cell < setup_.sonar.beam_count * setup_.record.samples; ++cell) {
      const double energy = total_energy(task.volumes, cell);
      if (energy == 0) continue;
      const int j = cell / setup_.record.samples, t = cell % setup_.record.samples;
      const double azimuth = beam_azimuth_rad(setup_.sonar, j);
      const double range_m = focus_range_m(setup_.sonar, setup_.water, t);
      add(n, pulse, range_m * unit_vector(azimuth, 0), std::sin(azimuth),
          t / setup_.sonar.bandwidth_hz, false, draw_volume(task.keys, j, t, energy));
    }
  }

  void add_noise(std::size_t n, const PingTask& task) {
    const double power = element_noise_power_pa2(geometry_, task.noise_power_pa2);
    std::vector<Complex> turned;
    for (int turn = 0; turn < bins_; ++turn) {
      turned.push_back(std::polar(1.0, -2 * kPi * turn / bins_));
    }
    for (int t = 0; t < bins_; ++t) {
      const Complex noise = draw_noise(task.keys, static_cast<int>(n), t, power) / double(bins_);
      for (int m = 0; m < bins_; ++m) {
        const std::int64_t turn = (std::int64_t{m} + bins_ - bins_ / 2) * t % bins_;
        spectra_[n][m] += noise * turned[turn];
      }
    }
  }

  std::vector<Complex> record(const std::vector<Complex>& spectrum) const {
    std::vector<Complex> series(setup_.record.samples);
    for (int t = 0; t < setup_.record.samples; ++t) {
      const Complex step = std::polar(1.0, 2 * kPi * t / bins_);
      Complex z = t % 2 == 0 ? 1 : -1;
      for (const Complex& p : spectrum) {
        series[t] += z * p;
        z *= step;
      }
    }
    return series;
  }

  const SynthesisSetup setup_;
  ArrayGeometry geometry_;
  int bins_;
  std::vector<std::vector<Complex>> spectra_;  // [elements][bins], f_c - b/2 first
};

// Echoes from everywhere in the fan, some elevated, a strong one at `near_m` first of all.
ScattererList echoes_of(const Sonar& sonar, int count, double near_m) {
  std::vector<Scatterer> items = random_scatterers(sonar, count, near_m, 77);
  for (std::size_t i = 0; i < items.size(); ++i) {
    Scatterer& s = items[i];
    const double azimuth = (uniform(78, 0, i, 0) - 0.5) * sonar.beam_spacing_rad * sonar.beam_count;
    s.arrival = {static_cast<float>(azimuth),
                 static_cast<float>(radians(20) * (uniform(78, 0, i, 1) - 0.5))};
    s.received_path_m = static_cast<float>(s.delay_s * 750 * (1 + 0.01 * uniform(78, 0, i, 2)));
    s.beam = sector_of(sonar, s.arrival.azimuth_rad).value_or(0);
  }
  // On a judged beam: errors count against the whole record, which hears it.
  const double ahead_deg = degrees(beam_azimuth_rad(sonar, sonar.beam_count / 2));
  Scatterer strong = target_at(sonar, ahead_deg, 0, near_m);
  strong.gain = static_cast<float>(two_way_loss(near_m, 0.3));
  strong.mean = 1;
  items.push_back(strong);
  return sorted_by_beam_and_delay(std::move(items), sonar.beam_count);
}

void hold(const SynthesisSetup& setup, const PingTask& task, std::vector<int> beams) {
  const ExactArray exact(setup, task);
  PingSeries series;
  make_cpu_backend(setup)->synthesize({&task, 1}, {&series, 1}, Workers(2));
  std::vector<Complex> expected;
  std::vector<std::complex<float>> got;
  const int samples = setup.record.samples;
  for (const int j : beams) {
    for (const Complex& p : exact.beam(j)) expected.push_back(p);
    got.insert(got.end(), series.pressure_pa.begin() + j * samples,
               series.pressure_pa.begin() + (j + 1) * samples);
  }
  const Judged error = judge(expected, got, static_cast<int>(beams.size()));
  const int elements = setup.sonar.array->elements, count = setup.sonar.beam_count;
  CAPTURE(elements, count, simd_level_name(setup.simd), setup.tolerance, error.relative,
          error.worst_tenth);
  CHECK(error.relative <= setup.tolerance);
  CHECK(error.worst_tenth <= 10 * setup.tolerance);
}

}  // namespace

// Protects the path's stated error, V8's way, near and far: a strong echo at 0.6 m or 1.5 m, dead
// and wrong elements, elements with a width, noise.
TEST_CASE("array: beams within the tolerance", "[figure]") {
  const auto [elements, tolerance] = GENERATE(std::pair{101, 1e-5}, std::pair{256, 1e-3});
  Sonar sonar = line_array(elements, 24, 90, 3);
  sonar.array->focus = GENERATE(Focus::none, Focus::dynamic);
  sonar.array->steering = GENERATE(Steering::true_delay, Steering::phase);
  sonar.array->response[5] = 0;
  sonar.array->response[7] = {1.1, 0.2};
  sonar.array->element_width_m = 0.6e-3;
  SynthesisSetup setup = setup_of(sonar);
  setup.tolerance = tolerance;
  const ScattererList list = echoes_of(sonar, 30, tolerance < 1e-4 ? 1.5 : 0.6);
  const PingTask task{&list, keys_of_ping(1), 1e-3, {}, false};
  hold(setup, task, {0, 12});
}

// Protects what falls back to sums in double precision.
TEST_CASE("array: beams within a tolerance that single precision cannot hold") {
  Sonar sonar = line_array(12, 6, 60, 3);
  sonar.array->focus = GENERATE(Focus::none, Focus::dynamic);
  sonar.array->steering = GENERATE(Steering::true_delay, Steering::phase);
  SynthesisSetup setup = setup_of(sonar);
  setup.tolerance = 1e-7;
  const ScattererList list = echoes_of(sonar, 30, 0.6);
  const PingTask task{&list, keys_of_ping(1), 1e-3, {}, false};
  hold(setup, task, {0, 3, 5});
}

// Protects odd sizes, shading and every level of vector instructions.
TEST_CASE("array: beams of few elements, and of every level") {
  const int elements = GENERATE(1, 2, 33, 50);
  Sonar sonar = line_array(elements, GENERATE(1, 7), 60, 3);
  sonar.array->shading.kind = Shading::hann;
  SynthesisSetup setup = setup_of(sonar);
  const ScattererList list = echoes_of(sonar, 30, 0.8);
  const PingTask task{&list, keys_of_ping(1), 1e-3, {}, false};
  for (const SimdLevel level : {SimdLevel::sse4, SimdLevel::avx2, SimdLevel::avx512}) {
    if (level > best_simd_level()) continue;
    setup.simd = level;
    hold(setup, task, {sonar.beam_count / 2});
  }
}

// Protects volumes, the elements' own series, and results from the number of threads.
TEST_CASE("array: volumes, channels, and the same bytes for any threads") {
  Sonar sonar = line_array(40, 9, 60, 3);
  SynthesisSetup setup = setup_of(sonar);
  const ScattererList list = echoes_of(sonar, 40, 0.8);
  const VolumeEcho water =
      volume_of(setup, [](int beam, int n) { return n % 7 == beam ? 1e-4 * n : 0.0; });
  PingTask task{&list, keys_of_ping(1), 1e-3, {&water, 1}, true};
  task.wants_channels = true;
  hold(setup, task, {0, 4});
  const auto backend = make_cpu_backend(setup);
  PingSeries one, more;
  backend->synthesize({&task, 1}, {&one, 1}, Workers(1));
  const std::vector<Complex> exact = ExactArray(setup, task).channel(17);
  const auto* got = one.channels_pa.data() + 17 * setup.record.samples;
  const Judged error = judge(exact, std::vector<std::complex<float>>(got, got + exact.size()), 1);
  CHECK(error.relative <= setup.tolerance);
  for (const int threads : {2, 3}) {
    backend->synthesize({&task, 1}, {&more, 1}, Workers(threads));
    CHECK(more.pressure_pa == one.pressure_pa);
    CHECK(more.clean_power_pa2 == one.clean_power_pa2);
    CHECK(more.channels_pa == one.channels_pa);
  }
  task.wants_channels = task.wants_clean = false;
  backend->synthesize({&task, 1}, {&more, 1}, Workers(2));
  CHECK(more.channels_pa.empty());
  CHECK(more.clean_power_pa2.empty());
}

// Expected power of diffuse echoes alone: what docs/limits.md says of it.
TEST_CASE("array: expected power of diffuse echoes", "[figure]") {
  Sonar sonar = line_array(64, 12, 60, 2);
  sonar.array->focus = GENERATE(Focus::none, Focus::dynamic);
  sonar.array->steering = GENERATE(Steering::true_delay, Steering::phase);
  const SynthesisSetup setup = setup_of(sonar);
  std::vector<Scatterer> echoes = random_scatterers(sonar, 60, 0.6, 5);
  for (Scatterer& s : echoes) {
    s.mean = 0;
    s.arrival.azimuth_rad =
        static_cast<float>(beam_azimuth_rad(sonar, static_cast<int>(s.beam)) +
                           (uniform(3, 0, s.key, 0) - 0.5) * sonar.beam_spacing_rad);
    s.received_path_m = static_cast<float>(s.delay_s * 750);
  }
  const ScattererList list = sorted_by_beam_and_delay(echoes, 12);
  const PingTask task{&list, keys_of_ping(1), 0, {}, true};
  PingSeries fast, exact;
  make_cpu_backend(setup)->synthesize({&task, 1}, {&fast, 1}, Workers(2));
  make_reference_backend(setup)->synthesize({&task, 1}, {&exact, 1}, Workers(2));
  double error = 0, norm = 0, energy = 0, exact_energy = 0;
  for (std::size_t i = 0; i < exact.clean_power_pa2.size(); ++i) {
    const double p = fast.clean_power_pa2[i], q = exact.clean_power_pa2[i];
    error += (p - q) * (p - q);
    norm += q * q;
    energy += p;
    exact_energy += q;
  }
  const bool focused = sonar.array->focus == Focus::dynamic;
  CHECK(std::sqrt(error / norm) < (focused ? 0.015 : 0.06));
  CHECK(energy == Approx(exact_energy).epsilon(0.02));
}

// Where a mean is the strongest echo: within 0.1 dB of the reference's, 40 dB down.
TEST_CASE("array: expected power", "[figure]") {
  Sonar sonar = line_array(64, 12, 60, 2);
  sonar.array->focus = GENERATE(Focus::none, Focus::dynamic);
  sonar.array->steering = GENERATE(Steering::true_delay, Steering::phase);
  sonar.array->response[9] = 0;
  SynthesisSetup setup = setup_of(sonar);
  const ScattererList list = echoes_of(sonar, 25, 0.6);
  const VolumeEcho water =
      volume_of(setup, [](int beam, int n) { return beam == 5 && n % 40 == 20 ? 1e-9 * n : 0.0; });
  const PingTask task{&list, keys_of_ping(1), 0, {&water, 1}, true};
  PingSeries fast, exact;
  make_cpu_backend(setup)->synthesize({&task, 1}, {&fast, 1}, Workers(2));
  make_reference_backend(setup)->synthesize({&task, 1}, {&exact, 1}, Workers(2));
  double largest = 0, worst = 0;
  for (const float p : exact.clean_power_pa2) largest = std::max<double>(largest, p);
  int judged = 0;
  for (std::size_t i = 0; i < exact.clean_power_pa2.size(); ++i) {
    if (exact.clean_power_pa2[i] < 1e-4 * largest) continue;
    ++judged;
    const double ratio = double(fast.clean_power_pa2[i]) / exact.clean_power_pa2[i];
    worst = std::max(worst, std::abs(10 * std::log10(ratio)));
  }
  CAPTURE(judged, worst);
  CHECK(judged > 20);
  CHECK(worst < 0.1);
}
