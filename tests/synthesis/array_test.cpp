// The closed forms of an array of elements, on every backend that knows arrays: beams of a point
// target against line-array theory.
#include "synthesis/array_fixture.h"

#include "catch.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

// |sin(N pi d u / lambda) / (N sin(pi d u / lambda))|, d half a wavelength.
double discrete_line(int elements, double u) {
  const double x = kPi * u / 2;
  return std::abs(x) < 1e-9 ? 1 : std::abs(std::sin(elements * x) / (elements * std::sin(x)));
}

}  // namespace

// V12: 101 elements at half a wavelength, focused: the discrete line's pattern above -30 dB within
// 0.3 dB.
TEST_CASE("V12: the focused beam of an array is that of a discrete line", "[figure]") {
  for (const ArrayBackend& kind : kArrayBackends) {
    INFO(kind.name);
    const Sonar sonar = line_array(101, 161, 161 * 0.05, 3);
    const double range_m = sample_range_m(sonar, {1500, 0}, 99);
    const std::vector<double> cut = beam_cut(kind, sonar, target_at(sonar, 0, 0, range_m));
    int compared = 0;
    for (int j = 0; j < sonar.beam_count; ++j) {
      const double expected = discrete_line(101, std::sin(beam_azimuth_rad(sonar, j)));
      if (decibels(expected) < -30) continue;
      ++compared;
      INFO("beam at " << degrees(beam_azimuth_rad(sonar, j)) << " deg");
      CHECK(decibels(cut[j]) == Approx(decibels(expected)).margin(0.3));
    }
    CHECK(compared > 140);
  }
}

// V12: and of the beam model (V2) in the main lobe above -20 dB, and at lobe peaks above -30 dB.
TEST_CASE("V12: the beam of an array is that of the beam model around broadside", "[figure]") {
  for (const ArrayBackend& kind : kArrayBackends) {
    INFO(kind.name);
    const Sonar sonar = line_array(101, 401, 401 * 0.02, 3);
    const double range_m = sample_range_m(sonar, {1500, 0}, 99);
    const std::vector<double> cut = beam_cut(kind, sonar, target_at(sonar, 0, 0, range_m));
    int in_lobe = 0, peaks = 0;
    double model_peak = 0, array_peak = 0;  // of the lobe under way
    for (int j = sonar.beam_count / 2; j < sonar.beam_count; ++j) {
      const double theta = beam_azimuth_rad(sonar, j);
      const double model = line_pattern(theta, sonar.beam_width_rad);
      if (theta < radians(1.1) && decibels(model) > -20) {
        ++in_lobe;
        CHECK(decibels(cut[j]) == Approx(decibels(model)).margin(0.3));
      }
      if (theta < radians(1.15)) continue;
      const bool ends = std::abs(model) < model_peak / 10;
      if (ends && decibels(model_peak) > -30) {
        ++peaks;
        CHECK(decibels(array_peak) == Approx(decibels(model_peak)).margin(0.3));
      }
      if (ends) model_peak = array_peak = 0;
      model_peak = std::max(model_peak, std::abs(model));
      array_peak = std::max(array_peak, cut[j]);
    }
    CHECK(in_lobe > 40);
    CHECK(peaks == 2);
  }
}

// V13: a target in the near field, L^2/lambda = 4.3 m. b = 30 kHz puts 1 m and 2 m on samples.
TEST_CASE("V13: near-field beams with and without focus", "[figure]") {
  struct Case {
    double range_m, width_deg, peak_db;
  };
  for (const ArrayBackend& kind : kArrayBackends) {
    for (const Case& c : {Case{1, 3.22, -4.58}, Case{2, 1.08, -1.09}}) {
      INFO(kind.name << ", " << c.range_m << " m");
      Sonar sonar = line_array(101, 201, 201 * 0.04, c.range_m + 0.3, 30e3);
      const Scatterer target = target_at(sonar, 0, 0, c.range_m);
      const std::vector<double> focused = beam_cut(kind, sonar, target);
      CHECK(decibels(focused[100]) == Approx(0).margin(0.1));
      CHECK(width_deg(sonar, focused) == Approx(1.005).epsilon(0.02));
      CHECK(highest_lobe_db(focused) == Approx(-13.25).margin(0.1));
      sonar.array->focus = Focus::none;
      const std::vector<double> unfocused = beam_cut(kind, sonar, target);
      CHECK(width_deg(sonar, unfocused) == Approx(c.width_deg).epsilon(0.02));
      CHECK(decibels(unfocused[100] / focused[100]) == Approx(c.peak_db).margin(0.1));
    }
  }
}

// What a phase at the carrier costs against a delay of the whole pulse, for the aperture of a beam
// of 1 degree and the gaussian pulse of 29.9 kHz.
TEST_CASE("steering by phase smears the pulse of oblique beams", "[figure]") {
  for (const ArrayBackend& kind : kArrayBackends) {
    for (const auto& [azimuth_deg, loss_db] :
         {std::pair{30.0, 0.39}, std::pair{45.0, 0.77}, std::pair{65.0, 1.25}}) {
      INFO(kind.name << ", " << azimuth_deg << " deg");
      Sonar sonar = line_array(101, 5, 2.5 * azimuth_deg, 5);
      const double range_m = sample_range_m(sonar, {1500, 0}, 150);
      const Scatterer target = target_at(sonar, azimuth_deg, 0, range_m);
      const double by_delay = beam_cut(kind, sonar, target)[4];
      CHECK(decibels(by_delay) == Approx(0).margin(0.01));
      sonar.array->steering = Steering::phase;
      const double by_phase = beam_cut(kind, sonar, target)[4];
      CHECK(decibels(by_delay / by_phase) == Approx(loss_db).margin(0.03));
    }
  }
}

