// scattering.speckle: surface, from the scenario to the files.
#include <cmath>
#include <span>

#include "results.h"
#include "run/cost.h"
#include "run/memory.h"
#include "run/small_data_set.h"
#include "run_scene.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

GenerateOptions on_surfaces(const Maker& maker, const std::string& output) {
  GenerateOptions o = maker.options(output);
  o.input.overrides.push_back({"scattering.speckle", "surface"});
  return o;
}

// A box before the sonar, both along `way` at the same time.
std::string pair_text(const std::string& sonar_way, const std::string& box_way) {
  return R"(ensonify: 1
name: pair
seed: 3
sonar: {preset: paper_table1, bandwidth_hz: 29900, range_max_m: 4, beams: {count: 24, fov_deg: 24}, rays: {elevation: 8}}
scattering: {speckle: surface}
materials: {m: {reflectivity: 1e-3}}
objects:
  - {name: crate, material: m, shape: {box: {size_m: [0.5, 0.6, 0.4]}}, trajectory: {poses: [)" +
         box_way + R"(]}}
trajectory: {ping_rate_hz: 1, pings: 3, poses: [)" +
         sonar_way + "]}\n";
}

double distance(std::span<const std::complex<float>> a, std::span<const std::complex<float>> b) {
  double apart = 0, norm = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    apart += std::norm(a[i] - b[i]);
    norm += std::norm(a[i]);
  }
  return std::sqrt(apart / norm);
}

}  // namespace

// Protects V11 to the bytes of the files; the default draws each ping anew.
TEST_CASE("pings from the same pose have the same series") {
  const Maker maker;
  GenerateOptions quiet = on_surfaces(maker, "a");
  std::string text = kSmall;
  const std::string noise = "noise: {spectrum_level_db: 40}\n";
  text.erase(text.find(noise), noise.size());
  quiet.input.scenario = maker.folder.write("quiet.yaml", text);
  const auto files = maker.make(quiet);
  const std::string folder = "sequences/000000/";
  for (const char* kind : {"timeseries", "scatterers"}) {
    CHECK(files.at(folder + kind + "/000000.npy") == files.at(folder + kind + "/000003.npy"));
  }
  CHECK(contains(files.at(folder + "sequence.json"), "\"speckle\": \"surface\""));
}

// Protects shards: neither threads nor the range of pings that is asked for change a byte.
TEST_CASE("scatterers on surfaces do not depend on threads or on the range of pings") {
  const Maker maker;
  GenerateOptions moving = on_surfaces(maker, "whole");
  moving.input.overrides.push_back(
      {"trajectory",
       "{ping_rate_hz: 1, pings: 3, poses: [{time_s: 0, position_m: [0, 0, 0]}, "
       "{time_s: 3, position_m: [0.5, 0.2, 0]}]}"});
  const auto whole = maker.make(moving);
  GenerateOptions part = moving;
  part.output = maker.folder.path() / "part";
  part.pings = {2, 3};
  part.threads = 1;
  const std::string name = "sequences/000000/scatterers/000002.npy";
  CHECK(maker.make(part).at(name) == whole.at(name));
  CHECK(whole.at(name) != whole.at("sequences/000000/scatterers/000001.npy"));
}

// Protects objects that move: their speckle goes with them, and turns with them.
TEST_CASE("a sonar and a box that move together hear the same all the way") {
  const SceneRun together = SceneRun::of_text(
      pair_text("{time_s: 0, position_m: [0, 0, 0]}, {time_s: 3, position_m: [3, 1.5, 0.3]}",
                "{time_s: 0, position_m: [2, 0, 0]}, {time_s: 3, position_m: [5, 1.5, 0.3]}"));
  const auto first = together.ping(0).series;
  CHECK(distance(first, together.ping(1).series) < 1e-3);
  CHECK(distance(first, together.ping(2).series) < 1e-3);
  const SceneRun apart = SceneRun::of_text(
      pair_text("{time_s: 0, position_m: [0, 0, 0]}, {time_s: 3, position_m: [0, 0, 0]}",
                "{time_s: 0, position_m: [2, 0, 0]}, {time_s: 3, position_m: [2, 1.5, 0]}"));
  CHECK(distance(apart.ping(0).series, apart.ping(1).series) > 0.5);
}

// Protects what a run takes: counted, not guessed from the rays.
TEST_CASE("scatterers on surfaces are announced", "[serial]") {
  const SceneRun run("sonar_tank", {{"scattering.speckle", "surface"}});
  REQUIRE(run.session().surface_tiles);
  const EchoCounts counts = count_echoes(run.session(), Tracer(run.session().world));
  CHECK(counts.surface == run.ping(0).scatterers.size());
  CHECK(counts.surface > 100'000);
  CHECK(most_surface_points(run.session()) >= counts.surface);
  CHECK(most_surface_points(run.session()) < 8 * counts.surface);
}

// Protects the night from a run that cannot end well: told before anything is written.
TEST_CASE("more scatterers than fit are refused", "[serial]") {
  const Maker maker;
  GenerateOptions o = on_surfaces(maker, "huge");
  o.input.overrides.push_back({"sonar.range_max_m", "200"});
  o.input.overrides.push_back({"sonar.rays.min_per_cell", "20"});
  o.input.overrides.push_back(
      {"sonar.beams", "{count: 24, fov_deg: 90, receive_width_deg: 0.002}"});
  o.input.overrides.push_back(
      {"objects.0.shape", "{box: {size_m: [300, 300, 100], inward_facing: true}}"});
  check_fails(generate(o), ErrorKind::usage, {"scattering.speckle: surface needs"});
  CHECK_FALSE(std::filesystem::exists(o.output));
}
