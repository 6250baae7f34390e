#include <cmath>
#include <set>

#include "results.h"
#include "sweeps.h"

namespace ensonify {
namespace {

using testing::SweepFolder;

// Protects what a sweep says it visits: both ends, equal steps, equal ratios.
TEST_CASE("linear and log values include both ends", "[serial]") {
  CHECK(linear_values(3e5, 9e5, 4) == std::vector<double>{3e5, 5e5, 7e5, 9e5});
  CHECK(linear_values(0.1, 0.5, 5) == std::vector<double>{0.1, 0.2, 0.3, 0.4, 0.5});
  CHECK(linear_values(2, -2, 3) == std::vector<double>{2, 0, -2});
  CHECK(log_values(1e3, 1e5, 5) == std::vector<double>{1e3, 3162.28, 1e4, 31622.8, 1e5});
  CHECK(log_values(1e5, 1e3, 3) == std::vector<double>{1e5, 1e4, 1e3});
  CHECK(log_values(0.123456789, 0.987654321, 2) == std::vector<double>{0.123456789, 0.987654321});
  CHECK(linear_values(7, 9, 1) == std::vector<double>{7});
}

// Protects plans from arithmetic that differs between machines: what is drawn has six digits, and
// stays when more is drawn.
TEST_CASE("random values are few digits, inside, and stay when their number grows", "[serial]") {
  const auto some = uniform_values(20, 60, 8, 42);
  const auto more = uniform_values(20, 60, 1000, 42);
  const auto logs = log_uniform_values(1e-3, 1, 1000, 42);
  CHECK(std::equal(some.begin(), some.end(), more.begin()));
  CHECK(uniform_values(20, 60, 8, 43) != some);
  std::set<double> different(more.begin(), more.end());
  CHECK(different.size() > 990);
  double sum = 0, log_sum = 0;
  for (std::size_t i = 0; i < more.size(); ++i) {
    CHECK((more[i] >= 20 && more[i] <= 60 && logs[i] >= 1e-3 && logs[i] <= 1));
    CHECK(std::abs(more[i] * 1e4 - std::round(more[i] * 1e4)) < 1e-6);
    sum += more[i];
    log_sum += std::log10(logs[i]);
  }
  // 1000 draws: standard errors 40/sqrt(12 * 1000) = 0.37 and 3/sqrt(12 * 1000) = 0.027.
  CHECK(std::abs(sum / 1000 - 40) < 1.1);
  CHECK(std::abs(log_sum / 1000 + 1.5) < 0.082);
}

// Protects counts and rays: all whole numbers of a range, both ends too, and no other.
TEST_CASE("keys that take whole numbers are given whole numbers", "[serial]") {
  std::set<double> seen;
  for (const double value : uniform_values(1, 4, 200, 1, true)) seen.insert(value);
  CHECK(seen == std::set<double>{1, 2, 3, 4});
  const SweepFolder folder;
  const auto sweep =
      value_of(folder.parse("axes: [{key: sonar.beams.count, log: [16, 500], count: 4}]\n"));
  std::vector<std::string> labels;
  for (const AxisValue& value : sweep.axes[0].axes[0].values) labels.push_back(value.label);
  CHECK(labels == std::vector<std::string>{"16", "50", "159", "500"});
}

// Protects two axes of the same kind from going up and down together.
TEST_CASE("random axes are drawn apart by name and seed", "[serial]") {
  const SweepFolder folder;
  const std::string axes =
      "axes:\n"
      "  - {key: noise.snr_db, name: a, uniform: [0, 1], count: 3}\n"
      "  - {key: sonar.source_level_db, name: b, uniform: [0, 1], count: 3}\n";
  const auto one = folder.parse(axes), other = folder.parse(axes + "seed: 1\n");
  REQUIRE(one.ok());
  REQUIRE(other.ok());
  const auto number = [](const Result<SweepFile>& sweep, std::size_t axis) {
    return sweep->axes[axis].axes[0].values[0].number;
  };
  CHECK(number(one, 0) != number(one, 1));
  CHECK(number(one, 0) != number(other, 0));
}

// Protects whoever writes axes: each wrong one with its place and what is accepted, no other fault.
TEST_CASE("faults of axes", "[serial]") {
  const struct {
    std::string axis, begin, essential;
  } cases[] = {
      {"{key: a.b, values: []}",
       "3:27: axes.0.values: ", "found a list of length 0; expected 1 to"},
      {"{key: a.b, values: 5}", "3:27: axes.0.values: ", "expected a list"},
      {"{key: a.b, valuess: [1]}", "3:19: axes.0.valuess: ", "(did you mean values?)"},
      {"{key: a.b, values: [1], count: 3}", "3:39: axes.0.count: ", "has no effect with values"},
      {"{key: a.b, linear: [1, 2]}", "3:8: axes.0.count: ", "missing"},
      {"{key: a.b, linear: [1], count: 2}", "3:27: axes.0.linear: ", "a list of 2 numbers"},
      {"{key: a.b, linear: [1, x], count: 2}", "3:31: axes.0.linear.1: ", "`x` is not a number"},
      {"{key: a.b, linear: [1, 2], count: 0}", "3:42: axes.0.count: ", "out of range"},
      {"{key: a.b, log: [0, 2], count: 3}", "3:24: axes.0.log: ", "above zero"},
      {"{key: a.b, uniform: [3, 2], count: 3}", "3:28: axes.0.uniform: ", "a <= b"},
      {"{key: a.b, log: [1, 2], linear: [1, 2], count: 3}", "3:32: axes.0: ", "exclude each other"},
      {"{key: a.b}", "3:8: axes.0: ", "missing; expected one of values"},
      {"{linear: [1, 2], count: 3, name: x}", "3:8: axes.0.key: ", "missing next to linear"},
      {"{key: a.b, linear: [1, 2], count: 2, labels: [x, y]}",
       "3:53: axes.0.labels: ", "has no effect"},
      {"{values: [{a.b: 1}]}", "3:8: axes.0.name: ", "missing"},
      {"{name: x, values: [1]}", "3:27: axes.0.values.0: ", "a map of key paths"},
      {"{key: a.b, values: [1, 2], labels: [x]}", "3:43: axes.0.labels: ", "1 labels for 2 values"},
      {"{key: a.b, values: [1, 2], labels: [x, x]}", "3:47: axes.0.labels.1: ", "given twice"},
      {"{key: a.b, values: [1], labels: [7]}", "3:41: axes.0.labels.0: ", "unless it is quoted"},
      {"{key: a.b, name: seed, values: [1]}", "3:25: axes.0.name: ", "another name"},
      {"{key: a.b, name: a-b, values: [1]}", "3:25: axes.0.name: ", "letters, digits and _"},
      {"{key: poses.0, values: [1]}", "3:8: axes.0.name: ", "given by `name`"},
      {"7", "3:8: axes.0: ", "expected a map"},
      {"{zip: [{key: a.b, values: [1]}]}", "3:14: axes.0.zip: ", "fewer than two axes"},
      {"{zip: 3}", "3:14: axes.0.zip: ", "a list"},
      {"{zip: [{key: a.b, values: [1]}, {key: a.c, values: [1, 2]}]}",
       "3:40: axes.0.zip: ", "`c` has 2 values, but `b` has 1"},
      {"{zip: [{key: a.b, values: [1]}, {zip: []}]}", "3:46: axes.0.zip.1.zip: ", "inside a zip"},
      {"{zip: [{key: a.b, values: [1]}, {key: a.c, values: [1]}], count: 2}",
       "3:66: axes.0.count: ", "unknown key"},
      {"{key: a.b, values: [1]}, {key: c.b, values: [1]}",
       "3:33: axes: ", "two axes have the name `b`"},
      {"{key: a.b, values: [1]}, {key: a.b, name: c, values: [1]}",
       "3:39: axes: ", "`a.b` already belongs to the axis `b`"},
  };
  const SweepFolder folder;
  for (const auto& c : cases) {
    const auto lines = testing::faults_of(folder.parse("axes: [" + c.axis + "]\n"));
    INFO(c.axis << "\n" << joined_lines(lines));
    REQUIRE(lines.size() == 1);
    CHECK(lines[0].starts_with("s.yaml:" + c.begin));
    CHECK(contains(lines[0], c.essential));
  }
}

// Protects memory: 200 axes of the largest count, in 15 kB of text, took 5.7 GB and more than a
// minute.
TEST_CASE("axes that count for too much together are refused", "[serial]") {
  std::string axes = "axes:\n  - zip:\n";
  for (int i = 0; i < 6; ++i) {
    axes += "    - {key: a.b" + std::to_string(i) + ", uniform: [1, 2], count: 100000}\n";
  }
  const SweepFolder folder;
  const auto lines = testing::faults_of(folder.parse(axes));
  INFO(joined_lines(lines));
  REQUIRE_FALSE(lines.empty());
  CHECK(lines[0].starts_with("s.yaml:10:28: axes.0.zip.5.uniform: "));
  CHECK(contains(lines[0], "produce more than 500000 values"));
}

}  // namespace
}  // namespace ensonify
