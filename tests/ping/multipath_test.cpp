// Bounced echoes from a scenario to the files of a data set.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <span>

#include "catch.h"
#include "core/units.h"
#include "formats/json.h"
#include "ping/layers.h"
#include "results.h"
#include "run/cost.h"
#include "run/small_data_set.h"
#include "run_scene.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

// A ball over sand in a metre and a half of water.
const std::string kShallow = R"(ensonify: 1
name: shallow
seed: 3
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 7
  beams: {count: 32, fov_deg: 32}
  elevation: {width_deg: 30, fan_deg: 50}
  rays: {elevation: 300}
materials:
  sand: {reflectivity: 1e-3}
  steel: {reflectivity: 1e-1}
objects:
  - {name: seabed, class: ground, material: sand, shape: {plane: {}}, pose: {position_m: [0, 0, -0.8]}}
  - {name: ball, class: ball, material: steel, shape: {sphere: {radius_m: 0.2}}, pose: {position_m: [4, 0, 0]}}
point_targets: [{name: tip, target_strength_db: -30, position_m: [3, 0.4, 0.1]}]
trajectory: {ping_rate_hz: 5, pings: 2}
)";
const std::string kSurface = "multipath: {surface: {z_m: 0.7, reflection: -1}}\n";
const std::string kOutput =
    "output: {layers: true, scatterers: true, cartesian: {height_px: 80}}\n";

double energy_of(std::span<const std::complex<float>> samples) {
  double sum = 0;
  for (const auto p : samples) sum += std::norm(std::complex<double>(p));
  return sum;
}

}  // namespace

// Protects the layer: bounced echoes are in it alone, and layers still add up.
TEST_CASE("bounced echoes have a layer of their own") {
  const SceneRun plain = SceneRun::of_text(kShallow + kOutput);
  const SceneRun run = SceneRun::of_text(kShallow + kSurface + kOutput);
  const PingResult without = plain.ping(0), with = run.ping(0);
  REQUIRE(with.layers.size() == without.layers.size() + 1);
  CHECK(with.layers.back().layer == Layer::multipath);
  CHECK(energy_of(with.layers.back().pressure_pa) > 1e-4 * energy_of(with.series));
  CHECK(std::sqrt(energy_of(remainder(with.series, with.layers)) / energy_of(with.series)) < 1e-6);
  for (std::size_t i = 0; i < without.layers.size(); ++i) {
    CHECK(with.layers[i].layer == without.layers[i].layer);
    double apart = 0;
    for (std::size_t k = 0; k < with.series.size(); ++k) {
      apart += std::norm(std::complex<double>(with.layers[i].pressure_pa[k]) -
                         std::complex<double>(without.layers[i].pressure_pa[k]));
    }
    // What the backend's rounding leaves is given to the strongest layer, sample by sample.
    CHECK(std::sqrt(apart / energy_of(without.layers[i].pressure_pa)) < 2e-5);
  }
}

// Protects labels: mirrors change none but the share, and ghosts are in their own mask.
TEST_CASE("ghosts are labelled as ghosts alone") {
  const PingResult without = SceneRun::of_text(kShallow + kOutput).ping(0);
  const SceneRun run = SceneRun::of_text(kShallow + kSurface + kOutput);
  const PingResult with = run.ping(0);
  CHECK(with.polar->instance == without.polar->instance);
  CHECK(with.polar->semantic == without.polar->semantic);
  CHECK(with.polar->shadow == without.polar->shadow);
  CHECK(with.first_return_m == without.first_return_m);
  CHECK(with.cartesian->instance == without.cartesian->instance);
  CHECK(without.polar->multipath.empty());
  const LabelledImage& image = *with.polar;
  REQUIRE(image.multipath.size() == image.instance.size());
  std::size_t ghosts = 0, less = 0;
  for (std::size_t i = 0; i < image.instance.size(); ++i) {
    const float before = without.polar->instance_fraction[i], after = image.instance_fraction[i];
    CHECK_FALSE(after > before * (1 + 1e-6f));
    less += after < before;
    if (image.multipath[i] == 0) continue;
    ++ghosts;
    CHECK(after < 0.5f);
  }
  CHECK(ghosts > 20);
  CHECK(less > 20);
  // The ball's image stands 1.4 m above it. Over the surface both ways the ball is heard from 4.04
  // m on, where the ball itself is past.
  const double way_m = std::hypot(4, 1.4) - 0.2;
  const auto sample =
      static_cast<std::size_t>(std::lround(way_m * 2 * run.session().sonar.bandwidth_hz / 1500));
  std::set<std::uint16_t> near;
  for (std::size_t n = sample + 1; n <= sample + 4; ++n) near.insert(image.multipath[n * 32 + 16]);
  CHECK(near.contains(2));
}

// Protects draws: the direct echoes have those that they have without mirrors.
TEST_CASE("mirrors change nothing in the direct echoes") {
  const PingResult without = SceneRun::of_text(kShallow + kOutput).ping(0);
  const SceneRun run = SceneRun::of_text(kShallow + kSurface + kOutput);
  const PingResult with = run.ping(0), again = run.ping(0, 1);
  CHECK(again.series == with.series);
  std::size_t direct = 0;
  for (std::size_t i = 0; i < with.scatterers.size(); ++i) {
    const Scatterer& s = with.scatterers.items[i];
    CHECK(s.path <= 3);
    if (s.path != 0) continue;
    REQUIRE(direct < without.scatterers.size());
    CHECK(s.key == without.scatterers.items[direct].key);
    CHECK(with.amplitudes[i] == without.amplitudes[direct]);
    ++direct;
  }
  CHECK(direct == without.scatterers.size());
  CHECK(with.scatterers.size() > direct + 500);
}

