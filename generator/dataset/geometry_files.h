// PLY point clouds of a ping's scatterers, binary little-endian, and checks of all files that hold
// geometry: these, and the meshes of a sequence's scene (world/scene_mesh.h writes them). Private
// to dataset/.
//
//   kPlyPointBytes  encode_points          points/*.ply
//   ply_fault  mesh_ply_fault  glb_fault   what is wrong with a file, or an empty text
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "core/scatterers.h"
#include "core/vec.h"

namespace ensonify {

inline constexpr std::size_t kPlyPointBytes = 3 * 8 + 5 * 4 + 4 + 2 + 1 + 2;

// A point for each scatterer, in the list's order: x, y, z (double, world, m), level_db (float: the
// expected level of its echo at the peak, 20 log10(S0 sqrt(E|a|^2) gain) + 120 with S0 in Pa m),
// range_m, azimuth_rad, elevation_rad, cos_incidence (float), beam (int), instance (ushort), class
// (uchar), path (ushort). `class_of_instance` begins with that of id 0.
std::string encode_points(const ScattererList& scatterers, const Pose& sonar_in_world,
                          double source_pressure_pa_m,
                          std::span<const std::uint8_t> class_of_instance);

// Checks header and length of such a file; returns what is wrong, or an empty text.
std::string ply_fault(const std::filesystem::path& path);

// Checks header and length.
std::string mesh_ply_fault(const std::filesystem::path& path);

// Checks the heads of file and chunks, and the length.
std::string glb_fault(const std::filesystem::path& path);

}  // namespace ensonify
