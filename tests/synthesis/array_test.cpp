// Beams of a point target at an array of elements, on every backend that knows arrays. What line-array theory says
// of them, V12 and V13, is in tests/verification/line_array.py.
#include "synthesis/array_fixture.h"

#include "catch.h"

using namespace ensonify;
using namespace ensonify::test;

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
