// What of an array is random: noise, speckle, volumes; and the sums behind all of it by a route of
// their own, in time.
#include "catch.h"
#include "core/scatterers.h"
#include "synthesis/array_fixture.h"
#include "synthesis/direct_sum.h"
#include "synthesis/draw.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

using Complex = std::complex<double>;

PingSeries synthesized(const ArrayBackend& kind, const SynthesisSetup& setup,
                       const PingTask& task) {
  PingSeries series;
  kind.make(setup)->synthesize({&task, 1}, {&series, 1}, Workers(2));
  return series;
}

// An array with everything that an array can have, and a fan of few beams.
Sonar odd_array(Steering steering, Focus focus) {
  Sonar sonar = line_array(7, 5, 100, 1.2);
  sonar.array->steering = steering;
  sonar.array->focus = focus;
  sonar.array->element_width_m = 0.4 * kWavelengthM;
  sonar.array->spacing_m = 4e-3;
  sonar.array->shading = {Shading::hann};
  sonar.array->response = {1, {0.9, 0.1}, 1, 0, {1.1, -0.2}, 1, {0, 0.8}};
  return sonar;
}

std::vector<Scatterer> scatterers_around(const Sonar& sonar, int count) {
  std::vector<Scatterer> scatterers = random_scatterers(sonar, count, 0.2, 77);
  for (Scatterer& s : scatterers) {
    const double across = uniform(78, 0, s.key, 0) - 0.5;
    s.arrival = {static_cast<float>(beam_azimuth_rad(sonar, static_cast<int>(s.beam)) +
                                    across * sonar.beam_spacing_rad),
                 static_cast<float>(0.3 * (uniform(78, 0, s.key, 1) - 0.5))};
    s.received_path_m =
        static_cast<float>(s.delay_s * 750 * (0.8 + 0.4 * uniform(78, 0, s.key, 2)));
  }
  return scatterers;
}

// The definitions of synthesis/beamforming.h in time, with lengths and angles worked out anew.
class DirectArray {
 public:
  explicit DirectArray(const SynthesisSetup& setup)
      : setup_(setup), array_(*setup.sonar.array), pulse_(setup) {
    weight_ = array_weights(array_.shading, array_.elements);
  }

  // What element n hears at time t (in samples) of a sound of amplitude 1.
  Complex heard(Vec3 from, double delay_s, double carrier_delay_s, int n, double t) const {
    const double y = (n - (array_.elements - 1) / 2.0) * array_.spacing_m;
    const double longer_s = (length(from - Vec3{0, y, 0}) - length(from)) / 1500;
    const double u = from.y / length(from);
    const double x = kPi * array_.element_width_m * u / kWavelengthM;
    const double pattern = x == 0 ? 1 : std::sin(x) / x;
    const double turns = std::fmod(setup_.sonar.frequency_hz * (carrier_delay_s + longer_s), 1.0);
    return array_.response[n] * pattern * source_pressure_pa_m(setup_.sonar) *
           std::polar(1.0, -2 * kPi * turns) *
           pulse_.pulse(t - (delay_s + longer_s) * setup_.sonar.bandwidth_hz);
  }

  // The same in beam j at sample k.
  Complex in_beam(Vec3 from, double delay_s, double carrier_delay_s, int j, int k) const {
    const double theta = beam_azimuth_rad(setup_.sonar, j);
    const double r = std::max(k, 1) * 1500 / (2 * setup_.sonar.bandwidth_hz);
    Complex sum = 0;
    for (int n = 0; n < array_.elements; ++n) {
      const double y = (n - (array_.elements - 1) / 2.0) * array_.spacing_m;
      const double steer_s = -y * std::sin(theta) / 1500;
      const Vec3 focus = r * Vec3{std::cos(theta), std::sin(theta), 0};
      const bool is_focused = array_.focus == Focus::dynamic;
      const double turn_s = is_focused ? (length(focus - Vec3{0, y, 0}) - r) / 1500 : steer_s;
      const bool delays = array_.steering == Steering::true_delay;
      const double t = k + (delays ? steer_s * setup_.sonar.bandwidth_hz : 0);
      sum += weight_[n] * std::polar(1.0, 2 * kPi * setup_.sonar.frequency_hz * turn_s) *
             heard(from, delay_s, carrier_delay_s, n, t);
    }
    return sum;
  }

