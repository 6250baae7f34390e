// The EXR images of a data set. A labeled image is one of two parts:
//   `level`   channel Y, half, uncompressed; first, so that every viewer opens it
//   `labels`  a channel for each other float plane of kImagePlanes without a group, by its name,
//             half, ZIP; recordings lack it
// The float planes of a group are an image of one part, each a channel by its name, float, ZIP, and
// so are those of a front view and of a camera.
//
//   encode_exr  read_exr_halves  read_exr_level   a labeled image with its header attributes
//   encode_group_exr  read_group_exr   its planes of a group
//   encode_front_exr  read_front_exr  front_exr_channels   a front view
//   encode_camera_exr  read_camera_exr  camera_exr_channels   one file of a camera
//   exr_channels   the names of the channels of `labels` or of a group
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "core/ping.h"
#include "formats/exr.h"

namespace ensonify {

// The channel of the level: viewers open it as a gray image.
inline constexpr const char* kExrLevelChannel = "Y";

// In the headers of both parts are the attributes, `units` and `no_energy`. Needs the level and all
// planes of `labels`, or none of them.
Result<std::string> encode_exr(const LabelledImage& image, const ExrAttributes& attributes);

// Likewise; needs the float planes of the group (ImagePlane::group).
Result<std::string> encode_group_exr(const LabelledImage& image, std::string_view group,
                                     const ExrAttributes& attributes);

// Likewise, of the float planes of kFrontPlanes.
Result<std::string> encode_front_exr(const FrontView& view, const ExrAttributes& attributes);
std::vector<std::string> front_exr_channels();  // sorted, as the file holds them

// Likewise, of the float planes of kCameraPlanes that are in one file (CameraPlane::file).
Result<std::string> encode_camera_exr(const CameraView& view, std::string_view file,
                                      const ExrAttributes& attributes);
std::vector<std::string> camera_exr_channels(std::string_view file);  // sorted

// Channels of a group, or of the labels with the group "", sorted as files hold them.
std::vector<std::string> exr_channels(std::string_view group);

// Each float plane by its name. Error (io): not an image of encode_exr with rows x columns, or
// damaged.
Result<ExrHalves> read_exr_halves(const std::filesystem::path& path, int rows, int columns);
// The same of an image without labels.
Result<ExrHalves> read_exr_level(const std::filesystem::path& path, int rows, int columns);

// Likewise. Error (io): not an image of encode_group_exr of this group and size, or damaged.
Result<ExrFloats> read_group_exr(const std::filesystem::path& path, std::string_view group,
                                 int rows, int columns);
// The same of an image of encode_front_exr.
Result<ExrFloats> read_front_exr(const std::filesystem::path& path, int rows, int columns);
// The same of an image of encode_camera_exr of this file.
Result<ExrFloats> read_camera_exr(const std::filesystem::path& path, std::string_view file,
                                  int rows, int columns);

}  // namespace ensonify
