#include "labels/shadow.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "catch.h"
#include "core/random.h"
#include "labels/annotations.h"
#include "labels/cartesian.h"
#include "polar_fixture.h"

using namespace ensonify;

namespace {

constexpr double kShadowBandwidth_hz = 1024;  // delays of whole samples are exact

Scatterer shadow_echo(std::uint32_t beam, double sample, std::uint32_t instance, double energy) {
  Scatterer s;
  s.beam = beam;
  s.delay_s = sample / kShadowBandwidth_hz;
  s.instance = instance;
  s.gain = 1;
  s.standard_deviation = static_cast<float>(std::sqrt(energy));
  return s;
}

// One ping's echoes, heard and hidden, and what labels need beside them.
struct ShadowedScene : test::PolarPing {
  HiddenEchoes hidden;
  std::vector<double> power_per_energy, pulse_power;

  // The occluder of a hidden echo is its key.
  ShadowedScene(std::vector<Scatterer> heard_echoes, std::vector<Scatterer> hidden_echoes,
                int beams, int samples, double noise_power = 0)
      : PolarPing(std::move(heard_echoes), beams, samples, kShadowBandwidth_hz,
                  std::vector<std::uint8_t>(10, 1)),
        power_per_energy(beams, 1),
        pulse_power(kPulseSteps + 1, 1) {
    std::ranges::fill(clean, 1e3f);
    input.noise_power_pa2 = noise_power;
    hidden.list = sorted_by_beam_and_delay(std::move(hidden_echoes), beams);
    for (const Scatterer& s : hidden.list.items) {
      hidden.occluder.push_back(static_cast<std::uint32_t>(s.key));
    }
  }
  HiddenLabels labels(int threads = 2) {
    const LabelledImage polar = image();
    return hidden_labels({input, hidden, power_per_energy, pulse_power}, polar, Workers(threads));
  }
};

std::set<std::uint32_t> set_at(const InstanceSets& sets, std::size_t pixel) {
  const auto ids = sets.instances(sets.set[pixel]);
  return {ids.begin(), ids.end()};
}

// One pixel by the words of labels/shadow.h: every echo of the ping is asked.
struct PlainShadow {
  std::uint32_t shadow = 0;
  std::set<std::uint32_t> amodal;
};

PlainShadow plain_labels(const ShadowedScene& scene, const LabelledImage& image, int beam,
                         int sample) {
  std::map<std::uint32_t, double> kept_by, power_of;
  double heard = 0, hidden = 0, hidden_power = 0;
  const auto for_each = [&](const ScattererList& list, auto&& use) {
    for (std::size_t i = 0; i < list.size(); ++i) {
      const Scatterer& s = list.items[i];
      const double at = s.delay_s * kShadowBandwidth_hz;
      const double energy = std::pow(static_cast<double>(s.standard_deviation) * s.gain, 2);
      if (s.beam != static_cast<std::uint32_t>(beam) || !(energy > 0)) continue;
      if (at < sample - 1.0 || at > sample + 1.0) continue;
      const double step = std::round((sample - at + 1) * kPulseSteps / 2);
      const double power = energy * scene.pulse_power[static_cast<std::size_t>(step)];
      power_of[s.instance] += power;
      use(i, energy, power);
    }
  };
  for_each(scene.list, [&](std::size_t, double energy, double) { heard += energy; });
  for_each(scene.hidden.list, [&](std::size_t i, double energy, double power) {
    if (scene.hidden.occluder[i] == 0) return;
    kept_by[scene.hidden.occluder[i]] += energy;
    hidden += energy;
    hidden_power += power;
  });
  for (const VolumeEcho& volume : scene.volumes) {
    for (int n = std::max(0, sample - 1); n <= std::min(scene.input.samples - 1, sample + 1); ++n) {
      heard += volume.energy[std::size_t(beam) * scene.input.samples + n] * (n == sample ? 1 : 0.5);
    }
  }
  const double scale = scene.power_per_energy[beam], noise = scene.input.noise_power_pa2;
  PlainShadow plain;
  if (hidden > heard && hidden_power * scale >= noise) {
    double most = 0;
    for (const auto& [id, energy] : kept_by) {
      if (energy > most) {
        most = energy;
        plain.shadow = id;
      }
    }
  }
  for (const auto& [id, power] : power_of) {
    if (power * scale >= noise) plain.amodal.insert(id);
  }
  const std::uint16_t own = image.instance[std::size_t(sample) * image.columns + beam];
  if (own != 0) plain.amodal.insert(own);
  return plain;
}

std::vector<Scatterer> random_echoes(std::uint64_t seed, int beams, int samples, bool hidden) {
  std::vector<Scatterer> items;
  for (std::uint32_t i = 0; i < 700; ++i) {
    const auto draw = [&](std::uint32_t what) { return uniform(seed, hidden, i, what); };
    // Bursts between long silences; a third on a sample, where reaches end just on its neighbours.
    const double sample = std::floor(draw(1) * 8) / 8 * samples + draw(2) * 6 - 2;
    Scatterer s = shadow_echo(
        static_cast<std::uint32_t>(draw(0) * beams), i % 3 == 0 ? std::floor(sample) : sample,
        1 + static_cast<std::uint32_t>(draw(3) * 4), std::pow(std::floor(draw(4) * 4), 2));
    s.key = hidden ? static_cast<std::uint32_t>(draw(5) * 4) : i;
    items.push_back(s);
  }
  return items;
}

}  // namespace

