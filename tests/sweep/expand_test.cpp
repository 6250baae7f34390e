#include <filesystem>
#include <set>

#include "results.h"
#include "scenario/scenario.h"
#include "sweeps.h"

namespace ensonify {
namespace {

using testing::expand;
using testing::faults_of;
using testing::names_of;
using testing::SweepFolder;

std::string resolved(const Scenario& scenario) {
  return to_yaml(scenario, [](const std::filesystem::path& file) { return file.string(); });
}

// Protects the meaning of an axis: a run is the base with the same `--set`, by another way.
TEST_CASE("a run is the base with its values set") {
  const SweepFolder folder;
  const auto sweep =
      value_of(expand(folder,
                      "set: {trajectory.pings: 5}\n"
                      "axes:\n"
                      "  - {key: objects.ball.pose.position_m, values: [[3, 0, 0], [5, 1, 0]]}\n"
                      "  - {name: s, values: [{sonar.preset: oculus_m750d_lf, noise.snr_db: 9}]}\n"
                      "seeds: [3]\n"));
  REQUIRE(sweep.runs.size() == 2);
  const auto by_set = value_of(
      load_scenario(folder.path() / "base.yaml", {{"trajectory.pings", "5"},
                                                  {"objects.0.pose.position_m", "[5, 1, 0]"},
                                                  {"sonar.preset", "oculus_m750d_lf"},
                                                  {"noise.snr_db", "9"},
                                                  {"seed", "3"}}));
  const auto by_sweep = value_of(scenario_of(sweep.file, sweep.runs[1].point));
  CHECK(resolved(by_sweep) == resolved(by_set));
  CHECK(sweep.runs[1].seed == 3);
  CHECK(sweep.runs[1].cost.pings == 5);
}

// Protects folders of finished runs: ids hang on content alone, not on order, names or comments.
TEST_CASE("ids follow from content") {
  const SweepFolder folder;
  const auto few = expand(folder, "axes: [{key: sonar.range_max_m, values: [5, 10]}]\n");
  const auto more = expand(folder,
                           "# another order, another name, more\n"
                           "run_name: \"{r}\"\n"
                           "axes:\n"
                           "  - {key: seed, values: [7, 8]}\n"
                           "  - {key: sonar.range_max_m, name: r, values: [20, 10.0, 5e0]}\n");
  REQUIRE(few.ok());
  REQUIRE(more.ok());
  std::set<std::string> ids;
  for (const SweepRun& run : more->runs) ids.insert(run.id);
  CHECK(ids.size() == 6);
  for (const SweepRun& run : few->runs) {
    CHECK(run.id.size() == 16);
    CHECK(ids.contains(run.id));
  }
  CHECK(to_jsonl(plan_of(*few)) ==
        to_jsonl(plan_of(*expand(folder, "axes: [{key: sonar.range_max_m, values: [5, 10]}]\n"))));
}

// Protects sweeps over how many sequences there are, which a folder's own identity leaves out.
TEST_CASE("runs of other numbers of sequences are other runs") {
  const SweepFolder folder;
  const auto sweep = value_of(expand(folder, "axes: [{key: sequences, values: [1, 2]}]\n"));
  CHECK(sweep.runs.size() == 2);
}

// Protects disk and time from the same work twice.
TEST_CASE("points of one content are one run") {
  const SweepFolder folder;
  const auto sweep = expand(folder,
                            "axes:\n"
                            "  - {key: sonar.range_max_m, values: [5, 5.0, 10]}\n"
                            "  - {name: k, values: [{}, {sonar.range_max_m: 5}]}\n");
  INFO(joined_lines(faults_of(sweep)));
  REQUIRE_FALSE(sweep.ok());  // the key belongs to one axis
  const auto same =
      value_of(expand(folder, "axes: [{key: sonar.range_max_m, values: [5, 5.0, 10]}]\n"));
  CHECK(names_of(same) == std::vector<std::string>{"range_max_m=5", "range_max_m=10"});
  CHECK(same.repeated == 1);
}

// Protects finished runs from an input file that has changed under its name.
TEST_CASE("ids follow the content of input files, whatever they are called") {
  const SweepFolder folder(testing::kBase + "water: {profile: {file: cast.csv}}\n");
  const std::string axes = "axes: [{key: sonar.range_max_m, values: [5, 10]}]\n";
  folder.files().write("cast.csv", "depth_m,sound_speed_m_s\n0,1500\n10,1490\n");
  const auto before = value_of(expand(folder, axes));
  folder.files().write("cast.csv", "depth_m,sound_speed_m_s\n0,1500\n10,1480\n");
  const auto after = value_of(expand(folder, axes));
  CHECK(before.runs[0].id != after.runs[0].id);
  folder.files().write("copy.csv", "depth_m,sound_speed_m_s\n0,1500\n10,1490\n");
  const auto copied = value_of(expand(folder, axes + "set: {water.profile.file: copy.csv}\n"));
  CHECK(before.runs[0].id == copied.runs[0].id);
}

// Protects a night: every fault of every run, each once, in the file that is to blame.
TEST_CASE("faults of runs have their place in the sweep file and their run") {
  const SweepFolder folder;
  const auto lines = faults_of(expand(folder,
                                      "axes:\n"
                                      "  - {key: sonar.range_max_m, values: [5, -1, x]}\n"
                                      "  - {key: sonar.range_mx_m, name: y, values: [1, 2]}\n"
                                      "  - {key: sonar.beams.count, linear: [2, 3], count: 2}\n"
                                      "set: {trajectory.pins: 5}\n"));
  INFO(joined_lines(lines));
  REQUIRE(lines.size() == 4);
  const auto tells = [&](const std::string& begin, const std::string& a, const std::string& b) {
    return std::any_of(lines.begin(), lines.end(), [&](const std::string& line) {
      return line.starts_with(begin) && line.find(a) != std::string::npos && line.ends_with(b);
    });
  };
  CHECK(tells("s.yaml:4:42: sonar.range_max_m: ", "out of range",
              "(run range_max_m=-1,y=1,count=2 and 3 more)"));
  CHECK(tells("s.yaml:4:46: sonar.range_max_m: ", "`x` is not a number",
              "(run range_max_m=x,y=1,count=2 and 3 more)"));
  CHECK(tells("s.yaml:7:7: trajectory.pins: ", "did you mean pings?", "(every run)"));
  CHECK(tells("s.yaml:5:11: sonar.range_mx_m: ", "unknown key (did you mean range_max_m?)",
              "(every run)"));
}

// Protects the advice where a value shows to be wrong only when files and sizes are put together.
TEST_CASE("an error of the cost has the place of its key") {
  const SweepFolder folder;
  auto file = value_of(folder.parse("axes: [{key: sonar.range_max_m, values: [5, 10]}]\n"));
  const auto sweep = expand_sweep(
      std::move(file),
      [](const Scenario& scenario) -> Result<Cost> {
        if (scenario.sonar.range_max_m < 7) return Cost{1, 1, 1, 1};
        return Error{ErrorKind::usage,
                     "sonar.range_max_m: too far\nobjects.0.name: odd\nnowhere: at all"};
      },
      Workers(2));
  const auto lines = faults_of(sweep);
  INFO(joined_lines(lines));
  REQUIRE(lines.size() == 3);
  CHECK(lines[0] == "s.yaml:3:45: sonar.range_max_m: too far (run range_max_m=10)");
  const std::string base = (folder.path() / "base.yaml").string();
  CHECK(lines[1] == base + ":7:12: objects.0.name: odd (run range_max_m=10)");
  CHECK(lines[2] == base + ": nowhere: at all (run range_max_m=10)");
}

// Protects results from the number of threads.
TEST_CASE("a plan does not depend on threads") {
  const SweepFolder folder;
  const std::string axes =
      "axes: [{key: sonar.range_max_m, uniform: [5, 50], count: 40}]\nseeds: 3\n";
  std::set<std::string> texts;
  for (const int threads : {1, 2, 5}) {
    auto file = value_of(folder.parse(axes));
    const auto sweep =
        value_of(expand_sweep(std::move(file), testing::plain_cost, Workers(threads)));
    texts.insert(to_jsonl(plan_of(sweep)));
  }
  CHECK(texts.size() == 1);
}

// Protects the examples.
TEST_CASE("every sweep of configs expands without faults") {
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(ENSONIFY_SWEEPS)) {
    if (entry.path().extension() != ".yaml") continue;
    ++count;
    auto file = value_of(load_sweep_file(entry.path()));
    CHECK(file.name == entry.path().stem().string());
    const auto sweep = value_of(expand_sweep(std::move(file), testing::plain_cost, Workers(2)));
    CHECK(sweep.runs.size() >= 10);
    CHECK(sweep.repeated == 0);
  }
  CHECK(count >= 3);
}

}  // namespace
}  // namespace ensonify
