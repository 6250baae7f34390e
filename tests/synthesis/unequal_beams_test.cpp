// Beams of unequal spacing and width: the weights of their mixing against closed forms and
// quadrature, and every backend against the reference.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "synthesis/array_fixture.h"
#include "synthesis/beam_mixing.h"
#include "synthesis/mixing_fixture.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

// Beams that lie closer toward port, about an axis off the boresight, over `fan_deg`.
Sonar unequal_sonar(int beams, double fan_deg, double range_max_m) {
  Sonar sonar = p900(beams, fan_deg, range_max_m);
  for (int j = 0; j < beams; ++j) {
    const double x = (j + 0.5) / beams;
    sonar.azimuth_rad.push_back(radians(fan_deg * (1.3 * x - 0.3 * x * x - 0.6)));
    sonar.width_rad.push_back(radians(0.8 + 0.6 * x));
  }
  const std::vector<double> borders = beam_borders_rad(sonar);
  sonar.beam_spacing_rad = (borders.back() - borders.front()) / beams;
  return sonar;
}

std::unique_ptr<Backend> backend_of(int which, const SynthesisSetup& setup) {
  if (which == 0) return make_reference_backend(setup);
  return which == 1 ? make_cpu_backend(setup) : host_device(setup);
}

// Eq 17 without shading.
double line(double offset_rad, double width_rad) {
  const double x = kPi * 0.884 * std::sin(offset_rad) / width_rad;
  return x == 0 ? 1 : std::sin(x) / x;
}

}  // namespace

// Protects the weights: beam b has its own azimuth, its own width and the cell's middle, not a
// distance in beams. (0.884 has three digits, hence 1e-3 of a width.)
TEST_CASE("a point target's level in a beam is that beam's pattern at its offset") {
  const int which = GENERATE(0, 1, 2);
  const Sonar sonar = unequal_sonar(25, 20, 3);
  const SynthesisSetup setup = setup_of(sonar);
  const int cell = 9, n = 60;
  const double range_m = sample_range_m(sonar, setup.water, n);
  const ScattererList list =
      sorted_by_beam_and_delay({point_target(sonar, cell, range_m, -40)}, 25);
  const PingSeries series = one(*backend_of(which, setup), {&list, keys_of_ping(1), 0, {}});
  const double at_axis = source_pressure_pa_m(sonar) * 0.01 * two_way_loss(range_m, 0);
  const std::vector<double> borders = beam_borders_rad(sonar);
  const double middle = (borders[cell] + borders[cell + 1]) / 2;
  for (int j = 0; j < 25; ++j) {
    CAPTURE(which, j);
    const double expected = line(middle - sonar.azimuth_rad[j], sonar.width_rad[j]);
    const std::size_t at = std::size_t(j) * setup.record.samples + n;
    CHECK(std::abs(std::complex<double>(series.pressure_pa[at])) / at_axis ==
          Approx(std::abs(expected)).margin(1e-3));
    CHECK(std::sqrt(series.clean_power_pa2[at]) / at_axis ==
          Approx(std::abs(expected)).margin(1e-3));
    // Without the rounded factor of the pattern.
    const double exact = std::abs(shaded_pattern(
        make_shaded_line(sonar.shading, sonar.width_rad[j]), middle - sonar.azimuth_rad[j]));
    CHECK(std::abs(std::complex<double>(series.pressure_pa[at])) / at_axis ==
          Approx(exact).margin(1e-5));
  }
}

TEST_CASE("backends mix unequal beams as the reference does") {
  const bool has_widths = GENERATE(true, false);
  for (const int beams : {2, 17, 40}) {
    Sonar sonar = unequal_sonar(beams, beams * 0.7, 3);
    if (!has_widths) sonar.width_rad.clear();
    if (beams == 17) sonar.normalization = Normalization::mean_square;
    if (beams == 40) sonar.shading.kind = Shading::taylor;
    const SynthesisSetup setup = setup_of(sonar);
    const ScattererList list =
        sorted_by_beam_and_delay(random_scatterers(sonar, 700, 0.05, 5), beams);
    const VolumeEcho water = volume_of(
        setup, [](int beam, int n) { return (beam + n) % 3 == 0 ? 1e-7 * (1 + n % 5) : 0.0; });
    const PingTask task{&list, keys_of_ping(2), 3e-3, {&water, 1}};
    const PingSeries expected = one(*make_reference_backend(setup), task);
    const PingSeries cpu = one(*make_cpu_backend(setup), task);
    const PingSeries device = one(*host_device(setup), task);
    CAPTURE(beams, has_widths);
    CHECK(relative(cpu.pressure_pa, expected.pressure_pa) < setup.tolerance);
    CHECK(relative(cpu.clean_power_pa2, expected.clean_power_pa2) < 1e-5);
    CHECK(relative(device.pressure_pa, expected.pressure_pa) < 1e-5);
    CHECK(relative(device.clean_power_pa2, expected.clean_power_pa2) < 1e-5);
  }
}

