// The planes of a labeled image, one row each. All code that copies, checks, writes or reads images
// loops over this table: a new label needs a member of ImagePlanes, a row here and code that
// computes it.
//
//   PlaneBlank  ImagePlane  kImagePlanes
//   with_plane        calls a function with the values of a plane
//   is_float_plane  is_level_plane  has_own_file  pixel_bytes  blank_value
//   view_name         polar, cartesian
#pragma once

#include <cstdint>
#include <limits>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "core/ping.h"
#include "core/units.h"

namespace ensonify {

// The value of a pixel without content.
enum class PlaneBlank { zero, no_energy, nan };

struct ImagePlane {
  using Values =
      std::variant<std::vector<float> ImagePlanes::*, std::vector<std::uint16_t> ImagePlanes::*,
                   std::vector<std::uint8_t> ImagePlanes::*>;
  const char* name;
  const char* unit;
  PlaneBlank blank;
  Values values;
  bool OutputSelection::*wanted = nullptr;  // null: every image has it
  // Float planes with a group are in an EXR file of their own, with all bits, named after it.
  const char* group = "";
};

inline constexpr const char* kSurfacePlanes = "surfaces";
inline constexpr const char* kMotionPlanes = "motion";

inline constexpr ImagePlane kImagePlanes[] = {
    {"level_db", "dB re 1 uPa", PlaneBlank::no_energy, &ImagePlanes::level_db},
    {"clean_db", "dB re 1 uPa", PlaneBlank::no_energy, &ImagePlanes::clean_db},
    {"elevation_rad", "rad", PlaneBlank::nan, &ImagePlanes::elevation_rad},
    {"elevation_std_rad", "rad", PlaneBlank::nan, &ImagePlanes::elevation_std_rad},
    {"instance_fraction", "1", PlaneBlank::zero, &ImagePlanes::instance_fraction},
    {"instance", "", PlaneBlank::zero, &ImagePlanes::instance},
    {"semantic", "", PlaneBlank::zero, &ImagePlanes::semantic},
    {"shadow", "", PlaneBlank::zero, &ImagePlanes::shadow, &OutputSelection::shadow},
    {"multipath", "", PlaneBlank::zero, &ImagePlanes::multipath, &OutputSelection::multipath},
    {"surface_elevation_rad", "rad", PlaneBlank::nan, &ImagePlanes::surface_elevation_rad,
     &OutputSelection::surfaces, kSurfacePlanes},
    {"surface_range_m", "m", PlaneBlank::nan, &ImagePlanes::surface_range_m,
     &OutputSelection::surfaces, kSurfacePlanes},
    {"surface_normal_x", "1", PlaneBlank::nan, &ImagePlanes::surface_normal_x,
     &OutputSelection::surfaces, kSurfacePlanes},
    {"surface_normal_y", "1", PlaneBlank::nan, &ImagePlanes::surface_normal_y,
     &OutputSelection::surfaces, kSurfacePlanes},
    {"surface_normal_z", "1", PlaneBlank::nan, &ImagePlanes::surface_normal_z,
     &OutputSelection::surfaces, kSurfacePlanes},
    {"lowest_elevation_rad", "rad", PlaneBlank::nan, &ImagePlanes::lowest_elevation_rad,
     &OutputSelection::surfaces, kSurfacePlanes},
    {"lowest_range_m", "m", PlaneBlank::nan, &ImagePlanes::lowest_range_m,
     &OutputSelection::surfaces, kSurfacePlanes},
    {"highest_elevation_rad", "rad", PlaneBlank::nan, &ImagePlanes::highest_elevation_rad,
     &OutputSelection::surfaces, kSurfacePlanes},
    {"highest_range_m", "m", PlaneBlank::nan, &ImagePlanes::highest_range_m,
     &OutputSelection::surfaces, kSurfacePlanes},
    {"surface_count", "1", PlaneBlank::zero, &ImagePlanes::surface_count,
     &OutputSelection::surfaces, kSurfacePlanes},
    {"artifact", "", PlaneBlank::zero, &ImagePlanes::artifact, &OutputSelection::artifact},
    {"point_sample", "1", PlaneBlank::nan, &ImagePlanes::point_sample, &OutputSelection::motion,
     kMotionPlanes},
    {"point_beam", "1", PlaneBlank::nan, &ImagePlanes::point_beam, &OutputSelection::motion,
     kMotionPlanes},
    {"motion_samples", "1", PlaneBlank::nan, &ImagePlanes::motion_samples,
     &OutputSelection::motion, kMotionPlanes},
    {"motion_beams", "1", PlaneBlank::nan, &ImagePlanes::motion_beams, &OutputSelection::motion,
     kMotionPlanes},
    {"motion_state", "", PlaneBlank::zero, &ImagePlanes::motion_state, &OutputSelection::motion},
    {"motion_occluder", "", PlaneBlank::zero, &ImagePlanes::motion_occluder,
     &OutputSelection::motion},
};

template <class Planes, class Use>
decltype(auto) with_plane(Planes& planes, const ImagePlane& plane, Use&& use) {
  return std::visit([&](auto member) -> decltype(auto) { return use(planes.*member); },
                    plane.values);
}

// Each float plane without a group is a channel of the image's EXR file. The level has its own part
// in it.
constexpr bool is_float_plane(const ImagePlane& plane) {
  return std::holds_alternative<std::vector<float> ImagePlanes::*>(plane.values);
}
constexpr bool is_level_plane(const ImagePlane& plane) {
  return std::string_view(plane.name) == "level_db";
}

constexpr bool has_own_file(const ImagePlane& plane) { return *plane.group != 0; }

constexpr std::uint64_t pixel_bytes(const ImagePlane& plane) {
  constexpr std::uint64_t kBytes[] = {sizeof(float), sizeof(std::uint16_t), sizeof(std::uint8_t)};
  return kBytes[plane.values.index()];
}

template <class Value>
constexpr Value blank_value(PlaneBlank blank) {
  if constexpr (std::is_floating_point_v<Value>) {
    if (blank == PlaneBlank::no_energy) return kNoEnergyDb;
    if (blank == PlaneBlank::nan) return std::numeric_limits<Value>::quiet_NaN();
  }
  return Value{0};
}

constexpr const char* view_name(ImageView view) {
  return view == ImageView::polar ? "polar" : "cartesian";
}

}  // namespace ensonify
