#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "catch.h"
#include "core/random.h"
#include "core/units.h"
#include "labels/cartesian.h"
#include "labels/polar.h"
#include "polar_fixture.h"

using namespace ensonify;

namespace {

constexpr double kBandwidth_hz = 1024;      // delays of whole samples are exact
constexpr int kBeams = 37, kSamples = 301;  // no multiple of any block
constexpr std::size_t kCells = std::size_t{kBeams} * kSamples;

// Bursts of echoes between long silences; every third lies on a sample, where its reach ends just
// on its neighbours, and some lie before or after the record or have no energy.
ScattererList random_echoes(std::uint64_t seed) {
  std::vector<Scatterer> items;
  for (std::uint32_t i = 0; i < 900; ++i) {
    const auto draw = [&](std::uint32_t what) { return uniform(seed, 1, i, what); };
    Scatterer s;
    s.beam = static_cast<std::uint32_t>(draw(0) * kBeams);
    const double burst = std::floor(draw(1) * 8) * 43;
    const double sample = burst + draw(2) * 6 - 2;
    s.delay_s = (i % 3 == 0 ? std::floor(sample) : sample) / kBandwidth_hz;
    s.instance = 1 + static_cast<std::uint32_t>(draw(3) * 3);
    s.gain = 1;
    // Few energies, so that sums tie.
    s.standard_deviation = static_cast<float>(std::floor(draw(4) * 4));
    s.arrival.elevation_rad = static_cast<float>(draw(5) - 0.5);
    s.key = i;
    items.push_back(s);
  }
  return sorted_by_beam_and_delay(std::move(items), kBeams);
}

VolumeEcho random_volume(std::uint64_t seed) {
  VolumeEcho volume;
  volume.instance = 4;
  for (std::uint32_t cell = 0; cell < kCells; ++cell) {
    const auto draw = [&](std::uint32_t what) { return uniform(seed, 2, cell, what); };
    volume.energy.push_back(draw(0) < 0.1 ? static_cast<float>(std::ceil(draw(1) * 4)) : 0.0f);
    const double mean = draw(2) - 0.5;
    volume.elevation_rad.push_back(static_cast<float>(mean));
    volume.elevation_square.push_back(static_cast<float>(mean * mean + 0.01 * draw(3)));
  }
  return volume;
}

// One pixel by the words of labels/polar.h: every echo of the ping is asked.
struct Plain {
  std::map<std::uint32_t, double> energy_of;
  double energy = 0, first = 0, second = 0;

  void add(std::uint32_t instance, double e, double mean, double square) {
    if (!(e > 0)) return;
    energy_of[instance] += e;
    energy += e, first += e * mean, second += e * square;
  }
  std::uint32_t winner() const {
    std::uint32_t best = 0;
    double most = 0;
    for (const auto& [instance, e] : energy_of) {
      if (e > most) best = instance, most = e;
    }
    return best;
  }
};

Plain plain_pixel(const PolarInput& input, int beam, int sample) {
  Plain pixel;
  for (const Scatterer& s : input.scatterers->items) {
    const double off = s.delay_s * kBandwidth_hz - sample;
    if (int(s.beam) != beam || std::abs(off) > 1) continue;
    const double elevation = s.arrival.elevation_rad;
    pixel.add(s.instance, double(s.standard_deviation) * s.standard_deviation, elevation,
              elevation * elevation);
  }
  for (const VolumeEcho& v : input.volumes) {
    for (int n = std::max(0, sample - 1); n <= std::min(kSamples - 1, sample + 1); ++n) {
      const std::size_t cell = std::size_t(beam) * kSamples + n;
      pixel.add(v.instance, v.energy[cell] * (n == sample ? 1.0 : 0.5), v.elevation_rad[cell],
                v.elevation_square[cell]);
    }
  }
  return pixel;
}

struct Ping : test::PolarPing {
  Ping(std::uint64_t seed, bool with_volume)
      : PolarPing({}, kBeams, kSamples, kBandwidth_hz, {0, 7, 8, 9, 10}) {
    list = random_echoes(seed);
    if (with_volume) volumes.push_back(random_volume(seed));
    input.volumes = volumes;
    for (std::uint32_t i = 0; i < kCells; ++i) {
      pressure[i] = {float(uniform(seed, 3, i, 0)), float(uniform(seed, 3, i, 1))};
      clean[i] = float(uniform(seed, 3, i, 2));
    }
    input.noise_power_pa2 = 0.25;
  }
};

void check_pixel(const Ping& ping, const LabelledImage& image, int beam, int sample) {
  const std::size_t at = std::size_t(sample) * kBeams + beam;
  const std::size_t cell = std::size_t(beam) * kSamples + sample;
  const Plain plain = plain_pixel(ping.input, beam, sample);
  INFO("beam " << beam << " sample " << sample);
  REQUIRE(std::abs(image.clean_db[at] - level_db(ping.clean[cell])) < 3e-5);
  const double power = std::norm(std::complex<double>(ping.pressure[cell]));
  REQUIRE(std::abs(image.level_db[at] - level_db(power)) < 3e-5);
  REQUIRE(std::isnan(image.elevation_rad[at]) == !(plain.energy > 0));
  REQUIRE(std::isnan(image.elevation_std_rad[at]) == !(plain.energy > 0));
  const bool seen = plain.energy > 0 && ping.clean[cell] >= ping.input.noise_power_pa2;
  const std::uint32_t winner = seen ? plain.winner() : 0;
  REQUIRE(image.instance[at] == winner);
  REQUIRE(image.semantic[at] == ping.classes[winner]);
  const double fraction = seen ? plain.energy_of.at(winner) / plain.energy : 0;
  REQUIRE(image.instance_fraction[at] == Approx(fraction));
  if (!(plain.energy > 0)) return;
  const double mean = plain.first / plain.energy;
  const double variance = std::max(0.0, plain.second / plain.energy - mean * mean);
  REQUIRE(image.elevation_rad[at] == Approx(mean).margin(1e-7));
  // The plain variance is a difference of squares: good to 1e-16, its root to 1e-8.
  REQUIRE(image.elevation_std_rad[at] == Approx(std::sqrt(variance)).margin(1e-7));
}

}  // namespace