TEST_CASE("backends shift echoes of unequal beams as the reference does") {
  const SynthesisSetup setup = with_shifts(unequal_sonar(11, 9, 2), 2e-3);
  const ScattererList list =
      sorted_by_beam_and_delay(with_shifts(random_scatterers(setup.sonar, 200, 0.2, 8), 2e-3), 11);
  const PingTask task{&list, keys_of_ping(3), 0, {}, false};
  const PingSeries expected = one(*make_reference_backend(setup), task);
  CHECK(relative(one(*make_cpu_backend(setup), task).pressure_pa, expected.pressure_pa) <
        setup.tolerance);
  CHECK(relative(one(*host_device(setup), task).pressure_pa, expected.pressure_pa) < 1e-4);
}

// Protects the equal case against a second meaning: a table of equal azimuths and widths is it.
TEST_CASE("a table of equal beams gives the same ping as equal beams") {
  const Sonar equal = p900(30, 12, 3);
  Sonar table = equal;
  table.azimuth_rad = beam_azimuths_rad(equal);
  table.width_rad.assign(30, equal.beam_width_rad);
  const ScattererList list = sorted_by_beam_and_delay(random_scatterers(equal, 500, 0.05, 6), 30);
  const PingTask task{&list, keys_of_ping(4), 1e-3, {}};
  for (const int which : {0, 1, 2}) {
    const PingSeries a = one(*backend_of(which, setup_of(equal)), task);
    const PingSeries b = one(*backend_of(which, setup_of(table)), task);
    CAPTURE(which);
    const double bound = which == 1 ? setup_of(equal).tolerance : 1e-6;
    CHECK(relative(b.pressure_pa, a.pressure_pa) < bound);
    CHECK(relative(b.clean_power_pa2, a.clean_power_pa2) < 1e-5);
  }
}

// A volume of the same energy per radian of azimuth: every beam, in narrow and in wide cells, has
// the integral of its squared pattern over the fan, here by quadrature. Cells are half a beam wide
// at most, over which B^2 has no more than a wave, so that midpoints are within 1e-3 of it.
TEST_CASE("narrow and wide cells give a homogeneous volume one level per angle") {
  Sonar sonar = unequal_sonar(60, 20, 3);
  const SynthesisSetup setup = setup_of(sonar);
  constexpr double kPerRadian = 1e-6;
  const VolumeEcho water =
      volume_of(setup, [&](int beam, int) { return kPerRadian * cell_width_rad(sonar, beam); });
  const ScattererList list = sorted_by_beam_and_delay({}, 60);
  const std::vector<double> borders = beam_borders_rad(sonar);
  const auto pattern_integral = [&](int beam) {
    constexpr int kSteps = 20000;
    const double step = (borders.back() - borders.front()) / kSteps;
    double sum = 0;
    for (int k = 0; k < kSteps; ++k) {
      const double b =
          line(borders.front() + (k + 0.5) * step - sonar.azimuth_rad[beam], sonar.width_rad[beam]);
      sum += b * b * step;
    }
    return sum;
  };
  for (const int which : {0, 1, 2}) {
    const PingSeries series =
        one(*backend_of(which, setup), {&list, keys_of_ping(5), 0, {&water, 1}});
    // The pulse's sum is the same in all beams: they are compared with beam 30.
    const auto power = [&](int beam) {
      return double(series.clean_power_pa2[std::size_t(beam) * setup.record.samples + 60]);
    };
    for (const int beam : {3, 10, 20, 45, 56}) {
      CAPTURE(which, beam);
      CHECK(power(beam) / power(30) ==
            Approx(pattern_integral(beam) / pattern_integral(30)).epsilon(3e-3));
    }
  }
}

// What beam j hears of a cell is its own pattern times that of the nearest beam of its group.
TEST_CASE("beams that transmit in turn hear what their group sends") {
  const double sent_deg = GENERATE(0.0, 0.5);  // 0: as wide as the receive beam
  Sonar sonar = p900(24, 12, 3);
  sonar.transmit = TransmitGroups{.count = 6, .width_rad = radians(sent_deg)};
  const double width = sonar.beam_width_rad, step = sonar.beam_spacing_rad;
  const double lobe = sent_deg > 0 ? radians(sent_deg) : width;
  const Mixing mixing = make_mixing(sonar);
  for (const auto& [beam, cell, from] : std::vector<std::array<int, 3>>{
           {8, 8, 8}, {8, 9, 8}, {8, 13, 14}, {8, 14, 14}, {0, 23, 18}}) {
    CAPTURE(beam, cell);
    CHECK(
        mixing.at(beam, cell) ==
        Approx(line((cell - beam) * step, width) * line((cell - from) * step, lobe)).margin(1e-3));
  }
  // Side lobes of a beam within its group count in full.
  CHECK(mixing.at(8, 14) ==
        Approx(shaded_pattern(make_shaded_line(sonar.shading, width), 6 * step)).margin(1e-12));
}

