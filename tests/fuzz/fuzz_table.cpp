// Tables of pulses, of bottom echoes and of sound speeds, and paths, by the first byte.
#include <cmath>
#include <cstdlib>

#include "fuzz_file.h"
#include "mutate_text.h"
#include "scenario/tables.h"
#include "world/path.h"

using namespace ensonify;

namespace {

// What a path must keep, whatever its file holds: rising times and rotations of unit length.
bool is_path(const Result<SampledPath>& path) {
  if (!path) return false;
  double before_s = -HUGE_VAL;
  for (const PathPoint& point : path->points) {
    const Quat& q = point.pose.rotation;
    const double norm = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
    if (!(point.time_s > before_s) || !std::isfinite(length(point.pose.position_m)) ||
        !(std::abs(norm - 1) < 1e-9)) {
      std::abort();
    }
    before_s = point.time_s;
  }
  return true;
}

bool is_read(unsigned kind, const std::filesystem::path& csv, std::string_view bytes) {
  if (kind == 0) {
    Sonar sonar;
    sonar.frequency_hz = 900e3;
    sonar.bandwidth_hz = 30e3;
    return load_pulse_table(csv, sonar).ok();
  }
  if (kind == 1) return load_backscatter_table(csv).ok();
  if (kind == 2) return load_sound_profile(csv).ok();
  if (kind == 3) return is_path(load_path_file(csv));
  return is_path(load_path_file(test::fuzz_file("t.tum", bytes)));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string_view bytes = test::text_of(data + 1, size - 1);
  const auto csv = test::fuzz_file("t.csv", bytes);
  if (is_read(data[0] % 5, csv, bytes)) test::accepted();
  return 0;
}