 private:
  SynthesisSetup setup_;
  ArrayReceiver array_;
  DirectSum pulse_;
  std::vector<double> weight_;
};

}  // namespace

// Protects every term of the definition: pressure, channels and expected power of an array with
// shading, wide elements, errors and a dead one, of scatterers and a volume.
TEST_CASE("the series of an array is its definition in time") {
  for (const ArrayBackend& kind : kArrayBackends) {
    for (const Steering steering : {Steering::true_delay, Steering::phase}) {
      const Focus focus = steering == Steering::phase ? Focus::none : Focus::dynamic;
      INFO(kind.name << (focus == Focus::none ? ", phase" : ", delay and focus"));
      const Sonar sonar = odd_array(steering, focus);
      const SynthesisSetup setup = setup_of(sonar);
      const DirectArray direct(setup);
      const int samples = setup.record.samples;
      const ScattererList list = sorted_by_beam_and_delay(scatterers_around(sonar, 6), 5);
      // Two cells of a volume hold something.
      const VolumeEcho volume = volume_of(setup, [](int beam, int n) {
        return (beam == 1 && n == 20) || (beam == 4 && n == 33) ? 1e-3 : 0.0;
      });
      PingTask task{&list, keys_of_ping(3), 0, {&volume, 1}};
      task.wants_channels = true;
      const PingSeries series = synthesized(kind, setup, task);
      REQUIRE(series.channels_pa.size() == std::size_t(7) * samples);

      double largest = 0, largest_power = 0;
      for (const auto& p : series.pressure_pa) largest = std::max<double>(largest, std::abs(p));
      for (const float p : series.clean_power_pa2) {
        largest_power = std::max<double>(largest_power, p);
      }
      struct Part {
        Vec3 from;
        double delay_s, carrier_s;
        Complex amplitude, mean;
        double energy;
      };
      std::vector<Part> parts;
      for (const Scatterer& s : list.items) {
        const double az = s.arrival.azimuth_rad, el = s.arrival.elevation_rad;
        const Vec3 from =
            double(s.received_path_m) *
            Vec3{std::cos(el) * std::cos(az), std::cos(el) * std::sin(az), std::sin(el)};
        const double rms = double(s.standard_deviation) * s.gain;
        parts.push_back({from, s.delay_s, s.delay_s,
                         Complex(draw_amplitude(s, task.keys)) * double(s.gain),
                         Complex(s.mean) * double(s.gain), rms * rms});
      }
      for (const auto& [beam, n] : {std::pair{1, 20}, std::pair{4, 33}}) {
        const double az = beam_azimuth_rad(sonar, beam), r = n * 750 / sonar.bandwidth_hz;
        parts.push_back({{r * std::cos(az), r * std::sin(az), 0},
                         n / sonar.bandwidth_hz,
                         0,
                         draw_volume(task.keys, beam, n, volume.energy[beam * samples + n]),
                         0,
                         volume.energy[beam * samples + n]});
      }
      for (int n = 0; n < 7; ++n) {
        for (int k = 0; k < samples; k += 5) {
          Complex sum = 0;
          for (const Part& p : parts) {
            sum += p.amplitude * direct.heard(p.from, p.delay_s, p.carrier_s, n, k);
          }
          CHECK(std::abs(Complex(series.channels_pa[n * samples + k]) - sum) < 1e-5 * largest);
        }
      }
      for (int j = 0; j < 5; ++j) {
        double energy = 0, expected_energy = 0;
        for (int k = 0; k < samples; ++k) {
          Complex sum = 0, mean = 0;
          double power = 0;
          for (const Part& p : parts) {
            const Complex h = direct.in_beam(p.from, p.delay_s, p.carrier_s, j, k);
            sum += p.amplitude * h;
            mean += p.mean * h;
            power += p.energy * std::norm(h);
          }
          const std::size_t at = j * samples + k;
          CHECK(std::abs(Complex(series.pressure_pa[at]) - sum) < 1e-5 * largest);
          const double expected = std::norm(mean) + power;
          energy += series.clean_power_pa2[at];
          expected_energy += expected;
          if (!kind.has_exact_power) continue;
          CHECK(std::abs(series.clean_power_pa2[at] - expected) < 1e-5 * largest_power);
        }
        CHECK(energy == Approx(expected_energy).epsilon(0.02));
      }
    }
  }
}

