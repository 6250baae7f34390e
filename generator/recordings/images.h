// A folder of polar images, or of displays of a fan, with a description, recording.yaml, of what
// they mean:
//
//   files: "*.png"              PNG (grayscale) or NPY, of 8 or 16 bits; displays: PNG or JPEG. The
//                               order is that of names, with numbers in them compared as numbers
//   azimuth_deg: [-30, ...]     of each column, port positive; or fan_deg: 60, equally spaced
//   columns: port_first         (default) or starboard_first
//   rows: near_first            (default) or far_first
//   range_m: [0.5, 10]          slant ranges of the nearest and the farthest row
//   ping_rate_hz: 5             or times_s: [0, 0.2, ...]
//   frequency_hz: 900e3
//   sound_speed_m_s: 1500       (default)
//   scale: {db: [0, 80]}        levels of 0 and full scale; or {gamma: 1}: a power of the amplitude
//   instrument: name            (default: that of the folder)
//   display:                    images show the fan in space (image_files.h); no columns and rows,
//                               and scale may be left out
//     apex_px: [512, 700]       column and row of range 0, from the upper left corner
//     pixels_per_m: 250
//     samples: 475              of the polar images
//     beams: 128                ... unless azimuth_deg is given
//     looks: up                 (default), right, down or left
//     mirrored: false           (default) port is to the left of a fan that looks up
//
//   ImageFolder  parse_image_folder   the description
//   is_image_folder                   whether a folder has one
//   open_images                       the folder as a log
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recordings/image_files.h"
#include "recordings/log.h"

namespace ensonify {

struct ImageFolder {
  std::string files;                // with * for any characters
  std::vector<double> azimuth_deg;  // of the columns; empty: fan_deg
  double fan_deg = 0;               // between the outer borders
  bool port_first = true, near_first = true;
  double first_range_m = 0, last_range_m = 0;
  std::vector<double> times_s;  // empty: ping_rate_hz
  double ping_rate_hz = 0;
  double frequency_hz = 0, sound_speed_m_s = 1500;
  std::optional<std::array<double, 2>> db;
  double gamma = 1;
  std::string instrument;
  std::optional<FanDisplay> display;
  int samples = 0, beams = 0;     // of a display
  bool levels_are_grays = false;  // of a display without a scale: db is [0, 255]
};

// Error (usage): not YAML, an unknown or a missing key, or a value that cannot be. `place`: of the
// file, for messages.
Result<ImageFolder> parse_image_folder(const std::string& text, const std::string& place);

bool is_image_folder(const std::filesystem::path& folder);

// The hash is that of the lines "SHA-256  name" of recording.yaml and the images, in order. Errors:
// those of parse_image_folder; (io) a file cannot be read. Its `read`: (usage) an image is of
// another kind, or has another size than the description or the first one.
Result<Log> open_images(const std::filesystem::path& folder);

}  // namespace ensonify
