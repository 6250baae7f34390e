// OpenEXR images, in memory. No date, host or path is in the headers: equal images give equal
// bytes.
//
//   ExrImage  encode_exr_image   one image, its channels half or float, uncompressed or ZIP
//   encode_exr_parts             several in one file
//   read_exr_parts               what the headers of a file say
//   read_half_channels  read_float_channels   the channels of these names
//   encode_series_exr  read_series_exr   a time series: an image of one part with the channels p.re
//                                and p.im, float, uncompressed, since ZIP takes 0.5% off them
#pragma once

#include <complex>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error.h"

namespace ensonify {

// In the headers of both parts, with `units` and `no_energy`.
struct ExrAttributes {
  std::vector<std::pair<std::string, std::string>> texts;
  std::vector<std::pair<std::string, double>> numbers;
};

// Values are row-major, row 0 on top.
struct ExrChannel {
  const char* name;
  std::span<const float> values;
};

struct ExrImage {
  const char* name;
  std::string units;
  std::vector<ExrChannel> channels;  // sorted by name, as the file holds them
  bool is_zipped = false;
  bool is_half = true;  // else float
};

// Needs rows * columns values in each channel, both positive, and names of attributes of at most 31
// characters.
Result<std::string> encode_exr_image(const ExrImage& image, int rows, int columns,
                                     const ExrAttributes& attributes);
Result<std::string> encode_exr_parts(std::span<const ExrImage> parts, int rows, int columns,
                                     const ExrAttributes& attributes);

// Rows are samples, columns beams, as in the polar image: `series` [beams x samples], Pa, is
// transposed. Needs series.size() == samples * beams, both positive.
Result<std::string> encode_series_exr(std::span<const std::complex<float>> series, int samples,
                                      int beams, const ExrAttributes& attributes);

struct ExrPart {
  std::string name;
  int width = 0, height = 0;
  std::vector<std::string> half_channels;  // sorted by name, as the file holds them
  std::vector<std::string> float_channels;
  std::vector<std::string> other_channels;  // of another pixel type
};

// Reads no pixels. Error (damage): not an EXR file, or cut off in its headers.
Result<std::vector<ExrPart>> read_exr_parts(const std::filesystem::path& path);

using ExrNames = std::vector<const char*>;

// IEEE half-precision bits of each channel by its name, row-major, row 0 on top.
using ExrHalves = std::map<std::string_view, std::vector<std::uint16_t>>;
using ExrFloats = std::map<std::string_view, std::vector<float>>;

// Error (io): not an image of this size with as many parts, which have these channels, or damaged.
Result<ExrHalves> read_half_channels(const std::filesystem::path& path, int rows, int columns,
                                     std::span<const ExrNames> parts);
// The same of an image of one part.
Result<ExrFloats> read_float_channels(const std::filesystem::path& path, int rows, int columns,
                                      const ExrNames& names);

// [beams x samples], Pa. Error (io): not a series of encode_series_exr of this size, or damaged.
Result<std::vector<std::complex<float>>> read_series_exr(const std::filesystem::path& path,
                                                         int samples, int beams);

}  // namespace ensonify
