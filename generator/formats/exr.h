// OpenEXR images of two parts, in memory:
//   `level`   channel Y, half, uncompressed; first, so that every viewer opens it
//   `labels`  a channel for each other float plane of kImagePlanes but those of surfaces, by its
//             name, half, ZIP; recordings lack it
// No date, host or path is in the headers: equal images give equal bytes.
//
// The planes of surfaces are an image of one part, each a channel by its name, float, ZIP.
//
// A time series is an image of one part:
//   channels p.re and p.im, float, uncompressed: ZIP takes 0.5% off them
//
//   encode_exr         a labeled image with its header attributes
//   encode_group_exr  its planes of a group
//   exr_channels   the names of the channels of `labels` or of a group
//   encode_series_exr  a time series
//   read_exr_parts     what the headers of a file say
//   read_exr_halves  read_exr_level   all channels, as the halves that the file holds
//   read_group_exr  the planes of a group
//   read_series_exr    a time series
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
#include "core/ping.h"

namespace ensonify {

// In the headers of both parts, with `units` and `no_energy`.
struct ExrAttributes {
  std::vector<std::pair<std::string, std::string>> texts;
  std::vector<std::pair<std::string, double>> numbers;
};

// The channel of the level: viewers open it as a gray image.
inline constexpr const char* kExrLevelChannel = "Y";

// Row 0 on top. Needs the level and all planes of `labels`, or none of them, at rows * columns,
// both positive, and names of attributes of at most 31 characters.
Result<std::string> encode_exr(const LabelledImage& image, const ExrAttributes& attributes);

// Likewise; needs the float planes of the group (ImagePlane::group).
Result<std::string> encode_group_exr(const LabelledImage& image, std::string_view group,
                                     const ExrAttributes& attributes);

// Channels of a group, or of the labels with the group "", sorted as files hold them.
std::vector<std::string> exr_channels(std::string_view group);

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

// IEEE half-precision bits of each float plane by the plane's name, row-major, row 0 on top.
using ExrHalves = std::map<std::string_view, std::vector<std::uint16_t>>;

// Error (io): not an image of encode_exr with rows x columns, or damaged.
Result<ExrHalves> read_exr_halves(const std::filesystem::path& path, int rows, int columns);

// The same of an image without labels.
Result<ExrHalves> read_exr_level(const std::filesystem::path& path, int rows, int columns);

// Each plane by its name, likewise. Error (io): not an image of encode_group_exr of this group and
// size, or damaged.
using ExrFloats = std::map<std::string_view, std::vector<float>>;
Result<ExrFloats> read_group_exr(const std::filesystem::path& path, std::string_view group,
                                 int rows, int columns);

// [beams x samples], Pa. Error (io): not a series of encode_series_exr of this size, or damaged.
Result<std::vector<std::complex<float>>> read_series_exr(const std::filesystem::path& path,
                                                         int samples, int beams);

}  // namespace ensonify