// Protects the blocks, windows and leaps over silence of the image: every pixel is what the words
// of the header say, with and without a volume, for any number of threads.
TEST_CASE("every pixel of a random ping follows the definition") {
  for (const bool with_volume : {false, true}) {
    const Ping ping(5 + with_volume, with_volume);
    const LabelledImage image = polar_image(ping.input, Workers(3));
    const auto hears = hears_echo(ping.list, ping.volumes, kBandwidth_hz, kBeams, kSamples);
    int ties = 0, mixed = 0, silent = 0;
    for (int beam = 0; beam < kBeams; ++beam) {
      for (int sample = 0; sample < kSamples; ++sample) {
        check_pixel(ping, image, beam, sample);
        const Plain plain = plain_pixel(ping.input, beam, sample);
        REQUIRE((hears[std::size_t(beam) * kSamples + sample] == 1) == (plain.energy > 0));
        mixed += plain.energy_of.size() > 1;
        silent += plain.energy_of.empty();
        const auto most = plain.energy_of.find(plain.winner());
        ties += std::any_of(plain.energy_of.begin(), plain.energy_of.end(), [&](const auto& e) {
          return e.first != most->first && e.second == most->second;
        });
      }
    }
    CHECK(ties > 20);
    CHECK(mixed > 100);
    CHECK(silent > 1000);
    CHECK(polar_image(ping.input, Workers(1)).instance_fraction == image.instance_fraction);
  }
}

// Protects the short logarithm over all that a float holds, and its edges.
TEST_CASE("levels of images are levels") {
  double worst = 0;
  for (int i = 0; i < 200000; ++i) {
    const auto power = static_cast<float>(std::pow(10.0, -21.8 + 60.0 * i / 200000));
    worst = std::max(
        worst, std::abs(double(image_level_db(power)) - (10 * std::log10(double(power)) + 120)));
  }
  CHECK(worst < 3e-5 * 3);  // a float's step is 3e-5 dB above 256 dB
  for (const float none : {0.0f, -0.0f, -1.0f, 1e-40f, 1e-22f, std::nanf(""),
                           -std::numeric_limits<float>::infinity()}) {
    CHECK(image_level_db(none) == kNoEnergyDb);
  }
  CHECK(image_level_db(1.3e-22f) == Approx(level_db(1.3e-22f)).margin(3e-5));
  CHECK(image_level_db(std::numeric_limits<float>::infinity()) == Approx(505.4).margin(0.1));
}

