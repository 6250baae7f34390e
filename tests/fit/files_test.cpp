// Keys as words, and the simulations of a fit on disk.
#include <cmath>
#include <fstream>

#include "catch.h"
#include "fit/fit_text.h"
#include "fit/moment_samples.h"
#include "results.h"
#include "temporary_folder.h"

using namespace ensonify;
using ensonify::test::TemporaryFolder;

namespace {

const std::vector<double> kFirst = {1.25, -3e-7}, kSecond = {2, 1.0 / 3};

MomentSample sample(double shift) {
  return {{shift, std::nan("")}, {0.1, 0.2}, {{shift, shift + 1}, {std::nan(""), 3}}};
}

bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

void check_same(const MomentSample& a, const MomentSample& b) {
  REQUIRE(a.value.size() == b.value.size());
  for (std::size_t m = 0; m < a.value.size(); ++m) {
    CHECK(same(a.value[m], b.value[m]));
    CHECK(same(a.error[m], b.error[m]));
    for (std::size_t k = 0; k < a.pseudo[m].size(); ++k) CHECK(same(a.pseudo[m][k], b.pseudo[m][k]));
  }
}

}  // namespace

TEST_CASE("a key of the command line has a path, a range and perhaps log") {
  const auto key = value_of(parse_key("materials.sand.reflectivity=1e-4:2e-2:log"));
  CHECK(key.path == "materials.sand.reflectivity");
  CHECK(key.low == 1e-4);
  CHECK(key.high == 2e-2);
  CHECK(key.log);
  CHECK_FALSE(parse_key("sonar.mount.position_m.2=-1:1")->log);
  for (const char* wrong : {"sonar.range_max_m", "=1:2", "a=1", "a=2:1", "a=1:1", "a=x:2", "a=1:2:lin",
                            "a=0:1:log", "a=1:inf", "a=1:nan"}) {
    const auto refused = parse_key(wrong);
    INFO(wrong);
    REQUIRE_FALSE(refused.ok());
    CHECK(contains(refused.error().message, "expected PATH=LOW:HIGH"));
  }
}

// Protects resuming: the numbers that were written come back to the last bit.
TEST_CASE("simulations are read back, and a cut line is lost alone") {
  const TemporaryFolder folder;
  const auto file = folder.path() / "evaluations.jsonl";
  {
    auto written = value_of(Evaluations::open(file, "id"));
    CHECK(written.add(kFirst, sample(0.1)).ok());
    CHECK(written.add(kSecond, sample(1.0 / 7)).ok());
  }
  {
    std::ofstream(file, std::ios::app) << "{\"keys\": [4, 5], \"value\": [";
  }
  auto read = value_of(Evaluations::open(file, "id"));
  CHECK(read.size() == 2);
  REQUIRE(read.find(kSecond) != nullptr);
  check_same(*read.find(kSecond), sample(1.0 / 7));
  CHECK(read.find(std::vector<double>{2, 0.333}) == nullptr);
  CHECK(read.add(std::vector<double>{4, 5}, sample(2)).ok());
  const auto again = value_of(Evaluations::open(file, "id"));
  CHECK(again.size() == 3);
}

TEST_CASE("simulations of another fit are refused") {
  const TemporaryFolder folder;
  const auto file = folder.path() / "evaluations.jsonl";
  REQUIRE(Evaluations::open(file, "one").ok());
  check_fails(Evaluations::open(file, "two"), ErrorKind::usage);
  CHECK(Evaluations::open(file, "one").ok());
}

// Protects the card: it holds the keys as a scenario does, and what has no place in a map as --set.
TEST_CASE("the card has the keys in their sections") {
  const std::vector<FitKey> keys = {{"noise.spectrum_level_db", 30, 60, false},
                                    {"sonar.beams.receive_width_deg", 0.5, 2, true},
                                    {"sonar.bandwidth_hz", 1e4, 3e4, false},
                                    {"objects.0.pose.position_m.2", -3, -1, false}};
  Fit fit;
  for (const double value : {47.5, 0.9, 2e4, -2.0}) {
    FittedKey key;
    key.value = value;
    key.low = value - 0.125;
    key.high = value + 0.125;
    key.identified = value < 1;
    fit.keys.push_back(key);
  }
  FitFacts facts;
  facts.scenario = "scene.yaml";
  const std::string card = fit_card(keys, fit, facts);
  CHECK(contains(card, "# --set objects.0.pose.position_m.2=-2  # -2.125 to -1.875, identified\n"));
  CHECK(contains(card,
                 "noise:\n  spectrum_level_db: 47.5  # 47.375 to 47.625, not identified\n"
                 "sonar:\n  bandwidth_hz: 20000  # 20000 to 20000, not identified\n"
                 "  beams:\n    receive_width_deg: 0.9  # 0.775 to 1.025, identified\n"));
}
