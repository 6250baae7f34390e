// Sets of neusis, HoloOcean and SonarSplat: Config.json, and Data/NUMBER.pkl with an image and a
// pose for each ping.
//
// Config.json: the first sensor of type ImagingSonar in agents[].sensors[], or, if there is none,
// the last sensor that has a range. Its `configuration` has Azimuth (degrees, of the whole fan) and
// RangeMax (m), and may have RangeMin, RangeBins and AzimuthBins; its Hz is the ping rate. A pickle
// is a dictionary with ImagingSonar, amplitudes from 0 to 1 as floats [ranges x azimuths], nearest
// first and starboard first, and may have PoseSensor, [4 x 4], sonar to world with x ahead, y to
// port and z up. Images that are larger than Config.json says are cut to its size. Layout:
// https://github.com/rpl-cmu/neusis, https://holoocean.readthedocs.io and
// https://github.com/umfieldrobotics/sonar_splat.
//
//   is_neusis    whether a folder has a Config.json
//   NeusisConfig  parse_neusis_config
//   parse_neusis_frame   one pickle
//   open_neusis  the folder as a log
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "recordings/log.h"

namespace ensonify {

bool is_neusis(const std::filesystem::path& folder);

struct NeusisConfig {
  double azimuth_deg = 0;                   // between the outer borders of the fan
  double range_min_m = 0, range_max_m = 0;  // outer borders of the image
  std::optional<std::uint64_t> range_bins, azimuth_bins;
  std::optional<double> rate_hz;  // of pings
};

// Error (usage): not JSON, no sonar, or a value that cannot be. `place`: of the file.
Result<NeusisConfig> parse_neusis_config(std::string_view text, const std::string& place);

struct NeusisFrame {
  LogFrame frame;             // settings without instrument; times are left to the caller
  std::uint64_t clipped = 0;  // pixels outside of 0 to 1, or not a number
  bool cut = false;           // whether the image is larger than Config.json says
};

// 16-bit counts, round(65535 amplitude). Error (usage): that of unpickle_arrays, an array that is
// missing or has another shape, or a pose that is not one. `place`: of the file.
Result<NeusisFrame> parse_neusis_frame(const NeusisConfig& config, std::string_view pickle,
                                       const std::string& place, bool with_counts);

// The hash is that of the lines "SHA-256  name" of Config.json and the pickles, in the order of
// their numbers. Errors: those of parse_neusis_config and, of its `read`, parse_neusis_frame;
// (usage) no pickles, an image that differs in size from the first one, or a pose in some files
// only; (io) the folder cannot be listed.
Result<Log> open_neusis(const std::filesystem::path& folder, const LogChoices& choices);

}  // namespace ensonify
