// What decides which run of a sweep starts when, and what runs share.
#include <chrono>
#include <fstream>
#include <future>

#include "app/memory_gate.h"
#include "app/run_queue.h"
#include "app/tables.h"
#include "app/world_cache.h"
#include "catch.h"
#include "temporary_folder.h"

namespace ensonify {
namespace {

using namespace std::chrono_literals;
using test::TemporaryFolder;

Scenario scenario_with(const std::string& more) {
  const std::string text =
      "ensonify: 1\nseed: 3\nsonar: {preset: blueview_p900_90}\n"
      "materials: {m: {reflectivity: 1e-3}}\n" +
      more;
  return *parse_scenario(text, "test.yaml", ".");
}

const std::string kBall =
    "objects: [{name: ball, material: m, shape: {sphere: {radius_m: 1}}}]\ntrajectory: {pings: "
    "2}\n";

Scenario changed(const std::string& more, const std::string& path, const std::string& value) {
  const std::string text =
      "ensonify: 1\nseed: 3\nsonar: {preset: blueview_p900_90}\n"
      "materials: {m: {reflectivity: 1e-3}}\n" +
      more;
  return *parse_scenario(text, "test.yaml", ".", {{path, value}});
}

}  // namespace

TEST_CASE("sweep: worlds are shared by runs that differ in the sonar alone") {
  const std::string key = world_key(scenario_with(kBall));
  const auto after = [&](const char* path, const char* value) {
    return world_key(changed(kBall, path, value));
  };
  CHECK(after("sonar.range_max_m", "3") == key);
  CHECK(after("noise.spectrum_level_db", "30") == key);
  CHECK(after("water.sound_speed_m_s", "1480") == key);
  CHECK(after("trajectory.pings", "7") == key);
  CHECK(after("output.png", "false") == key);
  CHECK(after("scattering.speckle", "surface") == key);
  CHECK(after("seed", "4") == key);
  CHECK(after("scattering.lambert_exponent", "2") != key);
  CHECK(after("materials.m.reflectivity", "2e-3") != key);
  CHECK(after("objects.ball.shape.sphere.radius_m", "2") != key);
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

TEST_CASE("sweep: tables are shared by runs of one sonar in one water") {
  const std::string key = table_key(scenario_with(kBall));
  CHECK(table_key(changed(kBall, "seed", "4")) == key);
  CHECK(table_key(changed(kBall, "materials.m.reflectivity", "2e-3")) == key);
  CHECK(table_key(changed(kBall, "noise.spectrum_level_db", "30")) == key);
  for (const auto& [path, value] : std::initializer_list<std::pair<const char*, const char*>>{
           {"sonar.range_max_m", "3"},
           {"sonar.source_level_db", "190"},
           {"water.sound_speed_m_s", "1480"},
           {"synthesis.tolerance", "1e-4"},
           {"scattering.normalization", "mean_square"},
           {"output.cartesian", "{height_px: 100}"}}) {
    INFO(path);
    CHECK(table_key(changed(kBall, path, value)) != key);
  }
}

TEST_CASE("sweep: runs start while threads would be without a ping, in their order") {
  RunQueue queue({100, 1, 1, 100}, 2);
  CHECK(queue.lanes() == 4);
  REQUIRE(queue.take()->run == 0);
  auto second = std::async(std::launch::async, [&] { return queue.take(); });
  CHECK(second.wait_for(20ms) == std::future_status::timeout);
  for (int i = 0; i < 96; ++i) queue.item_done(0);
  const auto next = second.get();
  REQUIRE(next);
  CHECK(next->run == 1);
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

}  // namespace ensonify