// 27 pings of 21 beams far apart and 120 samples: standard error 4.34/sqrt(68,040) = 0.0167 dB.
TEST_CASE("noise of an array: a beam has the level of the sonar equation", "[figure]") {
  for (const ArrayBackend& kind : kArrayBackends) {
    INFO(kind.name);
    Sonar sonar = line_array(16, 21, 105, 3);
    sonar.array->shading = {Shading::hann};
    const SynthesisSetup setup = setup_of(sonar);
    const double power = sonar.bandwidth_hz * mean_square_pa2(30);
    const ScattererList nothing = sorted_by_beam_and_delay({}, 21);
    const auto backend = kind.make(setup);
    double sum = 0;
    std::size_t count = 0;
    for (std::uint32_t ping = 0; ping < 27; ++ping) {
      RandomKeys keys;
      keys.noise = stream_key(5, Stream::noise, 0);
      keys.noise_ping = ping;
      for (const auto& p : synthesize(*backend, nothing, keys, power).pressure_pa) {
        sum += std::norm(Complex(p));
        ++count;
      }
    }
    CHECK(level_db(sum / count) == Approx(74.76).margin(0.05));
  }
}

// Neighbouring beams hear the same elements: E p_j p_k* is the sum of the squared weights turned by
// what the two beams turn elements apart. 40 pings of 120 samples: standard error 0.0144.
TEST_CASE("noise of an array: neighbouring beams are correlated", "[figure]") {
  for (const ArrayBackend& kind : kArrayBackends) {
    INFO(kind.name);
    Sonar sonar = line_array(24, 4, 4 * 2.5, 3);
    sonar.array->shading = {Shading::taylor, -25, 4};
    sonar.array->focus = Focus::none;
    const SynthesisSetup setup = setup_of(sonar);
    const int samples = setup.record.samples;
    const ScattererList nothing = sorted_by_beam_and_delay({}, 4);
    const auto backend = kind.make(setup);
    Complex across[4] = {};
    for (std::uint32_t ping = 0; ping < 40; ++ping) {
      RandomKeys keys;
      keys.noise = stream_key(6, Stream::noise, 0);
      keys.noise_ping = ping;
      const PingSeries series = synthesize(*backend, nothing, keys, 1.0);
      for (int k = 0; k < 4; ++k) {
        for (int n = 0; n < samples; ++n) {
          across[k] += Complex(series.pressure_pa[n]) *
                       std::conj(Complex(series.pressure_pa[k * samples + n])) / (40.0 * samples);
        }
      }
    }
    const ArrayGeometry geometry = make_array_geometry(sonar);
    for (int k = 0; k < 4; ++k) {
      Complex expected = 0;
      double squares = 0;
      for (int n = 0; n < 24; ++n) {
        const double apart =
            std::sin(beam_azimuth_rad(sonar, k)) - std::sin(beam_azimuth_rad(sonar, 0));
        const double w = geometry.weight[n];
        expected += w * w * std::polar(1.0, 2 * kPi * geometry.y_m[n] * apart / kWavelengthM);
        squares += w * w;
      }
      INFO("beams 0 and " << k << ": " << std::abs(expected / squares));
      CHECK(std::abs(across[k] - expected / squares) < 3 * 0.0144);
    }
  }
}

// Protects from noise in dead elements, and from noise that beams and channels do not share.
TEST_CASE("noise of an array is that of its channels") {
  for (const ArrayBackend& kind : kArrayBackends) {
    INFO(kind.name);
    Sonar sonar = line_array(6, 1, 2, 3);
    sonar.array->focus = Focus::none;
    sonar.array->response[2] = 0;
    const SynthesisSetup setup = setup_of(sonar);
    const int samples = setup.record.samples;
    const ScattererList nothing = sorted_by_beam_and_delay({}, 1);
    RandomKeys keys;
    keys.noise = stream_key(7, Stream::noise, 0);
    PingTask task{&nothing, keys, 3.0, {}, false};
    task.wants_channels = true;
    const PingSeries series = synthesized(kind, setup, task);
    for (int k = 0; k < samples; ++k) {
      Complex mean = 0;  // of a beam ahead
      for (int n = 0; n < 6; ++n) {
        const Complex p = series.channels_pa[n * samples + k];
        const Complex drawn = n == 2 ? 0 : draw_noise(keys, n, k, 3.0 * 6);
        CHECK(std::abs(p - drawn) < 1e-5);
        mean += p / 6.0;
      }
      CHECK(std::abs(Complex(series.pressure_pa[k]) - mean) < 1e-5);
    }
  }
}

