// From the volumes of a scenario to what the tracer knows of them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/error.h"
#include "core/vec.h"
#include "scenario/scenario.h"
#include "world/density.h"

namespace ensonify {

// Water that scatters and attenuates in proportion to its density.
struct Volume {
  std::uint32_t instance = 0;
  double strength_per_m = 0;   // s_v of density 1, cross-section of a unit of volume per steradian
  double extinction_db_m = 0;  // of density 1, one way, beside the water's absorption
  DensityField density{};
  Pose pose{};  // in the world
};

// Point reflectors of one instance.
struct School {
  std::uint32_t instance = 0;
  std::vector<Vec3> fish_m;       // in the world
  double target_strength_db = 0;  // of each
};

struct VolumeParts {
  std::variant<Volume, School> part;
  double strength_db = 0;  // of density 1; of a school the mean over its ellipsoid
};

// Grids by file and grid name, each read once.
using DensityCache =
    std::map<std::pair<std::string, std::string>, std::shared_ptr<const DensityGrid>>;

// `key` is of all random numbers of this volume. Errors: those of load_density_vdb and make_plume.
Result<VolumeParts> make_volume(const VolumeSpec& spec, std::uint64_t key, DensityCache& cache);

// The key that the errors of this volume's kind are told behind: "vdb.file".
std::string faulty_key(const VolumeSpec& spec);

// Uniformly in the ellipsoid, fish i by itself whatever their number.
std::vector<Vec3> fish_of(const SchoolSpec& school, const Pose& pose, std::uint64_t key);

}  // namespace ensonify