// A line tells one angle: sin(beam) = cos(elevation) sin(azimuth), here asin(cos 10 sin 45).
TEST_CASE("off the plane a line array's beam is a cone", "[figure]") {
  for (const ArrayBackend& kind : kArrayBackends) {
    INFO(kind.name);
    const Sonar sonar = line_array(101, 501, 501 * 0.2, 4, 6e3);
    const double range_m = sample_range_m(sonar, {1500, 0}, 28);
    const std::vector<double> cut = beam_cut(kind, sonar, target_at(sonar, 45, 10, range_m));
    const double peak_deg =
        degrees(beam_azimuth_rad(sonar, 0) + fine_peak(cut) * sonar.beam_spacing_rad);
    CHECK(peak_deg == Approx(44.14).margin(0.02));
  }
}

TEST_CASE("a beam's width grows as the projected aperture shrinks", "[figure]") {
  for (const ArrayBackend& kind : kArrayBackends) {
    INFO(kind.name);
    const Sonar sonar = line_array(101, 641, 641 * 0.2, 4, 6e3);
    const double range_m = sample_range_m(sonar, {1500, 0}, 28);
    const auto width_at = [&](double azimuth_deg) {
      return width_deg(sonar, beam_cut(kind, sonar, target_at(sonar, azimuth_deg, 0, range_m)));
    };
    const double broadside = width_at(0);
    for (const double azimuth_deg : {30.0, 45.0, 60.0}) {
      CHECK(width_at(azimuth_deg) / broadside ==
            Approx(1 / std::cos(radians(azimuth_deg))).epsilon(0.02));
    }
  }
}

// Side lobes are those of the continuous line of the same shading: hann -31.47 dB, taylor and
// chebyshev as asked for (Taylor's first one lies a little lower).
TEST_CASE("shading lowers an array's side lobes", "[figure]") {
  for (const ArrayBackend& kind : kArrayBackends) {
    for (const auto& [shading, lobe_db] :
         {std::pair{BeamShading{Shading::hann}, -31.47},
          std::pair{BeamShading{Shading::taylor, -35, 5}, -35.2},
          std::pair{BeamShading{Shading::chebyshev, -30}, -30.0}}) {
      INFO(kind.name << ", " << name_of(shading.kind));
      Sonar sonar = line_array(101, 201, 201 * 0.1, 4, 6e3);
      sonar.array->shading = shading;
      const double range_m = sample_range_m(sonar, {1500, 0}, 28);
      const std::vector<double> cut = beam_cut(kind, sonar, target_at(sonar, 0, 0, range_m));
      CHECK(highest_lobe_db(cut) == Approx(lobe_db).margin(0.2));
    }
  }
}

TEST_CASE("a dead element and errors of gain and phase change the peak by their sum") {
  for (const ArrayBackend& kind : kArrayBackends) {
    INFO(kind.name);
    Sonar sonar = line_array(20, 3, 3, 3);
    const Scatterer target = target_at(sonar, 0, 0, sample_range_m(sonar, {1500, 0}, 100));
    const double sound = beam_cut(kind, sonar, target)[1];
    sonar.array->response[7] = 0;
    CHECK(decibels(beam_cut(kind, sonar, target)[1] / sound) ==
          Approx(decibels(19.0 / 20)).margin(1e-4));
    sonar.array->response[7] = std::polar(0.5, 2.0);
    const double expected = std::abs(19.0 + std::polar(0.5, 2.0)) / 20;
    CHECK(beam_cut(kind, sonar, target)[1] / sound == Approx(expected).epsilon(1e-4));
  }
}

// An element of a wavelength's width hears an echo from 40 degrees by sinc(sin 40) only.
TEST_CASE("wide elements hear less from the side") {
  for (const ArrayBackend& kind : kArrayBackends) {
    INFO(kind.name);
    Sonar sonar = line_array(20, 3, 120, 3);
    const Scatterer target = target_at(sonar, 40, 0, sample_range_m(sonar, {1500, 0}, 100));
    const double all_round = beam_cut(kind, sonar, target)[2];
    sonar.array->element_width_m = kWavelengthM;
    CHECK(beam_cut(kind, sonar, target)[2] / all_round ==
          Approx(sinc(std::sin(radians(40)))).epsilon(1e-4));
  }
}

// A bounced path's sound comes from where it seems to: bent wavefronts of its own received length,
// whatever its delay.
TEST_CASE("the wavefront's curvature is that of the received path") {
  for (const ArrayBackend& kind : kArrayBackends) {
    INFO(kind.name);
    Sonar sonar = line_array(101, 3, 3, 2.5, 30e3);
    sonar.array->focus = Focus::none;
    Scatterer near = target_at(sonar, 0, 0, 1), late = target_at(sonar, 0, 0, 2);
    late.received_path_m = near.received_path_m;
    CHECK(beam_cut(kind, sonar, late)[1] == Approx(beam_cut(kind, sonar, near)[1]).epsilon(1e-4));
  }
}
