#include "labels/cartesian_display.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "catch.h"
#include "core/units.h"
#include "labels/cartesian.h"

using namespace ensonify;

namespace {

const Water kStillWater{1500, 0};

// A sonar seen from above, and the levels of its polar image.
struct Seen {
  Sonar sonar;
  Record record;
  CartesianGrid grid;
  std::vector<std::int32_t> map;
  Footprints footprints;
  std::vector<float> level_db;

  // Beams of an unequal fan stand closer together in the middle.
  Seen(double fov_deg, int beams, int height_px, double bandwidth_hz = 30e3, bool unequal = false) {
    sonar.bandwidth_hz = bandwidth_hz;
    sonar.range_max_m = 10;
    sonar.beam_count = beams;
    sonar.beam_spacing_rad = radians(fov_deg) / beams;
    for (int j = 0; unequal && j < beams; ++j) {
      const double place = (j + 0.5) / beams * 2 - 1;  // from -1 to 1
      sonar.azimuth_rad.push_back(radians(fov_deg) / 2 * place * (0.7 + 0.3 * place * place));
    }
    record = make_record(sonar, kStillWater, 0);
    grid = cartesian_grid(sonar, height_px);
    map = cartesian_map(grid, sonar, kStillWater, record);
    footprints = ensonify::footprints(grid, sonar, kStillWater, record, map);
    level_db.assign(std::size_t(beams) * record.samples, 100);
  }

  DisplayTable table(const Display& display) const {
    return display_table(display, 0.5, sample_range_m(sonar, kStillWater, 1), record.samples);
  }
  std::vector<std::uint8_t> shown(const Display& display, double further_gain_db = 0) const {
    const DisplayTable shown_table = table(display);
    return displayed_cartesian(shown_table, footprints, cartesian_gains(shown_table, footprints),
                               further_gain_db, level_db)
        .pixels;
  }
  // Speckle over a mean level of 100 dB, from a congruential generator.
  void add_speckle() {
    std::uint32_t state = 1;
    for (float& level : level_db) {
      state = state * 1664525u + 1013904223u;
      const double draw = ((state >> 8) + 0.5) / (1 << 24);
      level = std::round(16 * static_cast<float>(100 + 10 * std::log10(-std::log(draw)))) / 16;
    }
  }
};

// A gray level a dB.
Display one_a_db() {
  Display display;
  display.limits_db = {0, 255};
  return display;
}

// Linear between the azimuths of neighbors.
double place_among_beams(const Sonar& sonar, double azimuth_rad) {
  const auto& azimuths = sonar.azimuth_rad;
  if (azimuths.empty()) return azimuth_rad / sonar.beam_spacing_rad + (sonar.beam_count - 1) / 2.0;
  std::size_t beam = 0;
  while (beam + 2 < azimuths.size() && azimuths[beam + 1] <= azimuth_rad) ++beam;
  return static_cast<double>(beam) +
         (azimuth_rad - azimuths[beam]) / (azimuths[beam + 1] - azimuths[beam]);
}

// What the head of the header says, in double precision: 10 log10 of the mean intensity at a place
// in the sonar's plane, plus gain.
double reference_db(const Seen& seen, double x, double y, const Display& display) {
  const int beams = seen.sonar.beam_count, samples = seen.record.samples;
  const double step_m = sample_range_m(seen.sonar, kStillWater, 1), range_m = std::hypot(x, y);
  const double at_sample = std::min(range_m / step_m, samples - 1.0);
  const double length = seen.grid.m_per_px / step_m;
  const double width = std::min<double>(
      seen.grid.m_per_px / (std::max(at_sample, 0.5) * step_m * seen.sonar.beam_spacing_rad),
      beams);
  const auto intensity = [&](double sample, double beam) {
    sample = std::clamp(sample, 0.0, samples - 1.0);
    beam = std::clamp(beam, 0.0, beams - 1.0);
    double sum = 0;
    for (int n = 0; n < samples; ++n) {
      const double along = 1 - std::abs(n - sample);
      for (int j = 0; along > 0 && j < beams; ++j) {
        const double weight = along * std::max(0.0, 1 - std::abs(j - beam));
        const float level = seen.level_db[std::size_t(n) * beams + j];
        if (weight > 0 && level > kNoEnergyDb) sum += weight * std::pow(10.0, level / 10);
      }
    }
    return sum;
  };
  const int m = std::max(1, static_cast<int>(std::ceil(length - 1e-6)));
  const int n = std::max(1, static_cast<int>(std::ceil(width - 1e-6)));
  const double at_beam =
      std::clamp(place_among_beams(seen.sonar, std::atan2(y, x)), 0.0, beams - 1.0);
  double sum = 0;
  for (int k = 0; k < m; ++k) {
    for (int j = 0; j < n; ++j) {
      sum += intensity(at_sample + length * ((k + 0.5) / m - 0.5),
                       at_beam + width * ((j + 0.5) / n - 0.5));
    }
  }
  const double own_m = std::max(std::min(range_m, (samples - 1) * step_m), step_m);
  return 10 * std::log10(sum / (m * n)) + display.gain_db + display.spreading * std::log10(own_m) +
         (display.absorption ? 2 * 0.5 * own_m : 0);
}

}  // namespace

