// The scenario parser; what it accepts must come back from its own resolved text.
#include "fuzz_file.h"
#include "mutate_text.h"
#include "scenario/scenario.h"

using namespace ensonify;
using test::promise;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(test::text_of(data, size));
  const auto name = [](const std::filesystem::path& file) { return file.string(); };
  const Result<Scenario> scenario =
      parse_scenario(text, "fuzzed.yaml", test::fuzz_folder(), {}, 0, test::kFuzzLimits);
  if (!scenario) {
    promise(!scenario.error().message.empty());
    return 0;
  }
  test::accepted();
  const std::string resolved = to_yaml(*scenario, name);
  const Result<Scenario> again = parse_scenario(resolved, "resolved.yaml", test::fuzz_folder());
  promise(again.ok());
  promise(to_yaml(*again, name) == resolved);
  return 0;
}
