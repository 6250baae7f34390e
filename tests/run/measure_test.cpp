// What is announced of a data set before it is made, against the data set.
#include "run/measure.h"

#include <filesystem>

#include "run/cost.h"
#include "run/disk_room.h"
#include "run/make_dataset.h"
#include "run/memory.h"
#include "small_data_set.h"

namespace ensonify::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPacked = "{cartesian: {height_px: 60}, one_file_per: sequence}";
constexpr const char* kMoments = "{statistics: true}";
constexpr const char* kLists = "{points: true, scatterers: true, polygons: true}";

double bytes_on_disk(const fs::path& folder) {
  double bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) bytes += static_cast<double>(entry.file_size());
  }
  return bytes;
}

struct Announced {
  Measured measured;
  double bytes = 0;
};

Announced announced(const ScenarioOptions& input) {
  const auto worlds = SequenceWorlds::open(input);
  if (!worlds) FAIL(worlds.error().message);
  const Session& session = worlds->first();
  const Numerics numerics;
  const auto measured = measure_pings({*worlds, numerics, 2});
  if (!measured) FAIL(measured.error().message);
  return {*measured, disk_bytes(*measured, session)};
}

}  // namespace

TEST_CASE("the announced size is that of the data set", "[serial]") {
  const auto output =
      GENERATE(as<std::string>(), "{cartesian: {height_px: 60}}", kPacked, kMoments, kLists);
  const auto sequences = GENERATE(as<std::string>(), "1", "3");
  Maker maker;
  GenerateOptions options = maker.options("out");
  options.input.overrides = {{"output", output}, {"sequences", sequences}};
  const Announced expected = announced(options.input);
  CHECK(expected.measured.pings == 2);
  CHECK(expected.measured.sequences == 1);
  CHECK(expected.measured.looked.size() == 1);
  maker.make(options);
  INFO(output << " x " << sequences);
  CHECK(expected.bytes == Approx(bytes_on_disk(options.output)).epsilon(0.02));
}

TEST_CASE("the announced size is the mean of two sequences that are sampled") {
  Maker maker;
  GenerateOptions options = maker.options("out");
  options.input.overrides = {{"sequences", "4"},
                             {"objects.1.shape.sphere.radius_m", "{uniform: [0.1, 0.6]}"},
                             {"trajectory.pings", "3"}};
  const Announced expected = announced(options.input);
  CHECK(expected.measured.pings == 2);
  CHECK(expected.measured.sequences == 2);
  CHECK(expected.measured.looked[1].sequence == 1);
  CHECK(expected.measured.world_s > 0);
  CHECK(expected.measured.probe.core_s > expected.measured.world_s);
  maker.make(options);
  CHECK(expected.bytes == Approx(bytes_on_disk(options.output)).epsilon(0.05));
}

// The objects are those of the ping that is measured, whatever files it has.
TEST_CASE("objects are looked at in the measured ping or in one of their own") {
  Maker maker;
  GenerateOptions options = maker.options("out");
  const Announced images = announced(options.input);
  options.input.overrides = {{"output", "{polar: false, png: false, cartesian: false}"}};
  const Announced series = announced(options.input);
  REQUIRE(images.measured.looked.size() == 1);
  REQUIRE(series.measured.looked.size() == 1);
  const auto& a = images.measured.looked[0].objects;
  const auto& b = series.measured.looked[0].objects;
  REQUIRE(a.size() > 1);
  REQUIRE(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    CHECK(a[i].pixels == b[i].pixels);
    CHECK(a[i].over_ground_db == b[i].over_ground_db);
  }
  CHECK(a[1].pixels > 0);
  CHECK(series.bytes < images.bytes);
}

// The counts of an instrument are files that the scenario's output does not name.
TEST_CASE("the files of a recorder are announced", "[serial]") {
  Maker maker;
  GenerateOptions options = maker.options("out");
  options.input.overrides = {
      {"sonar.recorder", "{bits: 16, scale: amplitude, db: [0, 185], row_gain_db: 40}"}};
  const auto worlds = SequenceWorlds::open(options.input);
  REQUIRE(worlds.ok());
  const auto files = maker.make(options);
  REQUIRE(files.contains("sequences/000000/recorded/000000_row_gain.npy"));
  // provenance.json is not among the files read.
  CHECK(estimate_cost(worlds->first(), 0).files == files.size() + 1);
}

TEST_CASE("the announced time follows from pings, threads and sequences", "[serial]") {
  Measured measured;
  measured.probe = {3, 5};
  measured.world_s = 2;
  measured.prepare_s = 0.5;
  measured.ping_s = 0.75;
  measured.store_s = 0.25;
  measured.alone_s = 0.6;

  // One sequence: pings side by side.
  CHECK(time_of(measured, 1, 101, false, 1).wall_s == Approx(3 + 0.5 + 101));
  CHECK(time_of(measured, 1, 101, false, 1).core_s == Approx(5 + 0.5 + 101));
  CHECK(time_of(measured, 1, 1000, false, 4).wall_s == Approx(3 + 0.5 + 250));
  // Three pings on two threads: one of them waits.
  CHECK(time_of(measured, 1, 3, false, 2).wall_s == Approx(3 + 0.5 + 2));
  // Threads that share a ping make it no faster than was measured.
  CHECK(time_of(measured, 1, 2, false, 8).wall_s == Approx(3 + 0.5 + 0.85));
  // Sequences of one ping, as many at once as there are threads. The first world is there.
  const RunTime many = time_of(measured, 400, 1, true, 4);
  CHECK(many.core_s == Approx(5 + 399 * 2 + 400 * (0.5 + 1)));
  CHECK(many.wall_s == Approx(3 + (many.core_s - 5) / 4));
  // What is joined and finished of every ping, and what one thread lists at the end.
  measured.finish_s = 0.5;
  CHECK(time_of(measured, 1, 101, false, 1).wall_s == Approx(3 + 0.5 + 101 + 50.5));
  measured.list_s = 0.25;
  CHECK(time_of(measured, 1, 4, false, 4).wall_s == Approx(3 + 0.5 + 1 + 2 + 1));
}