// Protects the rule: every pixel of images whose beams and samples are sparser and denser than
// pixels, near and far, with and without gain. Fractions of a cell are kept in units of 2^-15.
TEST_CASE("Cartesian pixels show the mean intensity over their footprints") {
  Display display = one_a_db();
  display.limits_db = {60, 123.75};  // four gray levels a dB
  const bool with_gain = GENERATE(false, true);
  if (with_gain) {
    display.spreading = 20;
    display.absorption = true;
    display.gain_db = -15;
  }
  for (const auto& [fov_deg, beams, height_px, bandwidth_hz, unequal] :
       {std::tuple{90.0, 12, 60, 1e3, false},
        {90.0, 96, 30, 1e3, false},
        {200.0, 40, 21, 6e3, false},
        {60.0, 1, 17, 2e3, false},
        {120.0, 31, 40, 4e3, true},
        {90.0, 7, 4, 10e3, false},    // 33 samples a pixel
        {90.0, 5, 12, 74, false}}) {  // one sample
    Seen seen(fov_deg, beams, height_px, bandwidth_hz, unequal);
    CHECK((seen.record.samples == 1) == (bandwidth_hz == 74));
    seen.add_speckle();
    const auto pixels = seen.shown(display, display.gain_db);
    double largest = 0;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      if (seen.map[i] < 0) {
        largest = std::max<double>(largest, pixels[i]);
        continue;
      }
      const int row = static_cast<int>(i) / seen.grid.width_px;
      const int column = static_cast<int>(i) % seen.grid.width_px;
      const double x = seen.grid.x_top_m - (row + 0.5) * seen.grid.m_per_px;
      const double y = seen.grid.y_left_m - (column + 0.5) * seen.grid.m_per_px;
      const double gray = 4 * (reference_db(seen, x, y, display) - 60);
      largest = std::max(largest, std::abs(pixels[i] - std::clamp(gray, 0.0, 255.0)) - 0.5);
    }
    INFO(fov_deg << " degrees, " << beams << " beams, " << height_px << " rows");
    CHECK(largest < 0.01);
    CHECK(std::count(pixels.begin(), pixels.end(), 0) < std::ptrdiff_t(pixels.size()));
  }
}

// Protects the last bit far from the sonar, where azimuths follow from those of neighboring pixels.
TEST_CASE("places of pixels are those of the arc tangent") {
  const bool unequal = GENERATE(false, true);
  const Seen seen(150, 48, 400, 20e3, unequal);
  const Footprints& f = seen.footprints;
  const std::size_t narrow = f.beam_fraction.size();
  REQUIRE(narrow > 9 * f.to.size() / 10);
  CHECK(f.samples_per_px < 1);  // one part: the weights of two samples are the place of a pixel
  const auto place = [](double position, int count) {
    return std::floor(std::clamp(position, 0.0, count - 1.0) * (1 << kPlaceBits) + 0.5);
  };
  std::size_t different = 0;
  for (std::size_t i = 0; i < narrow; ++i) {
    const int row = f.to[i] / f.grid.width_px, column = f.to[i] % f.grid.width_px;
    const double x = f.grid.x_top_m - (row + 0.5) * f.grid.m_per_px;
    const double y = f.grid.y_left_m - (column + 0.5) * f.grid.m_per_px;
    const auto beam = (f.from[i] / f.line << kPlaceBits) + f.beam_fraction[i];
    const auto sample =
        (f.from[i] % f.line << kPlaceBits) + f.sample_weight[i * std::size_t(f.taps) + 1];
    const double range = std::sqrt(x * x + y * y) * f.samples_per_m;
    different += beam != place(beam_place(seen.sonar, std::atan2(y, x)), f.beams) ||
                 sample != place(range, f.samples);
  }
  CHECK(different == 0);
}

