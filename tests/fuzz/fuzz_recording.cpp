// Logs of ARIS and Oculus sonars and MCAP files, pickles and Config.json of neusis, and JPEG images
// of crops and recordings, told apart by their first bytes.
#include <algorithm>
#include <cmath>

#include "formats/jpeg.h"
#include "fuzz_file.h"
#include "recordings/neusis.h"
#include "recordings/open_log.h"
#include "recordings/pickle.h"
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

void check_pickle(std::string_view bytes) {
  const auto arrays = unpickle_arrays(bytes);
  if (!arrays) return;
  for (const auto& [key, array] : arrays->arrays) {
    std::uint64_t values = 1;
    for (const std::uint64_t side : array.shape) values *= side;
    test::promise(values_of(array).size() == values && array.data.size() <= bytes.size());
  }
  NeusisConfig config;
  config.azimuth_deg = 60;
  config.range_max_m = 3;
  const auto found = parse_neusis_frame(config, bytes, "pickle", true);
  if (!found) return;
  test::accepted();
  LogFrame frame = found->frame;
  test::promise(!frame.sonar_in_world || std::isfinite(frame.sonar_in_world->rotation.w));
  test::promise(check_frame(frame).ok());
}

void check_jpeg(std::string_view bytes) {
  const auto image = parse_grey_jpeg(bytes);
  if (!image) return;
  test::accepted();
  test::promise(image->grey.size() == std::size_t{image->rows} * image->columns);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes = test::text_of(data, size);
  if (bytes.starts_with('\x80')) return check_pickle(bytes), 0;
  if (bytes.starts_with("\xff\xd8")) return check_jpeg(bytes), 0;
  if (bytes.starts_with('{')) return parse_neusis_config(bytes, "config").ok(), 0;
  const LogBytes log = memory_log("log", bytes);
  const auto format = log_format_of(log);
  if (!format) return 0;
  const auto end =
      read_log(*format, log,
               {[](std::uint64_t) { return true; },
                [](std::uint64_t, const LogFrame& frame) { return check_frame(frame); }});
  if (end) test::accepted();
  return 0;
}
