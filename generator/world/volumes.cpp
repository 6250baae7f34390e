#include "world/volumes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/random.h"
#include "core/units.h"

namespace ensonify {
namespace {

constexpr double kSigma = 0.8;        // of the logarithm of the density
constexpr double kMostSamples = 1e7;  // of the box around it
constexpr double kVoxelsPerRadius = 6;
constexpr double kFade = 0.2;  // of the height

// Normal numbers on the corners of unit cells, interpolated so that the variance is 1 everywhere.
class NormalField {
 public:
  // A field over [-reach, reach]^2 x [0, height].
  NormalField(int reach, int height, std::uint64_t key, std::uint32_t octave)
      : reach_(reach), side_(2 * reach + 2), levels_(height + 2) {
    values_.reserve(std::size_t(side_) * side_ * levels_);
    for (std::size_t i = 0; i < std::size_t(side_) * side_ * levels_; ++i) {
      values_.push_back(static_cast<float>(std::sqrt(2.0) * complex_normal(key, 0, i, octave).re));
    }
  }

  double at(double x, double y, double z) const {
    const Cell cx = cell(x + reach_, side_), cy = cell(y + reach_, side_), cz = cell(z, levels_);
    double sum = 0;
    for (int i = 0; i < 8; ++i) {
      const int a = i & 1, b = i >> 1 & 1, c = i >> 2;
      const std::size_t index =
          (std::size_t(cz.index + c) * side_ + cy.index + b) * side_ + cx.index + a;
      sum += cx.weight[a] * cy.weight[b] * cz.weight[c] * values_[index];
    }
    return sum / std::sqrt(cx.square() * cy.square() * cz.square());
  }

 private:
  struct Cell {
    int index = 0;
    std::array<double, 2> weight{};
    double square() const { return weight[0] * weight[0] + weight[1] * weight[1]; }
  };
  static Cell cell(double u, int count) {
    const int index = std::clamp(static_cast<int>(u), 0, count - 2);
    const double t = std::clamp(u - index, 0.0, 1.0), s = t * t * (3 - 2 * t);
    return {index, {1 - s, s}};
  }

  int reach_, side_, levels_;
  std::vector<float> values_;
};

// The height in local radii, the integral of dz / R.
double height_in_radii(const PlumeSpec& plume, double z_m) {
  const double slope = std::tan(radians(plume.spread_deg));
  if (slope * z_m < 1e-6 * plume.radius_m) return z_m / plume.radius_m;
  return std::log(plume_radius_m(plume, z_m) / plume.radius_m) / slope;
}

class Turbulence {
 public:
  Turbulence(const PlumeSpec& plume, std::uint64_t key) : plume_(plume) {
    const double height = height_in_radii(plume, plume.height_m);
    for (std::uint32_t o = 0; o < 3; ++o) {
      const int frequency = 1 << o;
      fields_.emplace_back(frequency + 1, static_cast<int>(std::ceil(height * frequency)), key, o);
    }
  }

  // The factor of turbulence, with mean 1.
  double at(Vec3 p) const {
    const double radius = plume_radius_m(plume_, p.z), z = height_in_radii(plume_, p.z);
    double g = 0, square = 0;
    for (std::size_t o = 0; o < fields_.size(); ++o) {
      const double frequency = 1 << o, amplitude = std::pow(frequency, -1.0 / 3);  // Kolmogorov's
      g += amplitude *
           fields_[o].at(p.x / radius * frequency, p.y / radius * frequency, z * frequency);
      square += amplitude * amplitude;
    }
    return std::exp(kSigma * g / std::sqrt(square) - kSigma * kSigma / 2);
  }