// Protects borders and the middle, where footprints leave the image: there is nothing but the
// level.
TEST_CASE("a level that is everywhere is seen everywhere in the fan") {
  for (const double fov_deg : {20.0, 130.0, 360.0}) {
    for (const int beams : {1, 2, 90, 512}) {
      for (const int height_px : {1, 50, 301}) {
        const Seen seen(fov_deg, beams, height_px);
        const auto pixels = seen.shown(one_a_db());
        std::size_t different = 0;
        for (std::size_t i = 0; i < pixels.size(); ++i) {
          different += pixels[i] != (seen.map[i] < 0 ? 0 : 100);
        }
        INFO(fov_deg << " degrees, " << beams << " beams, " << height_px << " rows");
        CHECK(different == 0);
      }
    }
  }
}

TEST_CASE("Cartesian pixels without energy are black, whatever the limits") {
  Seen seen(90, 8, 20);
  seen.level_db.assign(seen.level_db.size(), kNoEnergyDb);
  Display display;
  display.limits_db = {-1000, -900};
  const auto pixels = seen.shown(display, 1000);
  CHECK(std::all_of(pixels.begin(), pixels.end(), [](auto gray) { return gray == 0; }));
}

// Protects near ranges from the moire of skipped beams: where a pixel holds many beams it shows all
// of them. Every other beam is silent, which halves the mean: 3 dB.
TEST_CASE("beams that are denser than pixels are averaged") {
  Seen seen(90, 512, 50);
  for (std::size_t i = 0; i < seen.level_db.size(); i += 2) seen.level_db[i] = kNoEnergyDb;
  const auto pixels = seen.shown(one_a_db());
  std::size_t near = 0;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const int sample = seen.map[i] / 512;
    if (seen.map[i] < 0 || sample < 4 || sample > 40) continue;  // 8 beams a pixel and more
    ++near;
    CHECK(std::abs(pixels[i] - 97) <= 1);
  }
  CHECK(near > 10);
}

// Protects renders of untrusted data sets from undefined numbers and from work without end.
TEST_CASE("grids from files are no larger than their fan", "[figure]") {
  for (const double fov_deg : {1.0, 20.0, 130.0, 200.0, 360.0}) {
    for (const int height_px : {1, 50, 3001}) {
      const Seen seen(fov_deg, 90, height_px);
      INFO(fov_deg << " degrees, " << height_px << " rows");
      CHECK(is_grid_of_fan(seen.grid, seen.sonar, kStillWater, seen.record));
    }
  }
  const Seen seen(90, 90, 50);
  const auto fits = [&](auto change) {
    Sonar sonar = seen.sonar;
    CartesianGrid grid = seen.grid;
    change(sonar, grid);
    return is_grid_of_fan(grid, sonar, kStillWater, seen.record);
  };
  CHECK(fits([](Sonar&, CartesianGrid&) {}));
  CHECK_FALSE(fits([](Sonar&, CartesianGrid& grid) { grid.m_per_px *= 3; }));
  CHECK_FALSE(fits([](Sonar&, CartesianGrid& grid) { grid.m_per_px = 0; }));
  CHECK_FALSE(fits([](Sonar&, CartesianGrid& grid) { grid.m_per_px = -1; }));
  CHECK_FALSE(fits([](Sonar&, CartesianGrid& grid) { grid.m_per_px = 1e308; }));
  CHECK_FALSE(fits([](Sonar&, CartesianGrid& grid) { grid.width_px *= 2; }));
  CHECK_FALSE(fits([](Sonar& sonar, CartesianGrid&) { sonar.beam_spacing_rad = 0; }));
  CHECK_FALSE(fits([](Sonar& sonar, CartesianGrid&) { sonar.beam_spacing_rad /= 100; }));
  CHECK_FALSE(fits([](Sonar& sonar, CartesianGrid&) { sonar.bandwidth_hz = -1; }));
}

// Protects images of levels that no file holds, as the extension's are: the table of halves is a
// short cut. The loudest is near the largest float.
TEST_CASE("levels between those of half precision are as good") {
  Seen seen(90, 8, 20);
  for (const float level : {100.0001f, 0.3f, -5.01f, 255.99f, 300.0f, 365.0f}) {
    seen.level_db.assign(seen.level_db.size(), level);
    Display display;
    display.limits_db = {level - 100.0, level + 155.0};
    const auto pixels = seen.shown(display);
    std::size_t different = 0;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      different += seen.map[i] >= 0 && pixels[i] != 100;
    }
    CHECK(different == 0);
  }
}
