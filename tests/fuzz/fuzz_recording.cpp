// Logs of ARIS and Oculus sonars and MCAP files, told apart by their first bytes.
#include <algorithm>

#include "fuzz_file.h"
#include "recordings/log.h"
#include "recordings/sequences.h"

using namespace ensonify;

namespace {

Status check_frame(const LogFrame& frame) {
  const LogSettings& s = frame.settings;
  const auto beams = static_cast<std::size_t>(s.beams),
             samples = static_cast<std::size_t>(s.samples);
  test::promise(beams >= 2 && samples >= 2);
  test::promise(frame.counts.size() == beams * samples * static_cast<std::size_t>(s.bits / 8));
  test::promise(frame.row_gain.size() == (s.row_gains ? samples : 0));
  test::promise(s.azimuth_rad.size() == beams &&
                std::is_sorted(s.azimuth_rad.begin(), s.azimuth_rad.end(), std::less_equal<>()));
  test::promise(s.range_step_m > 0 && s.first_range_m >= 0 && s.sound_speed_m_s > 0);
  test::promise(same_sequence(s, s));
  if (s.bits <= 16) test::promise(log_levels_db(frame).size() == beams * samples);
  return {};
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const LogBytes log = memory_log("log", test::text_of(data, size));
  const auto format = log_format_of(log);
  if (!format) return 0;
  const auto end =
      read_log(*format, log,
               {[](std::uint64_t) { return true; },
                [](std::uint64_t, const LogFrame& frame) { return check_frame(frame); }});
  if (end) test::accepted();
  return 0;
}