 private:
  PlumeSpec plume_;
  std::vector<NormalField> fields_;
};

}  // namespace

double plume_radius_m(const PlumeSpec& plume, double z_m) {
  return plume.radius_m + z_m * std::tan(radians(plume.spread_deg));
}

double plume_mean_density(const PlumeSpec& plume, Vec3 p) {
  if (!(p.z >= 0 && p.z <= plume.height_m)) return 0;
  const double radius = plume_radius_m(plume, p.z), narrow = plume.radius_m / radius;
  const double inside = 1 - (p.x * p.x + p.y * p.y) / (radius * radius);
  if (!(inside > 0)) return 0;
  const double fade = std::min(1.0, (1 - p.z / plume.height_m) / kFade);
  return narrow * narrow * inside * inside * fade;
}

Result<DensityGrid> make_plume(const PlumeSpec& plume, std::uint64_t key) {
  const double top_radius = plume_radius_m(plume, plume.height_m);
  const double box_m3 = 4 * top_radius * top_radius * plume.height_m;
  const double step = std::max(plume.radius_m / kVoxelsPerRadius, std::cbrt(box_m3 / kMostSamples));
  if (step > plume.radius_m) {
    return Error{
        ErrorKind::usage,
        fmt::format("too small for a plume of {:.3g} m radius at its top, whose grid "
                    "resolves {:.3g} m; expected a larger radius, or less height or spread",
                    top_radius, step)};
  }
  const Turbulence turbulence(plume, key);
  const int reach = static_cast<int>(std::ceil(top_radius / step));
  const auto point = [&](int x, int y, int z) { return Vec3{x * step, y * step, z * step}; };
  DensitySource source;
  source.low = {-reach, -reach, 0};
  source.high = {reach, reach, static_cast<int>(plume.height_m / step)};
  // The plume is widest at its upper end.
  source.is_empty = [&](std::array<int, 3> first) {
    constexpr int kLast = DensityGrid::kCells;
    const auto nearest = [](int from) { return std::clamp(0, from, from + kLast); };
    const Vec3 p = point(nearest(first[0]), nearest(first[1]), first[2] + kLast);
    return std::hypot(p.x, p.y) > plume_radius_m(plume, std::max(p.z, 0.0));
  };
  source.fill = [&](std::array<int, 3> first, float* samples) {
    constexpr int edge = DensityGrid::kCorners;
    for (int i = 0; i < DensityGrid::kBrickSamples; ++i) {
      const Vec3 p = point(first[0] + i % edge, first[1] + i / edge % edge,
                           first[2] + i / (edge * edge));
      const double mean = plume_mean_density(plume, p);
      samples[i] = mean > 0 ? static_cast<float>(mean * turbulence.at(p)) : 0;
    }
  };
  Affine index_from_local;
  index_from_local.rows = {{{1 / step, 0, 0}, {0, 1 / step, 0}, {0, 0, 1 / step}}};
  return make_density_grid(source, index_from_local, step);
}

namespace {

double linear(double db) { return std::pow(10.0, db / 10); }

VolumeParts scattering_water(double strength_db, double extinction_db_m, DensityField density) {
  return {Volume{0, linear(strength_db), extinction_db_m, std::move(density), {}}, strength_db};
}

Result<VolumeParts> parts_of(const UniformVolumeSpec& spec, std::uint64_t key) {
  DensityField density;
  if (spec.size_m) {
    const std::array<double, 3>& size = *spec.size_m;
    density = DensityBox{{size[0] / 2, size[1] / 2, size[2] / 2}};
  }
  VolumeParts parts = scattering_water(spec.strength_db, spec.extinction_db_m, std::move(density));
  if (spec.patches) {
    auto& volume = std::get<Volume>(parts.part);
    volume.patches = make_texture(*spec.patches, key);
    volume.patch_m = spec.patches->correlation_m;
  }
  return parts;
}

Result<VolumeParts> parts_of(const VdbVolumeSpec& spec, DensityCache& cache) {
  std::shared_ptr<const DensityGrid>& grid = cache[{spec.file.string(), spec.grid}];
  if (!grid) {
    Result<DensityGrid> loaded = load_density_vdb(spec.file, spec.grid);
    if (!loaded) return loaded.error();
    grid = std::make_shared<const DensityGrid>(std::move(*loaded));
  }
  return scattering_water(spec.strength_db, spec.extinction_db_m, grid);
}

Result<VolumeParts> parts_of(const PlumeSpec& spec, std::uint64_t key) {
  Result<DensityGrid> grid = make_plume(spec, key);
  if (!grid) return grid.error();
  return scattering_water(spec.strength_db, spec.extinction_db_m,
                          std::make_shared<const DensityGrid>(std::move(*grid)));
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
    if (const auto* uniform = std::get_if<UniformVolumeSpec>(&spec.kind)) {
      return parts_of(*uniform, key);
    }
    if (const auto* vdb = std::get_if<VdbVolumeSpec>(&spec.kind)) return parts_of(*vdb, cache);
    if (const auto* plume = std::get_if<PlumeSpec>(&spec.kind)) return parts_of(*plume, key);
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
