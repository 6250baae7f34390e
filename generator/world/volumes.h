// Converts the volumes of a scenario to the data that the tracer uses.
//
//   Volume  School  VolumeParts  make_volume
//   fish_of                                        positions of the fish of a school
//   plume_radius_m  plume_mean_density  make_plume a bubble plume as a density grid
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/error.h"
#include "core/vec.h"
#include "scenario/volume_spec.h"
#include "world/density.h"
#include "world/surface_field.h"

namespace ensonify {

// Water that scatters and attenuates in proportion to its density.
struct Volume {
  std::uint32_t instance = 0;
  double strength_per_m = 0;   // s_v of density 1, cross-section of a unit of volume per steradian
  double extinction_db_m = 0;  // of density 1, one way, in addition to absorption
  DensityField density{};
  Pose pose{};  // in the world
  // Factor on the density, in the volume's frame; null: none.
  std::shared_ptr<const SurfaceField> patches = nullptr;
  double patch_m = 0;  // correlation length of the patches
};

// Point reflectors of one instance.
struct School {
  std::uint32_t instance = 0;
  std::vector<Vec3> fish_m;       // in the world
  double target_strength_db = 0;  // of each
};

struct VolumeParts {
  std::variant<Volume, School> part;
  double strength_db = 0;  // at density 1; for a school, the mean over its ellipsoid
};

// Grids by file and grid name, each read once.
using DensityCache =
    std::map<std::pair<std::string, std::string>, std::shared_ptr<const DensityGrid>>;

// `key` is for all random numbers of this volume. Errors: those of load_density_vdb and make_plume.
Result<VolumeParts> make_volume(const VolumeSpec& spec, std::uint64_t key, DensityCache& cache);

// The key for errors of this volume's kind, such as "vdb.file".
std::string faulty_key(const VolumeSpec& spec);

// Positions are uniform in the ellipsoid. That of fish i does not depend on the number of fish.
std::vector<Vec3> fish_of(const SchoolSpec& school, const Pose& pose, std::uint64_t key);

// R(z) = radius + z tan(spread).
double plume_radius_m(const PlumeSpec& plume, double z_m);

// (radius/R)^2 (1 - s^2/R^2)^2 at distance s from the axis, and zero outside. The density is 1 on
// the axis at the foot, and falls to zero over the uppermost fifth.
double plume_mean_density(const PlumeSpec& plume, Vec3 p);

// The mean density times the turbulence exp(sigma g - sigma^2/2). g is a normal field of unit
// variance everywhere, with three octaves of eddies that grow with R. The mean over keys is
// plume_mean_density. Error (usage): the plume is so wide that the grid does not resolve its foot.
Result<DensityGrid> make_plume(const PlumeSpec& plume, std::uint64_t key);

}  // namespace ensonify