// Protects every pixel against the rule's words, echo by echo, with and without noise and volumes,
// over blocks of beams that are not full; and the labels against the number of threads.
TEST_CASE("shadows and amodal sets are those of the plain rule") {
  const int beams = 37, samples = 301;
  const double noise = GENERATE(0.0, 3.0);
  const bool with_volume = GENERATE(false, true);
  ShadowedScene scene(random_echoes(5, beams, samples, false),
                      random_echoes(6, beams, samples, true), beams, samples, noise);
  for (int j = 0; j < beams; ++j) scene.power_per_energy[j] = 0.5 + 0.1 * (j % 7);
  for (int k = 0; k <= kPulseSteps; ++k) scene.pulse_power[k] = 1 - 0.4 * (k % 3);
  for (std::size_t i = 0; i < scene.clean.size(); ++i) scene.clean[i] = static_cast<float>(i % 5);
  if (with_volume) {
    VolumeEcho volume{5, {}, {}, {}};
    for (std::uint32_t i = 0; i < std::uint32_t(beams * samples); ++i) {
      volume.energy.push_back(uniform(7, 0, i, 0) < 0.1 ? 2.0f : 0.0f);
    }
    volume.elevation_rad.resize(volume.energy.size());
    volume.elevation_square.resize(volume.energy.size());
    scene.volumes.push_back(volume);
  }
  const LabelledImage image = scene.image();
  const HiddenLabels labels = scene.labels(3), alone = scene.labels(1);
  CHECK(labels.shadow == alone.shadow);
  CHECK(labels.amodal.set == alone.amodal.set);
  std::size_t shadows = 0, several = 0, differing = 0;
  for (int n = 0; n < samples; ++n) {
    for (int beam = 0; beam < beams; ++beam) {
      const std::size_t pixel = std::size_t(n) * beams + beam;
      const PlainShadow plain = plain_labels(scene, image, beam, n);
      differing += labels.shadow[pixel] != plain.shadow;
      differing += set_at(labels.amodal, pixel) != plain.amodal;
      shadows += plain.shadow != 0;
      several += plain.amodal.size() > 1;
    }
  }
  CHECK(differing == 0);
  CHECK(shadows > 50);
  CHECK(several > 50);
}

// Protects amodal masks: each instance's run lengths, box and area are those of a picture that
// shows it alone; one that is seen nowhere stands apart; both views.
TEST_CASE("amodal masks are those of pictures with one instance") {
  const int beams = 37, samples = 101;
  ShadowedScene scene(random_echoes(8, beams, samples, false),
                      random_echoes(9, beams, samples, true), beams, samples);
  // One that is seen nowhere.
  auto& items = scene.hidden.list.items;
  std::find_if(items.begin(), items.end(), [](const Scatterer& s) {
    return s.standard_deviation > 0 && s.delay_s * kShadowBandwidth_hz > 2;
  })->instance = 7;
  const LabelledImage polar = scene.image();
  const InstanceSets amodal = scene.labels().amodal;
  const CartesianGrid grid{20, 30, 1, 0, 0};
  std::vector<std::int32_t> map;
  for (std::int32_t i = 0; i < 600; ++i) map.push_back(i % 4 == 0 ? -1 : i * 5 % (beams * samples));
  const bool cartesian = GENERATE(false, true);
  InstanceSets sets = amodal;
  const LabelledImage image =
      cartesian ? resample(polar, grid, map, ResampledPlanes::all, &sets) : polar;
  std::vector<Annotation> visible = annotations(instance_runs(image));
  const std::vector<double> occlusion{0, 0.1, 0.2, 0.3, 0.4};
  const std::vector<Annotation> hidden = add_amodal(sets, occlusion, visible);
  const auto alone = [&](std::uint16_t id) {
    LabelledImage one;
    one.rows = sets.rows;
    one.columns = sets.columns;
    for (std::size_t pixel = 0; pixel < sets.set.size(); ++pixel) {
      one.instance.push_back(set_at(sets, pixel).contains(id) ? id : 0);
    }
    return annotations(instance_runs(one)).at(0);
  };
  REQUIRE(visible.size() == 4);
  for (const Annotation& annotation : visible) {
    const Annotation expected = alone(annotation.instance);
    REQUIRE(annotation.amodal);
    CHECK(annotation.amodal->rle_counts == expected.rle_counts);
    CHECK(annotation.amodal->box == expected.box);
    CHECK(annotation.amodal->area == expected.area);
    CHECK(annotation.amodal->area >= annotation.area);
    CHECK(annotation.occlusion == occlusion[annotation.instance]);
  }
  if (cartesian) return;
  REQUIRE(hidden.size() == 1);
  CHECK(hidden[0].instance == 7);
  CHECK(hidden[0].area == 0);
  CHECK(hidden[0].amodal->rle_counts == alone(7).rle_counts);
  CHECK(std::isnan(hidden[0].occlusion));
}
