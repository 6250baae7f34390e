// Layers of a series: what they hold, and that they add up.
#include "ping/layers.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include "catch.h"
#include "ping/pipeline.h"
#include "ping/prepare_session.h"
#include "ping/sequence_info.h"
#include "ping/session.h"
#include "run/small_data_set.h"
#include "run_scene.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

using Samples = Series;

const std::string kHead = R"(ensonify: 1
seed: 5
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 4
  beams: {count: 48, fov_deg: 48}
  rays: {elevation: 16}
output: {layers: true, cartesian: false, png: false}
)";
const std::string kRoom = R"(materials:
  wall: {reflectivity: 1e-3}
  mirror: {reflectivity: 1e-2, coherent: {model: kirchhoff, reflection: 0.8, roughness_rms_m: 1e-4}}
  glint: {reflectivity: 1e-2, coherent: {model: rician, k: 2}}
objects:
  - {name: room, class: structure, material: wall, shape: {box: {size_m: [7, 7, 3], inward_facing: true}}}
  - {name: ball, class: ball, material: mirror, shape: {sphere: {radius_m: 0.3}}, pose: {position_m: [1.5, 0, 0]}}
  - {name: post, class: post, material: glint, shape: {cylinder: {radius_m: 0.1, height_m: 2}}, pose: {position_m: [2, 0.6, 0]}}
point_targets: [{name: tip, target_strength_db: -30, position_m: [1, 0.3, 0]}]
)";
const std::string kNoise = "noise: {spectrum_level_db: 60}\n";
const std::string kWater =
    "volumes:\n  - {name: water, uniform: {strength_db: -50}}\n"
    "  - {name: herring, pose: {position_m: [2.5, -0.5, 0]}, school: {size_m: [1, 1, 1], fish: 40, "
    "target_strength_db: -40}}\n";

PingResult layered(const std::string& text, const std::vector<Override>& overrides = {},
                   BackendChoice backend = BackendChoice::cpu) {
  return SceneRun::of_text(text, overrides, {backend, best_simd_level(), "test"}).ping(0);
}

std::vector<std::string> names_of(const PingResult& ping) {
  std::vector<std::string> names;
  for (const LayerSeries& layer : ping.layers) names.emplace_back(layer_name(layer.layer));
  return names;
}

const Samples& layer_of(const PingResult& ping, Layer layer) {
  for (const LayerSeries& series : ping.layers) {
    if (series.layer == layer) return series.pressure_pa;
  }
  FAIL("no layer " << layer_name(layer));
  return ping.series;
}

double energy(const Samples& samples) {
  double sum = 0;
  for (const auto p : samples) sum += std::norm(std::complex<double>(p));
  return sum;
}

// ||whole - sum of layers|| / ||whole||
double misfit(const PingResult& ping) {
  return std::sqrt(energy(remainder(ping.series, ping.layers)) / energy(ping.series));
}

}  // namespace

// Protects the promise of layers, over everything that makes a series: diffuse and mirror echoes,
// point targets, fish, water, noise and a converter.
TEST_CASE("layers add up to the series", "[figure]") {
  const std::string adc = "sonar.receiver.adc";
  const std::vector<Override> converter = {{adc, "{bits: 12, full_scale_db: 190}"}};
  const struct {
    std::string text;
    std::vector<Override> overrides;
    std::vector<std::string> layers;
  } cases[] = {{kHead + kRoom, {}, {"target", "background"}},
               {kHead + kRoom + kNoise, {}, {"noise", "target", "background"}},
               {kHead + kRoom + kWater, {}, {"volume", "target", "background"}},
               {kHead + kWater, {}, {"volume"}},
               {kHead + kNoise, {}, {"noise"}},
               {kHead + kRoom + kNoise + kWater,
                converter,
                {"noise", "volume", "target", "background", "quantisation"}},
               {kHead + kRoom + "noise: {spectrum_level_db: 60, correlated: true}\n",
                {},
                {"noise", "target", "background"}},
               {kHead + kRoom + kNoise,
                {{adc, "{bits: 12, full_scale_db: 190}"},
                 {"sonar.electronics",
                  "{crosstalk_db: -20, beam_gain_error_db: 1, leakage: {level_db: 150}, "
                  "saturation: {level_db: 165, streak_db: -10}}"}},
                {"noise", "target", "background", "electronics"}}};
  for (const auto& scene : cases) {
    const PingResult ping = layered(scene.text, scene.overrides);
    CHECK(names_of(ping) == scene.layers);
    CHECK(energy(ping.series) > 0);
    for (const LayerSeries& layer : ping.layers) {
      INFO(layer_name(layer.layer));
      CHECK(energy(layer.pressure_pa) > 0);
    }
    CAPTURE(scene.text, misfit(ping));
    CHECK(misfit(ping) < 1e-6);
  }
}

