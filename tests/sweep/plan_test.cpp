#include <fstream>
#include <nlohmann/json.hpp>

#include "json_schema.h"
#include "results.h"
#include "sweeps.h"

namespace ensonify {
namespace {

using testing::faults_of;

PlannedRun run_of(const std::string& id, double cost = 1) {
  return {id, "n", {{"a", "1"}}, 7, 3, cost};
}

const std::string kA(16, 'a'), kB(16, 'b'), kC(16, 'c');

Plan odd_plan() {
  PlannedRun run{"0123456789abcdef", "r=\"x\"\n,\xC3\xB6", {}, 18446744073709551615u, 12, 0.1};
  run.values = {{"z", "5"},       {"a", "0.1"},          {"b", "true"}, {"c", "\"text\""},
                {"d", "[1,2.5]"}, {"e", "{\"k\":null}"}, {"f", "1e-05"}};
  run.settings = {{"sonar.range_max_m", "5"}, {"objects.0.shape", "{\"sphere\":{}}"}};
  return {run, run_of(kB, 1e9)};
}

// Protects what is compared at every start: what is written reads back the same, to the last digit.
TEST_CASE("a plan reads back as it was written") {
  const Plan plan = odd_plan();
  const auto back = value_of(parse_plan(to_jsonl(plan), "plan.jsonl"));
  CHECK(back == plan);
  CHECK(to_jsonl(back) == to_jsonl(plan));
  CHECK(to_jsonl({run_of(kA)}) ==
        "{\"run\":\"aaaaaaaaaaaaaaaa\",\"name\":\"n\",\"values\":{\"a\":1},\"settings\":{},"
        "\"seed\":7,\"pings\":3,\"cost\":1.0}\n");
  CHECK(parse_plan("", "plan.jsonl")->empty());
}

bool fits_schema(const nlohmann::json& line) {
  static const test::JsonSchema schema([] {
    std::ifstream file(ENSONIFY_PLAN_SCHEMA);
    return nlohmann::json::parse(file);
  }());
  return schema.accepts(line);
}

// Protects programs that read plans: the schema and the program agree on what a line is.
TEST_CASE("plans are as their schema says, and only those are read") {
  for (const std::string& line : lines_of(to_jsonl({run_of(kA), run_of(kB, 0)}))) {
    CHECK(fits_schema(nlohmann::json::parse(line)));
  }
  const auto whole = nlohmann::json::parse(to_jsonl({run_of(kA)}));
  std::vector<nlohmann::json> wrong;
  for (const auto& [key, value] : whole.items()) {
    nlohmann::json lacks = whole, other = whole;
    lacks.erase(key);
    other[key] = nlohmann::json::array();
    wrong.push_back(other);
    if (key != "settings") wrong.push_back(lacks);  // plans of earlier versions have none
  }
  for (const auto& [key, value] :
       {std::pair<std::string, nlohmann::json>{"run", "AAAAAAAAAAAAAAAA"},
        {"run", "abc"},
        {"seed", -1},
        {"cost", -1},
        {"more", 1}}) {
    wrong.push_back(whole);
    wrong.back()[key] = value;
  }
  for (const nlohmann::json& line : wrong) {
    INFO(line.dump());
    CHECK_FALSE(fits_schema(line));
    CHECK_FALSE(parse_plan(line.dump() + "\n", "plan.jsonl").ok());
  }
}

// Protects a folder whose plan was cut off or edited: every wrong line is named, with what to do.
TEST_CASE("a damaged plan is refused line by line") {
  const std::string line = to_jsonl({run_of(kA)});
  const auto lines = faults_of(parse_plan(line + "x\n" + line + "\n{\"run\": 1}\n[]\n{", "p"));
  INFO(joined_lines(lines));
  REQUIRE(lines.size() == 7);
  CHECK(lines[0] == "p:2: is not a JSON object");
  CHECK(lines[1] == "p:3: has the id of line 1");
  CHECK(lines[2] == "p:4: is not a JSON object");
  CHECK(lines[3].starts_with("p:5: its `run`"));
  CHECK(lines[5] == "p:7: is not a JSON object");
  CHECK(lines[6].starts_with("p: expected the plan that"));
  const std::string whole = to_jsonl(odd_plan());
  for (std::size_t length = 1; length < whole.size(); ++length) {
    const auto cut = parse_plan(whole.substr(0, length), "p");
    const bool at_line_end = whole[length - 1] == '\n';
    CHECK(cut.ok() == at_line_end);
  }
}

// Protects what is done already: a plan may grow, and what would be lost is named.
TEST_CASE("plans are compared by their runs") {
  const Plan old = {run_of(kA), run_of(kB)};
  const PlanChange same = compare_plans(old, old);
  CHECK((same.kept == 2 && same.added == 0 && same.dropped.empty()));
  const Plan grown_plan = {run_of(kC), run_of(kB), run_of(kA)};
  const PlanChange grown = compare_plans(old, grown_plan);
  CHECK((grown.kept == 2 && grown.added == 1 && grown.dropped.empty()));
  CHECK(refuse_dropped("d", grown).ok());
  const PlanChange other = compare_plans(old, {run_of(kC), run_of(kB)});
  CHECK((other.kept == 1 && other.added == 1));
  REQUIRE(other.dropped.size() == 1);
  CHECK(other.dropped[0]->id == kA);
  check_fails(refuse_dropped("d", other), ErrorKind::usage, {"1 of its 2 runs", kA, "--overwrite"});
}

// Protects the first start and the next.
TEST_CASE("a plan is written to a folder and found there") {
  const test::TemporaryFolder folder;
  const auto none = value_of(read_plan(folder.path() / "sweep"));
  CHECK_FALSE(none.has_value());
  REQUIRE(write_plan(folder.path() / "sweep", odd_plan()).ok());
  const auto there = value_of(read_plan(folder.path() / "sweep"));
  REQUIRE(there.has_value());
  CHECK(*there == odd_plan());
  folder.write("sweep/plan.jsonl", "x\n");
  check_fails(read_plan(folder.path() / "sweep"), ErrorKind::usage);
}

}  // namespace
}  // namespace ensonify
