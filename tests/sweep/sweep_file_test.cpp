#include "results.h"
#include "sweeps.h"

namespace ensonify {
namespace {

using testing::faults_of;
using testing::SweepFolder;

const std::string kAxes = "axes: [{key: sonar.range_max_m, values: [5, 10]}]\n";

// Protects the head and the keys around the axes.
TEST_CASE("a sweep file is read whole") {
  const SweepFolder folder;
  const auto sweep =
      value_of(folder.parse(kAxes + "set: {trajectory.pings: 5, seed: 100}\n"
                                    "seeds: 3\n"
                                    "run_name: \"r{range_max_m}_s{seed}\"\n"
                                    "skip_if: [\"range_max_m > 7 && seed == 101\"]\n"));
  CHECK(sweep.name == "s");
  CHECK(sweep.base == folder.path() / "base.yaml");
  CHECK(sweep.seeds == std::vector<std::uint64_t>{100, 101, 102});
  CHECK(sweep.product == 6);
  const auto points = value_of(points_of(sweep));
  std::vector<std::string> names;
  for (const Point& point : points) names.push_back(name_of(sweep, point));
  CHECK(names == std::vector<std::string>{"r5_s100", "r5_s101", "r5_s102", "r10_s100", "r10_s102"});
}

// Protects the order of a plan: the last axis fastest, seeds faster still, zipped axes as one.
TEST_CASE("points come in the order of the axes") {
  const SweepFolder folder;
  const auto sweep =
      value_of(folder.parse("axes:\n"
                            "  - {key: noise.snr_db, values: [1, 2]}\n"
                            "  - zip:\n"
                            "      - {key: sonar.beams.count, values: [64, 128]}\n"
                            "      - {name: kind, values: [{seed: 1}, {}], labels: [a, b]}\n"));
  const auto points = value_of(points_of(sweep));
  std::vector<std::string> names;
  for (const Point& point : points) names.push_back(name_of(sweep, point));
  CHECK(names == std::vector<std::string>{"snr_db=1,count=64,kind=a", "snr_db=1,count=128,kind=b",
                                          "snr_db=2,count=64,kind=a", "snr_db=2,count=128,kind=b"});
  CHECK(settings_of(sweep, points[0]).size() == 3);
  CHECK(settings_of(sweep, points[1]).size() == 2);
}

// Protects conditions on what is no number: truth values are 0 and 1, words the place in the list.
TEST_CASE("conditions know truth values and places in a list") {
  const SweepFolder folder;
  const auto left = [&](const std::string& condition) {
    const auto sweep = value_of(
        folder.parse("axes:\n"
                     "  - {key: output.polar, values: [true, false]}\n"
                     "  - {key: scattering.speckle, values: [per_ping, per_ray, surface]}\n"
                     "skip_if: [\"" +
                     condition + "\"]\n"));
    const auto points = value_of(points_of(sweep));
    return points.size();
  };
  CHECK(left("polar") == 3);
  CHECK(left("!polar && speckle == 2") == 5);
  CHECK(left("speckle >= 1 || polar != 1") == 1);
  CHECK(left("max(polar, speckle) > 1") == 4);
}

// Protects whoever writes a sweep: each fault once, in its place, with advice.
TEST_CASE("faults of a sweep file") {
  const struct {
    std::string added, begin, essential;
  } cases[] = {
      {"", "1:1: axes: ", "missing; expected axes or seeds"},
      {"axes: []\n", "3:7: axes: ", "empty"},
      {"axes: 5\n", "3:7: axes: ", "expected a list"},
      {kAxes + "skipif: []\n", "4:1: skipif: ", "(did you mean skip_if?)"},
      {kAxes + "name: 7\n", "4:7: name: ", "unless it is quoted"},
      {kAxes + "seed: -1\n", "4:7: seed: ", "expected an integer"},
      {kAxes + "seeds: 0\n", "4:8: seeds: ", "out of range"},
      {kAxes + "seeds: []\n", "4:8: seeds: ", "found a list of length 0"},
      {kAxes + "seeds: [1, 2, 1]\n", "4:15: seeds.2: ", "given twice"},
      {kAxes + "seeds: [1, x]\n", "4:12: seeds.1: ", "not a number"},
      {kAxes + "set: {seed: 18446744073709551615}\nseeds: 2\n", "5:8: seeds: ", "a list of seeds"},
      {"axes: [{key: seed, values: [1]}]\nseeds: 2\n", "4:8: seeds: ", "expected only one"},
      {kAxes + "set: 3\n", "4:6: set: ", "a map of key paths"},
      {kAxes + "set: {sonar.range_max_m: 3}\n", "4:7: set.sonar.range_max_m: ", "has no effect"},
      {kAxes + "set: {seed.a: 3}\n", "4:7: seed.a: ", "plain value"},
      {kAxes + "set: {a..b: 3}\n", "4:7: a..b: ", "empty key"},
      {kAxes + "set: {objects.bal.name: x}\n", "4:7: objects.bal.name: ", "names no item"},
      {kAxes + "run_name: \"{range_mx_m}\"\n", "4:11: run_name: ", "(did you mean range_max_m?)"},
      {kAxes + "run_name: \"{range_max_m\"\n", "4:11: run_name: ", "do not match"},
      {kAxes + "run_name: \"a}\"\n", "4:11: run_name: ", "do not match"},
      {kAxes + "run_name: \"{{seed}}\"\n", "4:11: run_name: ", "do not match"},
      {kAxes + "skip_if: \"a\"\n", "4:10: skip_if: ", "a list"},
      {kAxes + "skip_if: [[1]]\n", "4:11: skip_if.0: ", "expected one line"},
      {kAxes + "skip_if: [\"range_mx_m > 3\"]\n", "4:11: skip_if.0: ", "did you mean range_max_m?"},
      {kAxes + "skip_if: [\"range_max_m = 3\"]\n", "4:11: skip_if.0: ", "expected =="},
      {kAxes + "skip_if: [\"range_max_m += 3\"]\n", "4:11: skip_if.0: ", "expected =="},
      {kAxes + "skip_if: [\"range_max_m > (3\"]\n", "4:11: skip_if.0: ", "expected a condition"},
      {kAxes + "skip_if: [\"1, 2\"]\n", "4:11: skip_if.0: ", "several values"},
      {"axes: [{key: a.b, linear: [0, 1], count: 1000}, {key: a.c, linear: [0, 1], count: 1000}]\n",
       "3:7: axes: ", "more than 100000 points"},
  };
  const SweepFolder folder;
  for (const auto& c : cases) {
    const auto lines = faults_of(folder.parse(c.added));
    INFO(c.added << "\n" << joined_lines(lines));
    REQUIRE(lines.size() == 1);
    CHECK(lines[0].starts_with("s.yaml:" + c.begin));
    CHECK(contains(lines[0], c.essential));
  }
}

// Protects a first look at a wrong file: sweep and base at once, each under its own name.
TEST_CASE("all faults of sweep and base text come together") {
  const SweepFolder folder("ensonify: 1\nsonar: {preset: a, preset: b}\n");
  const auto lines = faults_of(
      folder.parse("axs: 3\n" + kAxes + "run_name: \"{x}\"\nskip_if: [\"y\"]\nseeds: x\n"));
  INFO(joined_lines(lines));
  REQUIRE(lines.size() == 5);
  CHECK(lines[0].starts_with("s.yaml:3:1: axs: "));
  CHECK(lines[4].starts_with((folder.path() / "base.yaml").string() + ":2:20: sonar.preset: "));
  const auto missing = faults_of(
      parse_sweep_file("ensonify_sweep: 1\nbase: none.yaml\n" + kAxes, "s.yaml", folder.path()));
  REQUIRE(missing.size() == 1);
  CHECK(missing[0].starts_with("s.yaml:2:7: base: "));
  CHECK(contains(missing[0], "no such file"));
}

// Protects the reason why a run is left out, and a plan from being empty.
TEST_CASE("conditions without a value, and those that leave nothing, are refused") {
  const SweepFolder folder;
  for (const auto& [condition, essential] :
       {std::pair{"1 / (range_max_m - 5) > 0", "no finite value"},
        std::pair{"sqrt(-range_max_m) > 0", "no finite value"},
        std::pair{"log10(range_max_m - 5) > 0", "no finite value"},
        std::pair{"range_max_m > 0", "skips every run"}}) {
    const auto sweep = value_of(folder.parse(kAxes + "skip_if: [\"" + condition + "\"]\n"));
    const auto lines = faults_of(points_of(sweep));
    REQUIRE(lines.size() == 1);
    INFO(lines[0]);
    CHECK(lines[0].starts_with("s.yaml:4:1"));
    CHECK(contains(lines[0], essential));
  }
}

// Protects the program from whatever is handed to it: a wrong text ends in a message with a place.
TEST_CASE("damaged sweep files are refused or read") {
  const SweepFolder folder;
  const std::string whole =
      testing::kSweepHead + kAxes +
      "  - {name: k, values: [{noise.snr_db: 1}, {seed: 2}], labels: [a, b]}\n"
      "set: {trajectory.pings: 5}\nseeds: [1, 2]\n"
      "run_name: \"{range_max_m}\"\nskip_if: [\"range_max_m > 7\"]\n";
  const std::string bytes = "{}[]:,\"'#&*!|>%@`-=+0123456789\n\t x\x01\x80";
  std::uint64_t state = 1;
  const auto next = [&](std::size_t below) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return static_cast<std::size_t>((state >> 33) % below);
  };
  std::size_t refused = 0;
  for (int i = 0; i < 1500; ++i) {
    std::string text = whole;
    for (std::size_t change = 1 + next(3); change > 0; --change) {
      const std::size_t at = next(text.size());
      switch (next(3)) {
        case 0:
          text[at] = bytes[next(bytes.size())];
          break;
        case 1:
          text.erase(at, 1 + next(9));
          break;
        default:
          text.insert(at, text.substr(next(text.size()), next(12)));
      }
    }
    const auto sweep = parse_sweep_file(text, "s.yaml", folder.path());
    if (sweep.ok()) {
      (void)points_of(*sweep);
      continue;
    }
    ++refused;
    INFO(text << "\n" << sweep.error().message);
    CHECK(sweep.error().kind == ErrorKind::usage);
    CHECK_FALSE(faults_of(sweep).empty());
    for (const std::string& line : faults_of(sweep)) {
      CHECK((line.starts_with("s.yaml:") || line.starts_with("and ") ||
             line.starts_with((folder.path() / "base.yaml").string())));
    }
  }
  CHECK(refused > 500);
}

}  // namespace
}  // namespace ensonify
