// Sums and tables of a sweep's runs, from statuses that are made up.
#include <nlohmann/json.hpp>

#include <fmt/format.h>

#include <chrono>
#include <fstream>

#include "catch.h"
#include "formats/sha256.h"
#include "results.h"
#include "sweep/index.h"
#include "sweep/status.h"
#include "temporary_folder.h"

namespace ensonify {
namespace {

PlannedRun planned(char id, std::uint64_t pings) {
  return {std::string(16, id), std::string("run ") + id, {{"a", "1.5"}}, 7, pings, 1};
}

RunStatus status_of(RunState state, std::uint64_t pings, double begun_s, double changed_s,
                    double recent) {
  RunStatus status{state, pings, begun_s, changed_s, recent, {}};
  if (state == RunState::failed) status.failure = RunFailure{"", "", "usage", "no\nmesh", "", ""};
  return status;
}

}  // namespace

TEST_CASE("status: speed is that of the last ten minutes, failed runs are not waited for") {
  const Plan plan = {planned('a', 1000), planned('b', 100), planned('c', 100), planned('d', 50)};
  const std::vector<RunStatus> runs = {
      status_of(RunState::done, 1000, 0, 1000, 400), status_of(RunState::begun, 20, 1000, 1200, 20),
      status_of(RunState::missing, 0, 0, 0, 0), status_of(RunState::failed, 10, 0, 100, 0)};
  const SweepStatus sum = sum_up(plan, runs, 1200);
  CHECK(sum.runs == 4);
  CHECK(sum.done == 1);
  CHECK(sum.begun == 1);
  CHECK(sum.missing == 1);
  CHECK(sum.failed == 1);
  CHECK(sum.silent == 0);
  CHECK(sum.pings == 1250);
  CHECK(sum.pings_done == 1030);
  CHECK(sum.pings_to_come == 180);
  REQUIRE(sum.pings_per_s);
  CHECK(*sum.pings_per_s == Approx(420.0 / 600));
  CHECK(*sum.seconds_left == Approx(180 / 0.7));
  const std::string text = status_text("s", plan, runs, sum);
  CHECK(text.starts_with("s: 4 runs: 1 done, 1 running, 1 failed, 1 missing\n"));
  CHECK(contains(text, "1030 of 1250 pings, 0.7 pings/s, 4 min left\n"));
  CHECK(contains(text, "failed: dddddddddddddddd run d: "));
}

TEST_CASE("status: a young sweep has the speed of its own time, a silent one has none") {
  const Plan plan = {planned('a', 100)};
  CHECK(*sum_up(plan, {status_of(RunState::begun, 30, 1000, 1060, 30)}, 1060).pings_per_s ==
        Approx(0.5));
  const SweepStatus later = sum_up(plan, {status_of(RunState::begun, 30, 1000, 1060, 0)}, 5000);
  CHECK_FALSE(later.pings_per_s);
  CHECK_FALSE(later.seconds_left);
  CHECK(later.silent == 1);
}

// Protects the time that is left: a night's pause is no work.
TEST_CASE("status: pings of before a pause do not count for the speed") {
  namespace fs = std::filesystem;
  const test::TemporaryFolder folder;
  const auto now = fs::file_time_type::clock::now();  // one for all, however slow the machine
  const auto file = [&](const std::string& name, const std::string& text, double age_s) {
    const fs::path path = folder.path() / name;
    fs::create_directories(path.parent_path());
    std::ofstream(path) << text;
    const auto age = std::chrono::duration_cast<fs::file_time_type::duration>(
        std::chrono::duration<double>(age_s));
    fs::last_write_time(path, now - age);
  };
  const double now_s =
      std::chrono::duration<double>(fs::file_time_type::clock::to_sys(now).time_since_epoch())
          .count();
  const std::string run = "runs/" + planned('a', 9).id + "/";
  file(run + "work.json", "{}", 36'000);
  for (int ping = 0; ping < 6; ++ping) {
    file(run + fmt::format(".work/sequences/000000/{:06}.json", ping), "{}",
         ping < 4 ? 35'000 - ping : 10 - ping);
  }
  file(run + ".work/sequences/000000/plan.json", "{}", 1);
  const RunStatus begun = run_status(folder.path(), planned('a', 9), now_s);
  CHECK(begun.state == RunState::begun);
  CHECK(begun.pings == 6);
  CHECK(begun.recent_pings == 2);
  CHECK(now_s - begun.changed_s == Approx(5).margin(1e-3));

  // Realizations without records are counted by their checkpoint: 40 of a second sequence since the
  // run began, a 60th of which are recent. Where there are records, they are not counted twice.
  const auto sum_of = [&](int sequence) {
    return run + fmt::format(".work/sequences/{:06}/moments.bin", sequence);
  };
  file(sum_of(1), "ensonify moments 1 block 8 count 00040\nx", 0);
  file(sum_of(0), "ensonify moments 1 block 8 count 00005\nx", 0);
  const RunStatus more = run_status(folder.path(), planned('a', 90), now_s);
  CHECK(more.pings == 46);
  CHECK(more.recent_pings == Approx(2 + 40 / 60.0).epsilon(1e-3));
  CHECK(now_s - more.changed_s == Approx(0).margin(1e-3));
  file(sum_of(1), "no checkpoint", 0);
  CHECK(run_status(folder.path(), planned('a', 90), now_s).pings == 6);

  // Done by a process that was at work for 100 s.
  fs::remove_all(folder.path() / run / ".work");
  file(run + "provenance.json", R"({"wall_seconds": 100})", 1);
  file(run + "dataset.json", "{}", 1);
  file(run + "dataset.sha256", sha256_hex("{}") + "  dataset.json\n", 0);
  const RunStatus done = run_status(folder.path(), planned('a', 9), now_s);
  CHECK(done.state == RunState::done);
  CHECK(done.recent_pings == 9);
  CHECK(done.changed_s - done.begun_s == Approx(100).margin(1));
}

TEST_CASE("runs.csv: cells of all kinds, axes called like other columns") {
  PlannedRun run = planned('a', 3);
  run.name = "x, \"y\"";
  run.values = {{"range_m", "5"}, {"pings", "3"}, {"label", "\"a,b\""}, {"list", "[1,2]"}};
  FinishedRun finished;
  finished.state = RunState::done;
  finished.results.mean_level_db = 100.0 / 3;
  finished.results.instances = 2;
  CHECK(runs_csv({run, run}, {finished, {}}) ==
        "run,name,range_m,axis_pings,label,list,seed,pings,folder,status,mean_level_db,"
        "max_level_db,noise_level_db,first_return_m,labelled_px,instances,contrast,contrast_se\n"
        "aaaaaaaaaaaaaaaa,\"x, \"\"y\"\"\",5,3,\"a,b\",\"[1,2]\",7,3,runs/aaaaaaaaaaaaaaaa,done,"
        "33.3333,,,,,2,,\n"
        "aaaaaaaaaaaaaaaa,\"x, \"\"y\"\"\",5,3,\"a,b\",\"[1,2]\",7,3,runs/aaaaaaaaaaaaaaaa,missing,"
        ",,,,,,,\n");
}

TEST_CASE("runs.csv: no two columns have one name") {
  PlannedRun run = planned('a', 3);
  run.values = {{"pings", "3"}, {"axis_pings", "4"}};
  CHECK(runs_csv({run}, {{}}).starts_with("run,name,axis_axis_pings,axis_pings,seed,pings,"));
}

TEST_CASE("index.json: whole only where all runs are done") {
  const Plan plan = {planned('a', 1), planned('b', 1)};
  std::vector<FinishedRun> runs(2);
  runs[0].state = runs[1].state = RunState::done;
  const SweepHead head{"s", "1", "c"};
  CHECK(nlohmann::json::parse(index_json(head, plan, runs))["complete"] == true);
  runs[1].state = RunState::failed;
  // Bytes that are no text must not end the sweep.
  runs[1].failure = RunFailure{"", "", "io", "\xff", "", ""};
  const auto index = nlohmann::json::parse(index_json(head, plan, runs));
  CHECK(index["complete"] == false);
  CHECK(index["failed"].size() == 1);
  CHECK(index["runs"][1]["dataset_sha256"].is_null());
}

}  // namespace ensonify
