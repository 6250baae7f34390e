// Sweep files over a base that is there, with the points of those that are small.
#include "fuzz_file.h"
#include "mutate_text.h"
#include "sweep/sweep_file.h"

using namespace ensonify;

namespace {

constexpr char kBase[] = R"(ensonify: 1
name: base
sonar: {preset: blueview_p900_90, range_max_m: 5}
materials: {steel: {reflectivity: 1e-2}}
objects:
  - {name: ball, class: target, material: steel, shape: {sphere: {radius_m: 0.2}}, pose: {position_m: [4, 0, 0]}}
trajectory: {ping_rate_hz: 5, pings: 1}
)";

constexpr std::size_t kMostPoints = 200;

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto base = test::fuzz_file("base.yaml", kBase);
  const std::string text(test::text_of(data, size));
  const auto sweep = parse_sweep_file(text, "fuzzed.yaml", test::fuzz_folder(), test::kFuzzLimits);
  if (!sweep || sweep->product > kMostPoints) return 0;
  const auto points = points_of(*sweep);
  if (!points) return 0;
  test::accepted();
  test::promise(!points->empty() && points->size() <= sweep->product);
  for (const Point& point : *points) {
    name_of(*sweep, point);
    settings_of(*sweep, point);
  }
  return 0;
}