// Protects the files: all kinds there, verified, packed or not, on any number of threads.
TEST_CASE("a data set with bounced echoes is whole") {
  Maker maker;
  const std::string text = kShallow + kSurface + kOutput;
  maker.scenario = maker.folder.write("shallow.yaml", text + "noise: {spectrum_level_db: 20}\n");
  const auto files = maker.make(maker.options("files"));
  const std::string folder = "sequences/000000/";
  for (const char* name : {"polar/000001_multipath.png", "cartesian/000000_multipath.png",
                           "layers/000001_multipath.npy"}) {
    CHECK(files.contains(folder + name));
  }
  CHECK(contains(files.at("README.md"), "_multipath.png"));
  const auto json = value_of(parse_json(files.at(folder + "sequence.json")));
  CHECK(json["multipath"]["surface"]["z_m"] == 0.7);
  CHECK(json["multipath"]["bottom"].is_null());
  REQUIRE(json["paths"].size() == 3);
  CHECK(json["paths"][1].dump() == R"({"id":2,"out":["surface"],"back":[]})");
  GenerateOptions one = maker.options("one_thread");
  one.threads = 1;
  CHECK(maker.make(one) == files);
  maker.scenario = maker.folder.write(
      "packed.yaml", text.substr(0, text.rfind("}")) + ", one_file_per: sequence}\n");
  const auto packed = maker.make(maker.options("packed"));
  for (const char* name :
       {"polar_multipath.npy", "cartesian_multipath.npy", "layers_multipath.npy"}) {
    CHECK(packed.contains(folder + name));
  }
}

TEST_CASE("a damaged mask of bounced echoes is found") {
  Maker maker;
  maker.scenario = maker.folder.write("shallow.yaml", kShallow + kSurface + kOutput);
  const GenerateOptions options = maker.options("out");
  maker.make(options);
  std::filesystem::remove(options.output / "sequences/000000/polar/000000_multipath.png");
  check_fails(verified(options.output), {"000000_multipath.png"});
}

TEST_CASE("a sonar out of the water is an error") {
  const auto message = [](const std::string& multipath) {
    auto scenario = value_of(parse_scenario(kShallow + multipath, "shallow.yaml", "."));
    return message_of(prepare_session(std::move(scenario), 0));
  };
  CHECK(message(kSurface).empty());
  CHECK(message("multipath: {surface: {z_m: -0.1, reflection: -1}}\n")
            .find("multipath.surface.z_m: at ping 0 the sonar is at z = 0 m, not below the surface "
                  "at -0.1 m") == 0);
  CHECK(message("multipath: {bottom: {z_m: 0, reflection: 1}}\n")
            .find("multipath.bottom.z_m: at ping 0") == 0);
}

// Protects the phase between both ways round: a sonar that moves meets them at two places.
TEST_CASE("both ways round are one echo only where nothing moves") {
  const std::string key = "motion_within_ping: true\n";
  const auto pairs_of = [&](const std::string& scene, const std::string& more) {
    const SceneRun run = SceneRun::of_text(scene + kSurface + kOutput + more);
    std::map<std::uint64_t, int> by_key;
    const PingResult ping = run.ping(0);
    for (const Scatterer& s : ping.scatterers.items) {
      if (s.path != 0 && s.standard_deviation > 0) ++by_key[s.key];
    }
    return std::ranges::count_if(by_key, [](const auto& both) { return both.second > 1; });
  };
  CHECK(pairs_of(kShallow, key) == 0);
  std::string moving = kShallow;
  const std::string still = "trajectory: {ping_rate_hz: 5, pings: 2}";
  moving.replace(moving.find(still), still.size(),
                 "trajectory: {poses: [{time_s: 0}, {time_s: 1, position_m: [1, 0, 0.2]}], "
                 "ping_rate_hz: 5, pings: 2}");
  CHECK(pairs_of(moving, "") == 0);
  CHECK(pairs_of(moving, key) > 100);
}

// Protects what `check` announces: as many scatterers as a ping has, bounced echoes among them.
TEST_CASE("the echoes of a ping are counted before they are made") {
  std::string array = kShallow;
  const std::string beams = "  beams: ";
  array.replace(array.find(beams), beams.size(), "  receiver: {mode: array}\n  beams: ");
  const auto counted_and_made = [](const std::string& scene) {
    const SceneRun run = SceneRun::of_text(scene + kSurface + kOutput);
    const EchoCounts counts = count_echoes(run.session(), Tracer(run.session().world));
    return std::pair(counts.surface + counts.coherent, run.ping(0).scatterers.size());
  };
  const auto [counted, made] = counted_and_made(array);
  CHECK(counted == made);
  // Sectors make one of both ways round, after both were in memory.
  const auto [apart, together] = counted_and_made(kShallow);
  CHECK(apart == made);
  CHECK(together < apart);
}
