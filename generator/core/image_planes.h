// The planes of a labeled image, one row each. All code that makes, copies, checks, writes, reads,
// describes or estimates images loops over this table, and `ensonify --help-format outputs` prints
// it for the reader in Python: a new label needs a member of ImagePlanes, a row here and code that
// computes it.
//
//   PointState  PointMotion   where a point lies in another ping
//   ImagePlanes  ImageView
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

#include "core/outputs.h"
#include "core/units.h"

namespace ensonify {

// Of a point in another ping. outside: not in the fan, or nearer or farther than the record.
enum class PointState : std::uint8_t { none, seen, hidden, outside };

// Places are fractions of sample and beam indices, of the straight line to the point, at
// transmission. NaN without a point.
struct PointMotion {
  double sample = std::numeric_limits<double>::quiet_NaN();
  double beam = std::numeric_limits<double>::quiet_NaN();
  double sample_there = std::numeric_limits<double>::quiet_NaN();
  double beam_there = std::numeric_limits<double>::quiet_NaN();
  PointState state = PointState::none;
  std::uint16_t occluder = 0;  // of hidden points: the first instance on the line
};

// The values of an image's pixels, row-major; kImagePlanes says what they are. Those that are not
// requested are empty.
struct ImagePlanes {
  std::vector<float> level_db, clean_db;
  std::vector<float> elevation_rad, elevation_std_rad;
  std::vector<float> instance_fraction;
  std::vector<std::uint16_t> instance;
  std::vector<std::uint8_t> semantic;
  std::vector<std::uint16_t> shadow, multipath = {};
  // labels/surfaces.h
  std::vector<float> surface_elevation_rad = {}, surface_range_m = {};
  std::vector<float> surface_normal_x = {}, surface_normal_y = {}, surface_normal_z = {};
  std::vector<float> lowest_elevation_rad = {}, lowest_range_m = {};
  std::vector<float> highest_elevation_rad = {}, highest_range_m = {};
  std::vector<float> surface_count = {}, layover_count = {}, second_fraction = {};
  std::vector<std::uint16_t> second_instance = {};
  std::vector<std::uint8_t> artifact = {};  // bits of Artifact (core/electronics.h)
  // add_motion of labels/surfaces.h
  std::vector<float> point_sample = {}, point_beam = {};
  std::vector<float> motion_samples = {}, motion_beams = {};
  std::vector<std::uint8_t> motion_state = {};  // PointState
  std::vector<float> clean_single_db = {};      // clean_db, which files hold in half precision
  std::vector<std::uint16_t> motion_occluder = {};
};

enum class ImageView { polar, cartesian };

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
  double file_bytes;  // of a pixel on disk, as typical images have them
  const char* meaning;
  bool OutputSelection::*wanted = nullptr;  // null: every image has it

  // Float planes with a flag are in an EXR file of their own, with all bits, named after the flag.
  constexpr std::string_view group() const {
    const bool is_float = values.index() == 0;
    return is_float && wanted != nullptr ? flag_of(wanted)->name : "";
  }
};

inline constexpr std::string_view kSurfacePlanes = "surfaces";  // a group

