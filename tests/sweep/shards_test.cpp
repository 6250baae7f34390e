#include <map>
#include <numeric>

#include "core/random.h"
#include "results.h"
#include "sweep/shards.h"
#include "sweeps.h"

namespace ensonify {
namespace {

Plan plan_with(const std::vector<double>& costs) {
  Plan plan;
  for (const double cost : costs) plan.push_back({"", "", {}, 0, 1, cost});
  return plan;
}

// Protects against runs that nobody or everybody makes, for any number of shards.
TEST_CASE("each run is in one shard, in order") {
  std::vector<double> costs;
  for (std::uint64_t i = 0; i < 57; ++i) costs.push_back(uniform(1, 0, i, 0));
  const Plan plan = plan_with(costs);
  for (const std::size_t count : {1, 2, 5, 56, 57, 100}) {
    std::vector<int> made(plan.size());
    for (std::size_t k = 0; k < count; ++k) {
      const auto runs = runs_of_shard(plan, {k, count});
      CHECK(std::is_sorted(runs.begin(), runs.end()));
      for (const std::size_t run : runs) ++made[run];
    }
    CHECK(std::all_of(made.begin(), made.end(), [](int times) { return times == 1; }));
  }
}

// Protects a night from one shard that does all the work: longest-first is within 4/3 of the best
// (Graham 1969), which is no less than the mean and the longest run.
TEST_CASE("shards are balanced by cost") {
  std::vector<double> costs;
  for (std::uint64_t i = 0; i < 200; ++i) costs.push_back(std::exp(6 * uniform(2, 0, i, 0)));
  const Plan plan = plan_with(costs);
  const double sum = std::accumulate(costs.begin(), costs.end(), 0.0);
  const double longest = *std::max_element(costs.begin(), costs.end());
  for (const std::size_t count : {2, 5, 16}) {
    double most = 0;
    for (std::size_t k = 0; k < count; ++k) {
      double load = 0;
      for (const std::size_t run : runs_of_shard(plan, {k, count})) load += costs[run];
      most = std::max(most, load);
    }
    CHECK(most <= 4.0 / 3 * std::max(sum / static_cast<double>(count), longest));
  }
  const auto loads = [](const Plan& p, std::size_t k) { return runs_of_shard(p, {k, 2}); };
  CHECK(loads(plan_with({1, 1, 4, 2, 2}), 0) == std::vector<std::size_t>{0, 2});
  CHECK(loads(plan_with({1, 1, 4, 2, 2}), 1) == std::vector<std::size_t>{1, 3, 4});
  CHECK(loads(plan_with({0, 0, 0, 0}), 1) == std::vector<std::size_t>{1, 3});
}

// Protects the command line.
TEST_CASE("a shard is K/N from 0") {
  CHECK(*parse_shard("0/1") == Shard{0, 1});
  CHECK(*parse_shard("4/5") == Shard{4, 5});
  for (const char* text : {"", "1", "/", "5/5", "6/5", "-1/5", "0/0", "1/", "/5", "1/5/2", " 1/5",
                           "a/5", "1/99999999999999999999", "0x1/5", "1/2000000"}) {
    const auto shard = parse_shard(text);
    INFO(text);
    REQUIRE_FALSE(shard.ok());
    CHECK(shard.error().kind == ErrorKind::usage);
    CHECK(contains(shard.error().message, "0/N"));
  }
}

Result<std::optional<Shard>> of_variables(const std::map<std::string, std::string>& set) {
  return slurm_shard([&](const char* name) {
    const auto found = set.find(name);
    return found == set.end() ? nullptr : found->second.c_str();
  });
}

// Protects arrays on a cluster: no run left out because an array began at 1.
TEST_CASE("the variables of a SLURM array name a shard") {
  const auto shard = [](const char* id, const char* min, const char* count, const char* step) {
    return of_variables({{"SLURM_ARRAY_TASK_ID", id},
                         {"SLURM_ARRAY_TASK_MIN", min},
                         {"SLURM_ARRAY_TASK_COUNT", count},
                         {"SLURM_ARRAY_TASK_STEP", step}});
  };
  CHECK(**shard("3", "0", "5", "1") == Shard{3, 5});
  CHECK(**shard("5", "1", "5", "1") == Shard{4, 5});
  CHECK(**shard("8", "0", "5", "2") == Shard{4, 5});
  CHECK_FALSE(of_variables({})->has_value());
  CHECK(**of_variables({{"SLURM_ARRAY_TASK_ID", "1"},
                        {"SLURM_ARRAY_TASK_MIN", "1"},
                        {"SLURM_ARRAY_TASK_COUNT", "2"}}) == Shard{0, 2});
  CHECK_FALSE(shard("7", "1", "3", "1").ok());  // --array=1,3,7
  CHECK_FALSE(shard("3", "0", "5", "2").ok());
  // --array=1,3,4: each task is refused, none makes a part that others count on.
  for (const char* id : {"1", "3", "4"}) {
    CHECK_FALSE(of_variables({{"SLURM_ARRAY_TASK_ID", id},
                              {"SLURM_ARRAY_TASK_MIN", "1"},
                              {"SLURM_ARRAY_TASK_MAX", "4"},
                              {"SLURM_ARRAY_TASK_COUNT", "3"},
                              {"SLURM_ARRAY_TASK_STEP", "1"}})
                    .ok());
  }
  CHECK(**of_variables({{"SLURM_ARRAY_TASK_ID", "5"},
                        {"SLURM_ARRAY_TASK_MIN", "1"},
                        {"SLURM_ARRAY_TASK_MAX", "8"},
                        {"SLURM_ARRAY_TASK_COUNT", "4"},
                        {"SLURM_ARRAY_TASK_STEP", "2"}}) == Shard{2, 4});
  CHECK_FALSE(shard("3", "4", "5", "1").ok());
  CHECK_FALSE(shard("x", "0", "5", "1").ok());
  CHECK_FALSE(shard("3", "0", "", "1").ok());
  CHECK_FALSE(shard("3", "0", "5", "0").ok());
  check_fails(of_variables({{"SLURM_ARRAY_TASK_ID", "3"}}), {"SLURM_ARRAY_TASK_COUNT=(not set)"});
}

// Protects sequences: none left out, none made twice, no shard with two more than another.
TEST_CASE("shards of equal pieces follow each other") {
  for (const std::uint32_t count : {0u, 1u, 5u, 7u, 4'294'967'295u}) {
    for (const std::size_t shards : {1u, 2u, 3u, 5u, 8u, 1'000'000u}) {
      std::uint32_t next = 0, least = count, most = 0;
      for (std::size_t k = 0; k < shards; ++k) {
        const auto [first, last] = range_of_shard(count, {k, shards});
        if (first != next || last < first) FAIL(count << " over " << shards << ", shard " << k);
        least = std::min(least, last - first);
        most = std::max(most, last - first);
        next = last;
      }
      CHECK(next == count);
      CHECK(most - least <= 1);
    }
  }
}

}  // namespace
}  // namespace ensonify
