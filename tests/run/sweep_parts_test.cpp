// What decides which run of a sweep starts when, what runs share, and how lanes take turns.
#include <chrono>
#include <fstream>
#include <future>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "catch.h"
#include "ping/tables.h"
#include "results.h"
#include "run/make_sequences.h"
#include "run/memory_there.h"
#include "run/sweep_parts.h"
#include "run/terminal.h"
#include "temporary_folder.h"

namespace ensonify {
namespace {

using namespace std::chrono_literals;
using test::TemporaryFolder;

Scenario scenario_with(const std::string& more, const std::vector<Override>& overrides = {}) {
  const std::string text =
      "ensonify: 1\nseed: 3\nsonar: {preset: paper_table1, bandwidth_hz: 29900}\n"
      "materials: {m: {reflectivity: 1e-3}}\n" +
      more;
  return *parse_scenario(text, "test.yaml", ".", overrides);
}

const std::string kSweptBall =
    "objects: [{name: ball, material: m, shape: {sphere: {radius_m: 1}}}]\ntrajectory: {pings: "
    "2}\n";

Scenario changed(const std::string& more, const std::string& path, const std::string& value) {
  return scenario_with(more, {{path, value}});
}

// One change of each part of a scenario.
const std::vector<Override> kChanges = {
    {"name", "other"},
    {"seed", "4"},
    {"speckle_seed", "4"},
    {"sequences", "2"},
    {"sonar.range_max_m", "3"},
    {"sonar.source_level_db", "190"},
    {"sonar.mount", "{rotation_deg: [0, 20, 0]}"},
    {"water.sound_speed_m_s", "1480"},
    {"scattering.lambert_exponent", "2"},
    {"scattering.normalization", "mean_square"},
    {"scattering.speckle", "surface"},
    {"materials.m.reflectivity", "2e-3"},
    {"objects.ball.name", "sphere"},
    {"objects.ball.class", "target"},
    {"objects.ball.shape.sphere.radius_m", "2"},
    {"objects.ball.pose.position_m", "[3, 0, 0]"},
    {"point_targets", "[{name: p, target_strength_db: -40, position_m: [1, 0, 0]}]"},
    {"volumes", "[{name: w, uniform: {strength_db: -50}}]"},
    {"classes", "{object: {kind: stuff}}"},
    {"multipath", "{surface: {z_m: 1, reflection: -1}}"},
    {"trajectory.pings", "7"},
    {"motion_within_ping", "true"},
    {"noise.spectrum_level_db", "30"},
    {"noise.snr_db", "30"},
    {"noise", "{spectrum_level_db: 30, correlated: true}"},
    {"sonar.electronics", "{saturation: {level_db: 150}, beam_gain_error_db: 1}"},
    {"sonar.recorder", "{db: [60, 120]}"},
    {"sonar.detector", "{noise_db: 2, integrate: 2}"},
    {"sonar.detector.looks", "2"},
    {"synthesis.tolerance", "1e-4"},
    {"output.timeseries", "exr"},
    {"output.png", "false"},
    {"output.png", "{db: [-10, 60]}"},
    {"output.png.resampling", "nearest"},
    {"output.shadow", "false"},
    {"output.one_file_per", "sequence"},
    {"output.layers", "true"},
    {"output.cartesian", "false"},
    {"output.cartesian", "{height_px: 100}"},
    {"output.cartesian.exr", "true"},
    {"splits", "{train: 1, val: 1}"}};

std::set<std::string> paths_that_change(std::string (*key_of)(const Scenario&)) {
  const std::string key = key_of(scenario_with(kSweptBall));
  std::set<std::string> paths;
  for (const Override& change : kChanges) {
    INFO(change.path);
    if (key_of(scenario_with(kSweptBall, {change})) != key) paths.insert(change.path);
  }
  return paths;
}

}  // namespace

// Protects both ways: a wrong world or table is never shared, and what does not matter does not
// keep runs apart. A new key of scenarios keeps them apart until it is known not to matter.
TEST_CASE("sweep: worlds are shared by runs that differ in nothing that is built") {
  CHECK(paths_that_change(world_key) ==
        std::set<std::string>{"scattering.lambert_exponent", "scattering.normalization",
                              "materials.m.reflectivity", "objects.ball.name", "objects.ball.class",
                              "objects.ball.shape.sphere.radius_m", "objects.ball.pose.position_m",
                              "point_targets", "volumes"});
}

// The mesh of a mirror is as fine as the frequency needs, an object may start with the sonar, and
// meshes have colors for a camera.
TEST_CASE("sweep: worlds that go by frequency, trajectory or camera are not shared") {
  const auto object = [](const std::string& more) {
    return "objects: [{name: b, material: m, shape: {mesh: {file: " ENSONIFY_SCENES
           "/meshes/wreck.obj, normals: smooth}}" +
           more + "}]\ntrajectory: {pings: 2}\n";
  };
  const auto key = [&](const std::string& more, std::vector<Override> overrides) {
    return world_key(scenario_with(object(more), overrides));
  };
  const Override slow{"sonar", "{preset: blueview_m450_90}"},
      later{"trajectory", "{poses: [{time_s: 1, position_m: [0, 0, 0]}]}"},
      mirror{"materials.m.coherent", "{model: kirchhoff}"};
  const Override seen{"camera", "{fov_deg: 70}"}, wider{"camera", "{fov_deg: 90}"};
  CHECK(key("", {slow, later}) == key("", {}));
  CHECK(key("", {seen}) == key("", {wider}));
  CHECK(key("", {seen}) != key("", {}));
  CHECK(key("", {mirror, slow}) != key("", {mirror}));
  CHECK(key("", {mirror, later}) == key("", {mirror}));
  const std::string waits =
      ", trajectory: {orbit: {center_m: [5, 0, 0], radius_m: 1, speed_m_s: 1}, "
      "from_first_ping: true}";
  CHECK(key(waits, {later}) != key(waits, {}));
}

TEST_CASE("sweep: tables are shared by runs of one sonar in one water") {
  CHECK(paths_that_change(table_key) ==
        std::set<std::string>{"sonar.range_max_m", "sonar.source_level_db", "sonar.detector.looks",
                              "water.sound_speed_m_s", "scattering.normalization", "noise",
                              "synthesis.tolerance", "output.cartesian", "output.png",
                              "output.png.resampling"});
}

// Protects the time of sampled data sets: what is sampled in this scene, the mount among it,
// changes no table.
TEST_CASE("tables are shared by the sequences of a sampled scene") {
  const auto key_of = [](std::uint32_t sequence) {
    const auto file = std::filesystem::path(ENSONIFY_SCENES) / "random_debris.yaml";
    const Result<Scenario> scenario = load_scenario(file, {}, sequence);
    if (!scenario) FAIL(scenario.error().message);
    return table_key(*scenario);
  };
  CHECK(key_of(0) == key_of(1));
}

TEST_CASE("sweep: what a world draws from the seed goes by the seed") {
  const std::string sand =
      "objects: [{name: sand, material: m, shape: {heightfield: {size_m: [4, 4], cell_m: 1, "
      "roughness: {rms_m: 0.1, exponent: 3.3, outer_scale_m: 4}}}}]\ntrajectory: {pings: 2}\n";
  CHECK(world_key(changed(sand, "seed", "4")) != world_key(scenario_with(sand)));
  const std::string drawn =
      "objects: [{name: ball, material: m, shape: {sphere: {radius_m: {uniform: [1, 2]}}}}]\n"
      "trajectory: {pings: 2}\n";
  CHECK(world_key(changed(drawn, "seed", "4")) != world_key(scenario_with(drawn)));
  CHECK(world_key(changed(drawn, "sonar.range_max_m", "3")) == world_key(scenario_with(drawn)));
}

TEST_CASE("sweep: runs start while threads would be without a ping, in their order") {
  RunQueue queue({100, 1, 1, 100}, 2);
  CHECK(queue.lanes() == 4);
  REQUIRE(queue.take()->run == 0);
  auto second = std::async(std::launch::async, [&] { return queue.take(); });
  CHECK(second.wait_for(20ms) == std::future_status::timeout);
  for (int i = 0; i < 96; ++i) queue.item_done(0);
  const auto next = value_of(second.get());
  CHECK(next.run == 1);
  auto third = std::async(std::launch::async, [&] { return queue.take(); });
  CHECK(third.wait_for(20ms) == std::future_status::timeout);
  queue.finish(1);
  CHECK(third.get()->run == 2);
  auto last = std::async(std::launch::async, [&] { return queue.take(); });
  queue.finish(0);
  CHECK(last.get()->run == 3);
  CHECK_FALSE(queue.take());
}

TEST_CASE("sweep: a stopped queue lets go of who waits") {
  RunQueue queue({100, 100}, 2);
  CHECK(queue.take());
  auto waiting = std::async(std::launch::async, [&] { return queue.take(); });
  queue.stop();
  CHECK_FALSE(waiting.get());
}

TEST_CASE("sweep: what does not fit waits, what fits nowhere goes alone") {
  using What = MemoryGate::What;
  MemoryGate gate(100);
  CHECK(gate.fits(50, 2));
  CHECK_FALSE(gate.fits(51, 2));
  {
    const auto world = gate.hold(What::world, 500);
    // No other run is held: it must not wait for worlds, whose runs wait for it.
    auto run = gate.hold(What::run, 60);
    auto other = std::async(std::launch::async, [&] { return gate.hold(What::run, 60); });
    CHECK(other.wait_for(20ms) == std::future_status::timeout);
    run = {};
    const auto held = other.get();
  }
  auto first = gate.hold(What::run, 60);
  auto second = std::async(std::launch::async, [&] { return gate.hold(What::run, 60); });
  CHECK(second.wait_for(20ms) == std::future_status::timeout);
  gate.resize(first, 40);
  const auto held = second.get();
}

TEST_CASE("sweep: memory is what the kernel and all control groups leave") {
  const TemporaryFolder folder;
  const auto write = [&](const std::string& name, const std::string& text) {
    std::filesystem::create_directories((folder.path() / name).parent_path());
    std::ofstream(folder.path() / name) << text;
  };
  CHECK(available_memory(folder.path()) == UINT64_MAX);
  write("proc/meminfo", "MemTotal: 9000 kB\nMemFree: 10 kB\nMemAvailable: 5000 kB\n");
  CHECK(available_memory(folder.path()) == 5'120'000);
  write("proc/self/cgroup", "0::/slurm/job\n");
  write("sys/fs/cgroup/slurm/job/memory.max", "max\n");
  write("sys/fs/cgroup/slurm/job/memory.current", "1000\n");
  CHECK(available_memory(folder.path()) == 5'120'000);
  write("sys/fs/cgroup/slurm/memory.max", "900000\n");
  write("sys/fs/cgroup/slurm/memory.current", "100000\n");
  CHECK(available_memory(folder.path()) == 800'000);
  // Files in memory go when it is needed, as soon as they are on the disk.
  write("sys/fs/cgroup/slurm/memory.current", "890000\n");
  write("sys/fs/cgroup/slurm/memory.stat",
        "anon 100000\nfile 790000\ninactive_file 500000\nactive_file 200000\nfile_dirty 40000\n"
        "file_writeback 10000\n");
  CHECK(available_memory(folder.path()) == 660'000);
  write("proc/self/cgroup", "3:cpu,memory:/old\n0::/\n");
  write("sys/fs/cgroup/memory/old/memory.limit_in_bytes", "5000\n");
  write("sys/fs/cgroup/memory/old/memory.usage_in_bytes", "9000\n");
  CHECK(available_memory(folder.path()) == 0);
  write("sys/fs/cgroup/memory/old/memory.stat",
        "cache 5000\ntotal_inactive_file 4000\ntotal_active_file 1500\ntotal_dirty 500\n"
        "total_writeback 0\n");
  CHECK(available_memory(folder.path()) == 1'000);
}

// Protects nights: no lane may sleep while a turn is free. A round ends only when every lane had
// all of its turns, and turns end in another order every time.
TEST_CASE("turns are limited, and everybody gets theirs") {
  constexpr int kTurns = 2, kLanes = 5, kTurnsOfLane = 4;
  std::atomic<int> most = 0, all = 0;
  constexpr int kRounds = 100;
  for (int round = 0; round < kRounds; ++round) {
    Turns turns(kTurns);
    std::atomic<int> now = 0;
    std::vector<std::jthread> lanes;
    for (int lane = 0; lane < kLanes; ++lane) {
      lanes.emplace_back([&, round, lane] {
        for (int k = 0; k < kTurnsOfLane; ++k) {
          const Turn turn(turns);
          const int here = ++now;
          int seen = most;
          while (here > seen && !most.compare_exchange_weak(seen, here)) {
          }
          // Long enough for the other lanes to come in, if they may.
          std::this_thread::sleep_for(std::chrono::microseconds((lane * 7 + k * 13 + round) % 97));
          ++all;
          --now;
        }
      });
    }
  }
  CHECK(all == kRounds * kLanes * kTurnsOfLane);
  CHECK(most == kTurns);
}

// Protects the order of work and its end: what comes after a failure is not begun.
TEST_CASE("lanes take work in order and stop at a failure") {
  std::atomic<std::size_t> begun = 0;
  const Status made = in_lanes(1, 10, [&](std::size_t, std::size_t i) -> Status {
    CHECK(begun++ == i);
    if (i == 6) return Error{ErrorKind::io, "full"};
    return {};
  });
  CHECK_FALSE(made);
  CHECK(begun == 7);
}

// After a start of `start` seconds, `at_once` pings at a time.
Pace pace_of(int pings, double start, double each, int at_once = 1) {
  Pace pace;
  for (int i = 0; i < pings; ++i) pace.add(start + each * (1 + i / at_once));
  return pace;
}

TEST_CASE("progress tells pings, rate and time left") {
  CHECK(progress_text(0, 40, {}, 0) == "0/40 pings, ...");
  CHECK(progress_text(12, 40, pace_of(10, 0, 0.5), 5) == "12/40 pings, 2 pings/s, 14 s left");
  CHECK(progress_text(100, 10100, pace_of(100, 0, 0.5), 50) ==
        "100/10100 pings, 2 pings/s, 1 h 23 min left");
  CHECK(progress_text(40, 40, pace_of(40, 0, 0.25), 10) == "40/40 pings, 4 pings/s");
}

TEST_CASE("the time left is told once the start no longer governs it, and from then on") {
  const double start = 2;
  for (const int at_once : {1, 16}) {
    for (int pings = 1; pings <= 400; ++pings) {
      const double now = start + 0.5 * (1 + (pings - 1) / at_once);
      const auto rate = pace_of(pings, start, 0.5, at_once).per_s(now);
      INFO(pings << " pings, " << at_once << " at once");
      if (now < start + 2) CHECK_FALSE(rate);
      if (now > start + 2.5) REQUIRE(rate);
      if (!rate) continue;
      CHECK(*rate <= 2 * at_once * (1 + 1e-9));
      CHECK(*rate >= 2 * at_once * (at_once == 1 ? 1 - 1e-9 : 0.65));
    }
  }
}

}  // namespace ensonify