// Protects the picture's tiles: each pixel holds all that the polar pixel of the map holds.
TEST_CASE("each pixel of the picture is the polar pixel that the map names") {
  const Ping ping(9, true);
  const LabelledImage polar = polar_image(ping.input, Workers(1));
  CartesianGrid grid;
  grid.height_px = 150;
  grid.width_px = 203;
  std::vector<std::int32_t> map;
  for (std::uint32_t i = 0; i < 150u * 203u; ++i) {
    const double u = uniform(9, 4, i, 0);
    map.push_back(u < 0.3 ? -1 : static_cast<std::int32_t>((u - 0.3) / 0.7 * kCells));
  }
  const LabelledImage image = resample(polar, grid, map);
  const auto same = [](float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); };
  REQUIRE(image.level_db.size() == map.size());
  for (std::size_t i = 0; i < map.size(); ++i) {
    const bool in = map[i] >= 0;
    const std::size_t from = in ? map[i] : 0;
    const float nan = std::nanf("");
    REQUIRE(image.level_db[i] == (in ? polar.level_db[from] : kNoEnergyDb));
    REQUIRE(image.clean_db[i] == (in ? polar.clean_db[from] : kNoEnergyDb));
    REQUIRE(same(image.elevation_rad[i], in ? polar.elevation_rad[from] : nan));
    REQUIRE(same(image.elevation_std_rad[i], in ? polar.elevation_std_rad[from] : nan));
    REQUIRE(image.instance_fraction[i] == (in ? polar.instance_fraction[from] : 0));
    REQUIRE(image.instance[i] == (in ? polar.instance[from] : 0));
    REQUIRE(image.semantic[i] == (in ? polar.semantic[from] : 0));
  }
}

// Protects volumes of one kind from being cells of one another: each wins with its own energy.
TEST_CASE("volumes compete with each other by instance") {
  test::PolarPing scene({}, 1, 5, kBandwidth_hz, {0, 5, 6, 5});
  scene.volumes = {test::empty_volume(2, 5), test::empty_volume(3, 5)};
  scene.volumes[0].energy = {0, 2, 0, 2, 0};
  scene.volumes[1].energy = {0, 0, 1.5f, 0, 0};
  const LabelledImage image = scene.image();
  CHECK(image.instance[2] == 2);  // 1 + 1 against 1.5
  CHECK(image.instance_fraction[2] == Approx(2 / 3.5));
  CHECK(image.semantic[2] == 6);
}

// Protects the spread inside a cell, which its mean does not show, and empty cells of a volume from
// lending their elevation.
TEST_CASE("elevation takes in a volume's mean and spread") {
  test::PolarPing scene({test::direct_echo(0, 5, 1, 1, 0.1)}, 1, 10, test::kMeterBandwidth_hz,
                        {0, 5, 6, 5});
  scene.volumes = {test::empty_volume(2, 10)};
  VolumeEcho& water = scene.volumes[0];
  water.energy[5] = 2;
  water.elevation_rad[5] = -0.05f;
  water.elevation_square[5] = 0.0125f;
  water.energy[6] = 2;
  water.elevation_rad[6] = 0.02f;
  water.elevation_square[6] = 0.0004f;
  water.elevation_rad[4] = std::nanf("");
  const LabelledImage image = scene.image();
  // Energies 1, 2 and 1 (half of cell 6).
  const double mean = (0.1 - 2 * 0.05 + 0.02) / 4;
  const double square = (0.01 + 2 * 0.0125 + 0.0004) / 4;
  CHECK(image.elevation_rad[5] == Approx(mean));
  CHECK(image.elevation_std_rad[5] == Approx(std::sqrt(square - mean * mean)));
  CHECK(image.elevation_rad[7] == Approx(0.02));
  CHECK(image.elevation_std_rad[7] == Approx(0).margin(1e-5));
  CHECK(std::isnan(image.elevation_rad[8]));
}

TEST_CASE("first return is the nearest echo of a sector") {
  std::vector<Scatterer> echoes{test::direct_echo(2, 9, 1, 1), test::direct_echo(2, 4, 2, 1)};
  for (Scatterer& s : echoes) s.position_m = {s.delay_s * test::kMeterBandwidth_hz, 0, 0};
  const std::vector<float> first = first_return_m(sorted_by_beam_and_delay(echoes, 3), 3);
  CHECK(std::isnan(first[0]));
  CHECK(first[2] == Approx(4));
}