// The mean square over draws is the expected power. 800 pings; pixels over -30 dB of the strongest,
// each relative to what is expected of it; the standard error is that of the pings' means. Not by
// the reference, whose pressure and expected power are each compared with their definition above.
TEST_CASE("the expected power of an array is the mean over draws", "[figure]") {
  for (const ArrayBackend& kind : kArrayBackends) {
    if (kind.has_exact_power) continue;
    INFO(kind.name);
    Sonar sonar = odd_array(Steering::true_delay, Focus::dynamic);
    const SynthesisSetup setup = setup_of(sonar);
    const ScattererList list = sorted_by_beam_and_delay(scatterers_around(sonar, 60), 5);
    const VolumeEcho volume = volume_of(
        setup, [](int beam, int n) { return beam == 2 && n % 6 == 3 && n < 30 ? 2e-3 : 0.0; });
    const auto backend = kind.make(setup);
    const SampleArray<float> clean =
        synthesize(*backend, list, keys_of_ping(0), 0, {&volume, 1}).clean_power_pa2;
    const float strongest = *std::max_element(clean.begin(), clean.end());
    double sum = 0, squares = 0;
    constexpr int kPings = 800;
    for (std::uint32_t ping = 0; ping < kPings; ++ping) {
      PingTask task{&list, keys_of_ping(ping), 0, {&volume, 1}, false};
      PingSeries series;
      backend->synthesize({&task, 1}, {&series, 1}, Workers(2));
      double mean = 0;
      int count = 0;
      for (std::size_t i = 0; i < clean.size(); ++i) {
        if (clean[i] < 1e-3 * strongest) continue;
        mean += std::norm(Complex(series.pressure_pa[i])) / clean[i];
        ++count;
      }
      sum += mean / count / kPings;
      squares += mean / count * mean / count / kPings;
    }
    const double error_db = 4.34 * std::sqrt((squares - sum * sum) / kPings);
    INFO("standard error " << error_db << " dB");
    CHECK(3 * error_db < 0.1);
    CHECK(10 * std::log10(sum) == Approx(0).margin(0.1));
  }
}

// A diffuse scene of 12 scatterers a sector: the expected power of the four beams about broadside,
// summed over the record, by either model. The array's aperture is that of the beam's width.
TEST_CASE("array and beam model hear a diffuse scene alike at broadside", "[rest]") {
  Sonar sonar = line_array(25, 24, 24 * 2.0, 1.5);
  sonar.beam_width_rad = 0.884 / 12.5;
  std::vector<Scatterer> scatterers;
  for (int i = 0; i < 24 * 12; ++i) {
    const double azimuth =
        beam_azimuth_rad(sonar, i / 12) + sonar.beam_spacing_rad * (uniform(91, 0, i, 0) - 0.5);
    Scatterer s = target_at(sonar, degrees(azimuth), 0, 0.5 + 0.8 * uniform(91, 0, i, 1));
    s.mean = 0;
    s.standard_deviation = 0.1F;
    s.key = i;
    scatterers.push_back(s);
  }
  const ScattererList list = sorted_by_beam_and_delay(scatterers, 24);
  Sonar ideal = sonar;
  ideal.array.reset();
  const SynthesisSetup setup = setup_of(sonar);
  const PingSeries beams = synthesize(*make_reference_backend(setup_of(ideal)), list);
  for (const ArrayBackend& kind : kArrayBackends) {
    INFO(kind.name);
    const PingSeries array = synthesize(*kind.make(setup), list);
    double by_array = 0, by_beams = 0;
    for (int i = 10 * setup.record.samples; i < 14 * setup.record.samples; ++i) {
      by_array += array.clean_power_pa2[i];
      by_beams += beams.clean_power_pa2[i];
    }
    CHECK(10 * std::log10(by_array / by_beams) == Approx(0).margin(0.3));
  }
}