// The refusal for lack of disk makes no ping: the table of outputs must be near the truth, also
// where lists of echoes fill the disk.
TEST_CASE("the size by the table of outputs is near that of the data set", "[serial]") {
  const auto output = GENERATE(as<std::string>(), "{cartesian: true}", kPacked, kLists);
  Maker maker;
  GenerateOptions options = maker.options("out");
  options.input.overrides = {{"output", output}};
  const auto worlds = SequenceWorlds::open(options.input);
  REQUIRE(worlds.ok());
  const EchoCounts echoes = count_echoes(worlds->first(), worlds->first_tracer());
  const Cost cost = estimate_cost(worlds->first(), echoes.surface + echoes.coherent);
  maker.make(options);
  INFO(output);
  CHECK(static_cast<double>(cost.disk_bytes) ==
        Approx(bytes_on_disk(options.output)).epsilon(0.35));
}

TEST_CASE("signal components make a run dearer by their samples", "[serial]") {
  Maker maker;
  GenerateOptions options = maker.options("out");
  const auto core_s = [&](const char* layers) {
    options.input.overrides = {{"trajectory", "{ping_rate_hz: 5, pings: 10000}"},
                               {"output.layers", layers}};
    const auto worlds = SequenceWorlds::open(options.input);
    if (!worlds) FAIL(worlds.error().message);
    return estimate_cost(worlds->first(), 0).core_s;
  };
  CHECK(core_s("true") > core_s("false"));
  CHECK(core_s("true") < 2 * core_s("false"));
}

// Protects plans of sweeps, which trace nothing: no ping has more echoes than they assume.
TEST_CASE("no ping has more echoes than the bound without tracing", "[serial]") {
  TemporaryFolder folder;
  // The sonar is inside a steel shell, and hears a room through it.
  const std::string scene =
      "ensonify: 1\n"
      "sonar: {preset: paper_table1, bandwidth_hz: 29900, range_max_m: 12, "
      "beams: {count: 4, fov_deg: 20}, rays: {elevation: 8}}\n"
      "materials:\n"
      "  m: {reflectivity: 1e-1}\n"
      "  steel: {reflectivity: 1e-3, wall: {thickness_m: 0.05, density_kg_m3: 7850, "
      "speed_m_s: 5900, shear_speed_m_s: 3230}}\n"
      "objects:\n"
      "  - {name: room, material: m, shape: {box: {size_m: [9, 9, 6], inward_facing: true}}}\n"
      "  - {name: shell, material: steel, shape: {sphere: {radius_m: 1}}}\n";
  const auto bounces = GENERATE(as<std::string>(), "0", "1");
  const auto worlds =
      SequenceWorlds::open({folder.write("scene.yaml", scene), {{"bounces", bounces}}});
  if (!worlds) FAIL(worlds.error().message);
  const EchoCounts made = count_echoes(worlds->first(), worlds->first_tracer()),
                   most = most_echoes(worlds->first());
  INFO(bounces << " bounces: " << made.coherent << " of " << most.coherent << " and "
               << made.surface);
  CHECK(made.surface <= most.surface);
  CHECK(made.coherent <= most.coherent);
}

// Protects what `check` and plans of sweeps say of memory: a ping keeps its echoes.
TEST_CASE("memory grows with the echoes of a ping", "[serial]") {
  Maker maker;
  GenerateOptions options = maker.options("out");
  options.input.overrides = {{"output", "{polar: false, cartesian: false, png: false}"}};
  const auto worlds = SequenceWorlds::open(options.input);
  REQUIRE(worlds.ok());
  const auto bytes_of = [&](std::uint64_t echoes) {
    return peak_bytes(run_memory(worlds->first(), 1, {}, {.surface = echoes}, {}));
  };
  constexpr std::uint64_t kMany = 10'000'000;
  CHECK(bytes_of(2 * kMany) - bytes_of(kMany) >= kMany * sizeof(Scatterer));
}

TEST_CASE("a disk without room is an error that names both sizes") {
  CHECK(room_for_bytes("out", 5e9, std::uint64_t{5'000'000'000}).ok());
  CHECK(room_for_bytes("out", 5e9, std::nullopt).ok());
  const Status refused = room_for_bytes("out", 5e9, std::uint64_t{4'000'000'000});
  REQUIRE_FALSE(refused.ok());
  CHECK(refused.error().kind == ErrorKind::io);
  CHECK(refused.error().message.starts_with(
      "out: the data needs about 5.0 GB of disk space, but only 4.0 GB is free;"));
}

TEST_CASE("free space is that of the disk on which a folder will be") {
  const TemporaryFolder folder;
  const auto there = free_bytes(folder.path());
  const auto will_be = free_bytes(folder.path() / "a/b/c");
  REQUIRE(there);
  REQUIRE(will_be);
  // Other programs write meanwhile.
  CHECK(static_cast<double>(*will_be) == Approx(static_cast<double>(*there)).epsilon(0.2));
  CHECK(fs::is_empty(folder.path()));
}

}  // namespace ensonify::test