// Protects from a receiver that leaves out one of them where the other is absent. The sum of the
// layers cannot show it, since the last layer is the remainder.
TEST_CASE("correlated noise and electronics reach the series, each without the other") {
  const double white = energy(layered(kHead + kNoise).series);
  const double shared =
      energy(layered(kHead + "noise: {spectrum_level_db: 60, correlated: true}\n").series);
  // Of 48 x 160 values: 0.6 % at one sigma, over 20 seeds.
  CHECK(shared / white == Approx(1).margin(0.03));
  // 190 dB at the start, against 105 dB.
  const std::vector<Override> leakage = {{"sonar.electronics", "{leakage: {level_db: 190}}"}};
  CHECK(energy(layered(kHead + kNoise, leakage).series) > 100 * white);
}

// Protects the sum where the backend is at its loosest and at its tightest, and by the reference.
TEST_CASE("layers add up whatever the tolerance and the backend", "[figure]") {
  const std::string text = kHead + kRoom + kNoise + kWater;
  for (const char* tolerance : {"1e-3", "1e-5", "1e-7"}) {
    const double worst = misfit(layered(text, {{"synthesis.tolerance", tolerance}}));
    CAPTURE(tolerance, worst);
    CHECK(worst < 1e-6);
  }
  const std::vector<Override> little = {{"sonar.range_max_m", "1.5"},
                                        {"sonar.beams", "{count: 8, fov_deg: 8}"}};
  CHECK(misfit(layered(text, little, BackendChoice::reference)) < 1e-6);
}

// Protects the sum and each layer where beams are sums of a few nodes that cancel, which a small
// fan has not: rounding is 9e-6 of the series there at the loosest tolerance. A layer may be off by
// that, no more: the remainder is not what makes the sum.
TEST_CASE("layers of a wide fan add up, and each is its own", "[figure]") {
  const std::vector<Override> loose = {{"sonar.beams", "{count: 512, fov_deg: 90}"},
                                       {"sonar.range_max_m", "3"},
                                       {"sonar.rays.elevation", "6"},
                                       {"synthesis.tolerance", "1e-3"}};
  const PingResult whole = layered(kHead + kRoom + kNoise, loose);
  CAPTURE(misfit(whole));
  CHECK(misfit(whole) < 1e-6);
  CHECK(layer_of(whole, Layer::noise) == layered(kHead + kNoise, loose).series);
  auto others = loose;
  others.push_back({"materials.wall", "{reflectivity: 0}"});
  const Samples alone = layered(kHead + kRoom, others).series;
  const Samples& target = layer_of(whole, Layer::target);
  Samples difference(alone.size());
  for (std::size_t i = 0; i < alone.size(); ++i) difference[i] = alone[i] - target[i];
  const double off = std::sqrt(energy(difference) / energy(whole.series));
  CAPTURE(off);
  CHECK(off < 3e-5);
}

