// Parts of the resolved text. Private to scenario/.
//
//   number  numbers  quoted_if_needed  pose_keys  place_keys   single values
//   shape_text  volumes_text  ..trajectory_text     in emit_shapes.cpp, emit_volumes.cpp, ...
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <string>

#include "scenario/scenario.h"

namespace ensonify {

using NameFile = std::function<std::string(const std::filesystem::path&)>;

// The shortest digits that read back the same. YAML 1.1 knows no exponent without a point: 1e-05
// would be text to some readers.
std::string number(double value);

template <std::size_t N>
std::string numbers(const std::array<double, N>& values) {
  std::string text = "[";
  for (const double value : values) text += (text.size() > 1 ? ", " : "") + number(value);
  return text + "]";
}

// Plain only if no reader could take it for anything else.
std::string quoted_if_needed(const std::string& text);

// position_m and the rotation as it was given.
std::string pose_keys(const PoseSpec& pose);

std::string place_keys(const PlaceSpec& place);

// One key with its options: "box: {...}".
std::string shape_text(const ShapeSpec& shape, const NameFile& name_file);

std::string heightfield_text(const HeightfieldSpec& field, const NameFile& name_file);

// Whole sections.
// The path of an object in one line: "trajectory: {...}".
std::string object_trajectory_text(const TrajectorySpec& trajectory, const NameFile& name_file);
std::string volumes_text(const std::vector<VolumeSpec>& volumes, const NameFile& name_file);
std::string trajectory_text(const TrajectorySpec& trajectory, const NameFile& name_file);

}  // namespace ensonify
