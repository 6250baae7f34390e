// What distributions can give, against what their keys accept.
#include "catch.h"
#include "scenario_texts.h"

namespace ensonify {
namespace {

using testing::kHead;
using testing::tells;

std::vector<std::string> faults_at_extremes(const std::string& added,
                                            const std::vector<Override>& overrides = {}) {
  const Status checked = check_draws(kHead + added, "t.yaml", ".", overrides);
  if (checked.ok()) return {};
  CHECK(checked.error().kind == ErrorKind::usage);
  return lines_of(checked.error().message);
}

struct ExtremeCase {
  std::string added, begin, essential;
};

}  // namespace

// Protects "at once": both ends of each distribution, with place, key and the distribution.
TEST_CASE("a distribution that leaves the range of its key is refused with its place") {
  const ExtremeCase cases[] = {
      {"water: {sound_speed_m_s: {uniform: [1400, 20000]}}",
       "t.yaml:4:26: water.sound_speed_m_s: ", "{uniform: [1400, 20000]} reaches it"},
      {"water: {sound_speed_m_s: {uniform: [50, 1500]}}",
       "t.yaml:4:26: water.sound_speed_m_s: ", "from 100 to 10000"},
      {"water: {sound_speed_m_s: {log_uniform: [1, 1500]}}",
       "t.yaml:4:26: water.sound_speed_m_s: ", "{log_uniform: [1, 1500]} reaches it"},
      {"trajectory: {pings: {uniform: [0, 5]}}", "t.yaml:4:21: trajectory.pings: ", "from 1 to"},
      {"water: {sound_speed_m_s: {choice: [1500, 1501, 3]}}",
       "t.yaml:4:48: water.sound_speed_m_s: ", "from 100 to 10000"},
      {"water: {sound_speed_m_s: {uniform: [1400, {uniform: [1500, 11000]}]}}",
       "t.yaml:4:26: water.sound_speed_m_s: ", "reaches it"},
  };
  for (const auto& [added, begin, essential] : cases) {
    const auto lines = faults_at_extremes(added);
    INFO(added << "\n" << joined_lines(lines));
    CHECK(lines.size() == 1);
    CHECK(tells(lines, begin, essential));
  }
}

// Protects alternatives of alternatives: each is looked at, with the ends of its own distributions.
TEST_CASE("every alternative of nested choices is checked") {
  for (const char* wrong :
       {"{uniform: [1500, 20000]}", "{choice: [1500, {uniform: [3, 5]}]}", "7"}) {
    for (int at = 0; at < 3; ++at) {
      std::string list;
      for (int i = 0; i < 3; ++i) {
        list += std::string(i > 0 ? ", " : "") + (i == at ? wrong : "{choice: [1500, 1501]}");
      }
      const std::string added = "water: {sound_speed_m_s: {choice: [" + list + "]}}";
      INFO(added);
      CHECK(faults_at_extremes(added).size() >= 1);
    }
  }
  CHECK(faults_at_extremes("water: {sound_speed_m_s: {choice: [1500, {choice: [1501, {uniform: "
                           "[1400, 1600]}]}]}}")
            .empty());
}

// Protects scenarios that are right: an end that is excluded is never drawn, a normal distribution
// is looked at to three standard deviations, and what only holds where draws meet is not known yet.
TEST_CASE("a distribution that stays in the range of its key is accepted") {
  for (const char* added : {
           "water: {sound_speed_m_s: {uniform: [100, 10000]}}",
           "trajectory: {ping_rate_hz: {uniform: [0, 5]}}",
           "water: {sound_speed_m_s: {normal: [1000, 299]}}",
           "trajectory: {pings: {uniform: [1, 1000000]}}",
       }) {
    INFO(added << "\n" << joined_lines(faults_at_extremes(added)));
    CHECK(faults_at_extremes(added).empty());
  }
  CHECK(faults_at_extremes("water: {sound_speed_m_s: {normal: [1000, 301]}}").size() == 1);
  CHECK(faults_at_extremes("", {{"sonar.range_max_m", "{uniform: [-1, 5]}"}}).size() == 1);
}

// Protects errors that go into data sets: the same wherever the scenario lies.
TEST_CASE("errors without places name the key alone") {
  const auto wrong = parse_scenario(kHead + "water: {sound_speed_m_s: 3}\nsplits: {train: -1}\n",
                                    "dir/t.yaml", ".", {}, 0, {}, ErrorPlaces::hidden);
  REQUIRE_FALSE(wrong.ok());
  const std::string& text = wrong.error().message;
  INFO(text);
  CHECK(text.starts_with("splits.train: "));
  CHECK(contains(text, "\nwater.sound_speed_m_s: "));
  CHECK_FALSE(contains(text, "t.yaml"));
}

}  // namespace ensonify