// Protects the meaning of each layer: taken out of the world, everything else gives the same draws.
TEST_CASE("a layer is what is left when the others are taken from the world", "[figure]") {
  const PingResult whole = layered(kHead + kRoom + kNoise + kWater);
  const auto same = [](const Samples& a, const Samples& b) {
    Samples difference(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) difference[i] = a[i] - b[i];
    return std::sqrt(energy(difference) / energy(b));
  };
  // Nothing else draws noise, and what is not there adds exact zeros.
  CHECK(layer_of(whole, Layer::noise) == layered(kHead + kNoise).series);
  // A target strength of nothing, of materials that scatter nothing: the geometry stays.
  const std::string bare = kHead + kRoom;
  const PingResult walls = layered(bare, {{"materials.mirror", "{reflectivity: 0}"},
                                          {"materials.glint", "{reflectivity: 0}"},
                                          {"point_targets.0.target_strength_db", "-300"}});
  CHECK(same(layer_of(layered(bare), Layer::background), walls.series) < 1e-6);
  const PingResult things = layered(bare, {{"materials.wall", "{reflectivity: 0}"}});
  CHECK(same(layer_of(layered(bare), Layer::target), things.series) < 1e-6);
}

// Protects users from a series that changes because something more of it is written.
TEST_CASE("asking for layers does not change the series") {
  const std::string text = kHead + kRoom + kNoise + kWater;
  CHECK(layered(text).series == layered(text, {{"output.layers", "false"}}).series);
  CHECK(layered(text, {{"output.layers", "false"}}).layers.empty());
}

// Protects the converter's layer: within half a step where nothing is clipped.
TEST_CASE("the quantisation is what the converter rounds off") {
  const PingResult ping =
      layered(kHead + kRoom + kNoise, {{"sonar.receiver.adc", "{bits: 10, full_scale_db: 220}"}});
  const double step = 1e5 / 512;  // 220 dB re 1 uPa are 1e5 Pa
  double largest = 0;
  for (const auto q : layer_of(ping, Layer::quantisation)) {
    largest = std::max<double>({largest, std::abs(q.real()), std::abs(q.imag())});
  }
  CHECK(largest <= step / 2 * (1 + 1e-3));
  CHECK(largest > step / 4);
}

TEST_CASE("targets are all that ends and does not enclose, or what is named") {
  using Ids = std::vector<std::uint16_t>;
  const auto ids = [](const std::string& text, const std::string& layers) {
    return target_instances(
        value_of(parse_scenario(text, "layers.yaml", ".", {{"output.layers", layers}})));
  };
  const std::string scene = kHead + kRoom + kWater;
  CHECK(ids(scene, "true") == Ids{2, 3, 4});
  CHECK(ids(scene, "{targets: [ball]}") == Ids{2});
  CHECK(ids(scene, "{targets: [point_target, structure]}") == Ids{1, 4});
  CHECK(ids(scene, "{targets: []}") == Ids{});
  // The common name of objects with a count means all of them, an exact one only itself.
  const std::string rocks =
      kHead +
      "materials: {m: {reflectivity: 1}}\n"
      "objects: [{name: rock, count: 3, material: m, shape: {sphere: {radius_m: "
      "0.1}}}]\npoint_targets: [{name: rock_9x, target_strength_db: -40, "
      "position_m: [1, 0, 0]}]\n";
  CHECK(ids(rocks, "{targets: [rock]}") == Ids{1, 2, 3});
  CHECK(ids(rocks, "{targets: [rock_1]}") == Ids{2});
}

// Protects the files: one a layer and ping, listed, checked, and the same for any threads.
TEST_CASE("layers are written and verified") {
  const Maker maker;
  GenerateOptions o = maker.options("a");
  o.input.overrides = {{"output.layers", "true"}, {"output.timeseries", "both"}};
  const auto files = maker.make(o);
  for (const char* layer : {"noise", "target", "background"}) {
    const auto found = files.find("sequences/000000/layers/000002_" + std::string(layer) + ".npy");
    REQUIRE(found != files.end());
    CHECK(found->second.size() == files.at("sequences/000000/timeseries/000002.npy").size());
  }
  CHECK(files.count("sequences/000000/layers/000002_volume.npy") == 0);
  o.output = maker.folder.path() / "b";
  o.threads = 4;
  CHECK(maker.make(o) == files);
}