inline constexpr ImagePlane kImagePlanes[] = {
    {"level_db", "dB re 1 uPa", PlaneBlank::no_energy, &ImagePlanes::level_db, 2,
     "Level of the series, with speckle and noise, dB re 1 uPa; -99 without energy."},
    {"clean_db", "dB re 1 uPa", PlaneBlank::no_energy, &ImagePlanes::clean_db, 0.25,
     "Level of the expected power: no speckle, no noise."},
    {"elevation_rad", "rad", PlaneBlank::nan, &ImagePlanes::elevation_rad, 0.25,
     "Mean elevation of all echoes of the pixel, on no surface where it holds several."},
    {"elevation_std_rad", "rad", PlaneBlank::nan, &ImagePlanes::elevation_std_rad, 0.25,
     "Spread of the elevation; NaN without echo."},
    {"instance_fraction", "1", PlaneBlank::zero, &ImagePlanes::instance_fraction, 0.125,
     "Share of the winning instance in the pixel's energy."},
    {"instance", "", PlaneBlank::zero, &ImagePlanes::instance, 0.0625, "Instance ids; 0: none."},
    {"semantic", "", PlaneBlank::zero, &ImagePlanes::semantic, 0.0625,
     "Class ids; id k is `classes[k - 1]`, 0: none."},
    {"shadow", "", PlaneBlank::zero, &ImagePlanes::shadow, 0.02,
     "The instance whose shadow it is; 0: none.", &OutputSelection::shadow},
    {"multipath", "", PlaneBlank::zero, &ImagePlanes::multipath, 0.02,
     "The instance heard over mirrors, where that is more than what comes straight; 0: none. No "
     "other mask counts such echoes.",
     &OutputSelection::multipath},
    {"surface_elevation_rad", "rad", PlaneBlank::nan, &ImagePlanes::surface_elevation_rad, 0.4,
     "Elevation of the strongest echo; NaN without.", &OutputSelection::surfaces},
    {"surface_range_m", "m", PlaneBlank::nan, &ImagePlanes::surface_range_m, 0.4,
     "Slant range of the strongest echo.", &OutputSelection::surfaces},
    {"surface_normal_x", "1", PlaneBlank::nan, &ImagePlanes::surface_normal_x, 0.4,
     "Unit normal there, along the boresight; see `surface_normal`.", &OutputSelection::surfaces},
    {"surface_normal_y", "1", PlaneBlank::nan, &ImagePlanes::surface_normal_y, 0.4,
     "Unit normal there, to port.", &OutputSelection::surfaces},
    {"surface_normal_z", "1", PlaneBlank::nan, &ImagePlanes::surface_normal_z, 0.4,
     "Unit normal there, up.", &OutputSelection::surfaces},
    {"lowest_elevation_rad", "rad", PlaneBlank::nan, &ImagePlanes::lowest_elevation_rad, 0.4,
     "Elevation of the lowest echo.", &OutputSelection::surfaces},
    {"lowest_range_m", "m", PlaneBlank::nan, &ImagePlanes::lowest_range_m, 0.4,
     "Slant range of the lowest echo.", &OutputSelection::surfaces},
    {"highest_elevation_rad", "rad", PlaneBlank::nan, &ImagePlanes::highest_elevation_rad, 0.4,
     "Elevation of the highest echo.", &OutputSelection::surfaces},
    {"highest_range_m", "m", PlaneBlank::nan, &ImagePlanes::highest_range_m, 0.4,
     "Slant range of the highest echo.", &OutputSelection::surfaces},
    {"surface_count", "1", PlaneBlank::zero, &ImagePlanes::surface_count, 0.05,
     "Number of surfaces; 0 without echo.", &OutputSelection::surfaces},
    {"layover_count", "1", PlaneBlank::zero, &ImagePlanes::layover_count, 0.05,
     "Number of surfaces of all instances in the pixel.", &OutputSelection::surfaces},
    {"second_fraction", "1", PlaneBlank::zero, &ImagePlanes::second_fraction, 0.2,
     "Share of the second instance in the pixel's energy.", &OutputSelection::surfaces},
    {"second_instance", "", PlaneBlank::zero, &ImagePlanes::second_instance, 0.05,
     "The instance with the second most energy; 0: none.", &OutputSelection::surfaces},
    {"artifact", "", PlaneBlank::zero, &ImagePlanes::artifact, 0.02,
     "Bits of what the electronics changed: 1 clipped, 2 streak, 4 interference, 8 leakage, 16 "
     "blanked.",
     &OutputSelection::artifact},
    {"point_sample", "1", PlaneBlank::nan, &ImagePlanes::point_sample, 0.4,
     "Sample of the point, with its fraction; NaN without.", &OutputSelection::motion},
    {"point_beam", "1", PlaneBlank::nan, &ImagePlanes::point_beam, 0.4,
     "Beam of the point, with its fraction.", &OutputSelection::motion},
    {"motion_samples", "1", PlaneBlank::nan, &ImagePlanes::motion_samples, 0.8,
     "Displacement to the other ping along range, in samples.", &OutputSelection::motion},
    {"motion_beams", "1", PlaneBlank::nan, &ImagePlanes::motion_beams, 0.8,
     "Displacement to the other ping in azimuth, in beams.", &OutputSelection::motion},
    {"motion_state", "", PlaneBlank::zero, &ImagePlanes::motion_state, 0.02,
     "The point in the other ping: 1 seen, 2 hidden, 3 outside; 0: no point or no ping.",
     &OutputSelection::motion},
    {"motion_occluder", "", PlaneBlank::zero, &ImagePlanes::motion_occluder, 0.02,
     "The instance that hides it there; 0: none.", &OutputSelection::motion},
    {"clean_single_db", "dB re 1 uPa", PlaneBlank::no_energy, &ImagePlanes::clean_single_db, 2,
     "`clean_db` in single precision.", &OutputSelection::clean_single},
};

constexpr bool every_group_has_a_name() {
  for (const ImagePlane& plane : kImagePlanes) {
    if (plane.values.index() == 0 && plane.wanted != nullptr && flag_of(plane.wanted) == nullptr) {
      return false;
    }
  }
  return true;
}
static_assert(every_group_has_a_name(), "a flag of float planes needs a row in kOutputFlags");

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

constexpr bool has_own_file(const ImagePlane& plane) { return !plane.group().empty(); }

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
