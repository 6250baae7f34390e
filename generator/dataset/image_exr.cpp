#include "dataset/image_exr.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/camera_planes.h"
#include "core/front_planes.h"
#include "core/image_planes.h"

namespace ensonify {
namespace {

constexpr const char* kNormalFrame = "sonar frame: x along the boresight, y to port, z up";

template <class Plane>
void sort_by_name(std::vector<Plane>& planes) {
  std::sort(planes.begin(), planes.end(),
            [](const Plane& a, const Plane& b) { return std::string_view(a.name) < b.name; });
}

// Planes of a group, or of the part `labels`, sorted by name, as in the file.
std::vector<ImagePlane> planes_of(std::string_view group) {
  std::vector<ImagePlane> planes;
  std::copy_if(std::begin(kImagePlanes), std::end(kImagePlanes), std::back_inserter(planes),
               [&](const ImagePlane& plane) {
                 return is_float_plane(plane) && !is_level_plane(plane) && plane.group() == group;
               });
  sort_by_name(planes);
  return planes;
}

std::vector<FrontPlane> front_planes() {
  std::vector<FrontPlane> planes;
  for (const FrontPlane& plane : kFrontPlanes) {
    if (is_float_plane(plane)) planes.push_back(plane);
  }
  sort_by_name(planes);
  return planes;
}

std::vector<CameraPlane> camera_planes(std::string_view file) {
  std::vector<CameraPlane> planes;
  for (const CameraPlane& plane : kCameraPlanes) {
    if (is_float_plane(plane) && file == plane.file) planes.push_back(plane);
  }
  sort_by_name(planes);
  return planes;
}

std::vector<ExrChannel> channels_of(const LabelledImage& image, std::string_view group) {
  std::vector<ExrChannel> channels;
  for (const ImagePlane& plane : planes_of(group)) {
    channels.push_back(
        {plane.name, image.*std::get<std::vector<float> ImagePlanes::*>(plane.values)});
  }
  return channels;
}

// "a, b: rad; c: 1", neighbors of one unit together.
template <class Plane>
std::string units_of(const std::vector<Plane>& planes) {
  std::string text;
  std::string_view unit;
  for (const Plane& plane : planes) {
    if (!unit.empty() && unit != plane.unit) text.append(": ").append(unit).append("; ");
    if (unit == plane.unit) text += ", ";
    text += plane.name;
    unit = plane.unit;
  }
  return text.append(": ").append(unit);
}

Result<ExrHalves> read_halves(const std::filesystem::path& path, int rows, int columns,
                              bool with_labels) {
  std::vector<ExrNames> parts = {{kExrLevelChannel}};
  if (with_labels) {
    parts.emplace_back();
    for (const ImagePlane& plane : planes_of("")) parts.back().push_back(plane.name);
  }
  auto halves = read_half_channels(path, rows, columns, parts);
  if (!halves) return halves;
  for (const ImagePlane& plane : kImagePlanes) {
    if (!is_level_plane(plane)) continue;
    auto level = halves->extract(kExrLevelChannel);
    level.key() = plane.name;
    halves->insert(std::move(level));
  }
  return halves;
}

}  // namespace

std::vector<std::string> exr_channels(std::string_view group) {
  std::vector<std::string> names;
  for (const ImagePlane& plane : planes_of(group)) names.emplace_back(plane.name);
  return names;
}

Result<std::string> encode_group_exr(const LabelledImage& image, std::string_view group,
                                     const ExrAttributes& attributes) {
  const std::string name(group);
  ExrAttributes own = attributes;
  if (group == kSurfacePlanes) own.texts.emplace_back("normals", kNormalFrame);
  return encode_exr_image(
      {name.c_str(), units_of(planes_of(group)), channels_of(image, group), true, false},
      image.rows, image.columns, own);
}

std::vector<std::string> front_exr_channels() {
  std::vector<std::string> names;
  for (const FrontPlane& plane : front_planes()) names.emplace_back(plane.name);
  return names;
}

Result<std::string> encode_front_exr(const FrontView& view, const ExrAttributes& attributes) {
  ExrImage part{"front", units_of(front_planes()), {}, true, false};
  for (const FrontPlane& plane : front_planes()) {
    part.channels.push_back(
        {plane.name, view.*std::get<std::vector<float> FrontView::*>(plane.values)});
  }
  ExrAttributes own = attributes;
  own.texts.emplace_back("normals", kNormalFrame);
  return encode_exr_image(part, view.rows, view.columns, own);
}

std::vector<std::string> camera_exr_channels(std::string_view file) {
  std::vector<std::string> names;
  for (const CameraPlane& plane : camera_planes(file)) names.emplace_back(plane.name);
  return names;
}

Result<std::string> encode_camera_exr(const CameraView& view, std::string_view file,
                                      const ExrAttributes& attributes) {
  ExrImage part{"camera", units_of(camera_planes(file)), {}, true, false};
  for (const CameraPlane& plane : camera_planes(file)) {
    part.channels.push_back(
        {plane.name, view.*std::get<std::vector<float> CameraView::*>(plane.values)});
  }
  return encode_exr_image(part, view.rows, view.columns, attributes);
}

Result<std::string> encode_exr(const LabelledImage& image, const ExrAttributes& attributes) {
  const bool labels = !image.clean_db.empty();
  std::vector<ExrImage> parts = {
      {"level", labels ? "dB re 1 uPa" : "dB", {{kExrLevelChannel, image.level_db}}}};
  if (labels) {
    parts.push_back({"labels", units_of(planes_of("")), channels_of(image, ""), true});
  }
  ExrAttributes common = attributes;
  common.texts.emplace_back("no_energy", "-99 dB; NaN for angles");
  return encode_exr_parts(parts, image.rows, image.columns, common);
}

Result<ExrHalves> read_exr_halves(const std::filesystem::path& path, int rows, int columns) {
  return read_halves(path, rows, columns, true);
}

Result<ExrHalves> read_exr_level(const std::filesystem::path& path, int rows, int columns) {
  return read_halves(path, rows, columns, false);
}

Result<ExrFloats> read_group_exr(const std::filesystem::path& path, std::string_view group,
                                 int rows, int columns) {
  ExrNames names;
  for (const ImagePlane& plane : kImagePlanes) {
    if (group == plane.group()) names.push_back(plane.name);
  }
  return read_float_channels(path, rows, columns, names);
}

Result<ExrFloats> read_front_exr(const std::filesystem::path& path, int rows, int columns) {
  ExrNames names;
  for (const FrontPlane& plane : front_planes()) names.push_back(plane.name);
  return read_float_channels(path, rows, columns, names);
}

Result<ExrFloats> read_camera_exr(const std::filesystem::path& path, std::string_view file,
                                  int rows, int columns) {
  ExrNames names;
  for (const CameraPlane& plane : camera_planes(file)) names.push_back(plane.name);
  return read_float_channels(path, rows, columns, names);
}

}  // namespace ensonify
