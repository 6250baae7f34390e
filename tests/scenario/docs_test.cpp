#include "catch.h"
#include "scenario/tables.h"
#include "scenario_schema.h"
#include "scenario_texts.h"
#include "temporary_folder.h"

namespace ensonify {
namespace {

using testing::docs_blocks;
using testing::kHead;

// The page's own tables, under the names that its examples use.
void write_tables(const test::TemporaryFolder& folder) {
  for (const std::string& block : docs_blocks("csv")) {
    folder.write(block.starts_with("frequency_hz") ? "pulse.csv"
                 : block.starts_with("depth_m")    ? "cast.csv"
                                                   : "sand.csv",
                 block);
  }
}

// Protects whoever copies from the page: a whole scenario stands for itself, a part of one is laid
// beside a preset.
TEST_CASE("every example of the documentation is valid") {
  const test::TemporaryFolder folder;
  write_tables(folder);
  const auto examples = docs_blocks("yaml");
  CHECK(examples.size() >= 5);
  for (const std::string& example : examples) {
    const bool whole = example.starts_with("ensonify:");
    const bool has_sonar = example.starts_with("sonar:");
    const std::string text = whole       ? example
                             : has_sonar ? "ensonify: 1\n" + example
                                         : kHead + example;
    const auto scenario = parse_scenario(text, "example.yaml", folder.path());
    INFO(text << (scenario.ok() ? "" : scenario.error().message));
    CHECK(scenario.ok());
  }
}

TEST_CASE("every table of the documentation is valid") {
  const test::TemporaryFolder folder;
  write_tables(folder);
  CHECK(docs_blocks("csv").size() == 3);
  const auto scenario = testing::parse(kHead);
  REQUIRE(scenario.ok());
  const auto pulse = load_pulse_table(folder.path() / "pulse.csv", sonar_of(*scenario));
  INFO((pulse.ok() ? "" : pulse.error().message));
  CHECK(pulse.ok());
  const auto sand = load_backscatter_table(folder.path() / "sand.csv");
  INFO((sand.ok() ? "" : sand.error().message));
  CHECK(sand.ok());
  const auto cast = load_sound_profile(folder.path() / "cast.csv");
  INFO((cast.ok() ? "" : cast.error().message));
  CHECK(cast.ok());
}

}  // namespace
}  // namespace ensonify
