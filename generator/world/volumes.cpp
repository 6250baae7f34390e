#include "world/volumes.h"

#include <cmath>

#include "core/random.h"
#include "core/units.h"
#include "world/density_vdb.h"
#include "world/plume.h"

namespace ensonify {
namespace {

double linear(double db) { return std::pow(10.0, db / 10); }

Result<VolumeParts> with_grid(Result<DensityGrid> grid, double strength_db,
                              double extinction_db_m) {
  if (!grid) return grid.error();
  return VolumeParts{Volume{0,
                            linear(strength_db),
                            extinction_db_m,
                            std::make_shared<const DensityGrid>(std::move(*grid)),
                            {}},
                     strength_db};
}

Result<VolumeParts> parts_of(const UniformVolumeSpec& spec) {
  DensityField density;
  if (spec.size_m) {
    const std::array<double, 3>& size = *spec.size_m;
    density = DensityBox{{size[0] / 2, size[1] / 2, size[2] / 2}};
  }
  return VolumeParts{
      Volume{0, linear(spec.strength_db), spec.extinction_db_m, std::move(density), {}},
      spec.strength_db};
}

Result<VolumeParts> parts_of(const VdbVolumeSpec& spec, DensityCache& cache) {
  std::shared_ptr<const DensityGrid>& grid = cache[{spec.file.string(), spec.grid}];
  if (!grid) {
    Result<DensityGrid> loaded = load_density_vdb(spec.file, spec.grid);
    if (!loaded) return loaded.error();
    grid = std::make_shared<const DensityGrid>(std::move(*loaded));
  }
  return VolumeParts{Volume{0, linear(spec.strength_db), spec.extinction_db_m, grid, {}},
                     spec.strength_db};
}

Result<VolumeParts> parts_of(const SchoolSpec& spec, const Pose& pose, std::uint64_t key) {
  const double ellipsoid_m3 = kPi / 6 * spec.size_m[0] * spec.size_m[1] * spec.size_m[2];
  return VolumeParts{School{0, fish_of(spec, pose, key), spec.target_strength_db},
                     spec.target_strength_db + 10 * std::log10(spec.fish / ellipsoid_m3)};
}

}  // namespace

Result<VolumeParts> make_volume(const VolumeSpec& spec, std::uint64_t key, DensityCache& cache) {
  const Pose pose = pose_of(spec.pose);
  const auto made = [&]() -> Result<VolumeParts> {
    if (const auto* uniform = std::get_if<UniformVolumeSpec>(&spec.kind)) return parts_of(*uniform);
    if (const auto* vdb = std::get_if<VdbVolumeSpec>(&spec.kind)) return parts_of(*vdb, cache);
    if (const auto* plume = std::get_if<PlumeSpec>(&spec.kind)) {
      return with_grid(make_plume(*plume, key), plume->strength_db, plume->extinction_db_m);
    }
    return parts_of(std::get<SchoolSpec>(spec.kind), pose, key);
  };
  Result<VolumeParts> parts = made();
  if (!parts) return parts;
  if (auto* volume = std::get_if<Volume>(&parts->part)) volume->pose = pose;
  return parts;
}

std::string faulty_key(const VolumeSpec& spec) {
  return std::holds_alternative<PlumeSpec>(spec.kind) ? "plume.radius_m" : "vdb.file";
}

std::vector<Vec3> fish_of(const SchoolSpec& school, const Pose& pose, std::uint64_t key) {
  std::vector<Vec3> fish;
  for (int i = 0; i < school.fish; ++i) {
    const Philox4 words = random_words(key, 0, static_cast<std::uint64_t>(i), 0);
    const double radius = std::cbrt(uniform_from_word(words.v[0]));
    const double z = 2 * uniform_from_word(words.v[1]) - 1, side = std::sqrt(1 - z * z);
    const double turn = 2 * kPi * uniform_from_word(words.v[2]);
    const Vec3 p = (radius / 2) * Vec3{side * std::cos(turn), side * std::sin(turn), z};
    fish.push_back(transform_point(
        pose, {p.x * school.size_m[0], p.y * school.size_m[1], p.z * school.size_m[2]}));
  }
  return fish;
}

}  // namespace ensonify