TEST_CASE("backends mix beams that transmit in turn as the reference does") {
  Sonar sonar = GENERATE(p900(40, 20, 3), unequal_sonar(40, 28, 3));
  sonar.transmit = TransmitGroups{.count = 8};
  const SynthesisSetup setup = setup_of(sonar);
  const ScattererList list = sorted_by_beam_and_delay(random_scatterers(sonar, 700, 0.05, 5), 40);
  const VolumeEcho water = volume_of(
      setup, [](int beam, int n) { return (beam + n) % 3 == 0 ? 1e-7 * (1 + n % 5) : 0.0; });
  const PingTask task{&list, keys_of_ping(2), 3e-3, {&water, 1}};
  const PingSeries expected = one(*make_reference_backend(setup), task);
  for (const int which : {1, 2}) {
    const PingSeries series = one(*backend_of(which, setup), task);
    CAPTURE(which);
    CHECK(relative(series.pressure_pa, expected.pressure_pa) < 1e-5);
    CHECK(relative(series.clean_power_pa2, expected.clean_power_pa2) < 1e-5);
  }
}

TEST_CASE("mean-square normalization of unequal beams") {
  Sonar sonar = unequal_sonar(33, 20, 3);
  sonar.normalization = Normalization::mean_square;
  const Mixing mixing = make_mixing(sonar);
  for (int j = 0; j < 33; ++j) {
    double sum = 0;
    for (int i = 0; i < 33; ++i) sum += std::pow(mixing.at(j, i) * mixing.scale[j], 2);
    CHECK(sum == Approx(1).margin(1e-12));
  }
}

TEST_CASE("the mixer of unequal beams equals the full product") {
  constexpr int kBeams = 19;
  Sonar sonar = unequal_sonar(kBeams, 9, 3);
  sonar.normalization = Normalization::mean_square;
  const Mixing mixing = make_mixing(sonar);
  CHECK(BeamMixer(mixing).matrix_bytes() == 2 * kBeams * kBeams * sizeof(double));
  check_mixer(mixing, kBeams);
}

// Protects steering to the azimuths, also where the fan ends further out on one side: its tables
// reach the outermost beam.
TEST_CASE("an array steers to unequal azimuths on every backend") {
  Sonar sonar = line_array(40, 9, 40, 3);
  sonar.azimuth_rad.clear();
  for (const double degrees : {-12, -10, -7, -1, 4, 15, 30, 44, 61}) {
    sonar.azimuth_rad.push_back(radians(degrees));
  }
  const std::vector<double> borders = beam_borders_rad(sonar);
  sonar.beam_spacing_rad = (borders.back() - borders.front()) / 9;
  const Focus focus = GENERATE(Focus::none, Focus::dynamic);
  sonar.array->focus = focus;
  const double range_m = sample_range_m(sonar, {1500, 0}, 80);
  // A target at a beam's azimuth: all elements agree in that beam and no other.
  for (const ArrayBackend& kind : kArrayBackends) {
    for (const int beam : {0, 3, 8}) {
      const double azimuth_deg = degrees(sonar.azimuth_rad[beam]);
      const std::vector<double> cut =
          beam_cut(kind, sonar, target_at(sonar, azimuth_deg, 0, range_m));
      CAPTURE(kind.name, beam);
      CHECK(std::max_element(cut.begin(), cut.end()) - cut.begin() == beam);
      if (focus == Focus::dynamic) CHECK(cut[beam] == Approx(1).margin(5e-3));
    }
  }
  const SynthesisSetup setup = setup_of(sonar);
  std::vector<Scatterer> echoes = fan_echoes(sonar, 60, 0.3);
  for (Scatterer& s : echoes) {
    s.arrival.azimuth_rad += static_cast<float>((borders.front() + borders.back()) / 2);
    s.beam = sector_of(sonar, s.arrival.azimuth_rad).value_or(0);
  }
  const ScattererList list = list_of(sonar, std::move(echoes));
  const PingTask task{&list, keys_of_ping(1), 0, {}, true};
  const PingSeries expected = one(*make_reference_backend(setup), task);
  const PingSeries cpu = one(*make_cpu_backend(setup), task);
  CHECK(relative(cpu.pressure_pa, expected.pressure_pa) < 1e-4);
  CHECK(relative(one(*host_device(setup), task).pressure_pa, expected.pressure_pa) < 1e-5);
  const auto total = [](const auto& power) {
    return std::accumulate(power.begin(), power.end(), 0.0);
  };
  CHECK(total(cpu.clean_power_pa2) == Approx(total(expected.clean_power_pa2)).epsilon(0.05));
}
