#include "catch.h"
#include "scenario/tables.h"
#include "scenario_schema.h"
#include "scenario_texts.h"
#include "temporary_folder.h"

namespace ensonify {
namespace {

using testing::docs_blocks;
using testing::kHead;

// The page's own tables, which its examples name. The examples themselves are among the Samples of
// schema_test.cpp.
TEST_CASE("every table of the documentation is valid") {
  const test::TemporaryFolder folder;
  CHECK(docs_blocks("csv").size() == 3);
  for (const std::string& block : docs_blocks("csv")) {
    folder.write(block.starts_with("frequency_hz") ? "pulse.csv"
                 : block.starts_with("depth_m")    ? "cast.csv"
                                                   : "sand.csv",
                 block);
  }
  value_of(
      load_pulse_table(folder.path() / "pulse.csv", sonar_of(value_of(testing::parse(kHead)))));
  value_of(load_backscatter_table(folder.path() / "sand.csv"));
  value_of(load_sound_profile(folder.path() / "cast.csv"));
}

}  // namespace
}  // namespace ensonify
