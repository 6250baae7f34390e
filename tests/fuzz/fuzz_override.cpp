// --set: a key path, '=', and a value, put into a scenario that is in order.
#include "fuzz_file.h"
#include "mutate_text.h"
#include "scenario/scenario.h"

using namespace ensonify;

namespace {

constexpr char kBase[] = R"(ensonify: 1
name: fuzzed
sonar: {preset: blueview_p900_90}
materials: {steel: {reflectivity: 1e-2}}
objects:
  - {name: ball, class: target, material: steel, shape: {sphere: {radius_m: 0.2}}, pose: {position_m: [4, 0, 0]}}
trajectory: {ping_rate_hz: 5, pings: 3}
)";

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text = test::text_of(data, size);
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos) return 0;
  const Override set{std::string(text.substr(0, equals)), std::string(text.substr(equals + 1))};
  const auto scenario =
      parse_scenario(kBase, "base.yaml", test::fuzz_folder(), {set}, 0, test::kFuzzLimits);
  if (scenario) {
    test::accepted();
  } else {
    test::promise(!scenario.error().message.empty());
  }
  return 0;
}
