// Parameters of how surfaces scatter and reflect sound; acoustics/scattering.h has the formulas.
//
//   CoherentModel   its words in files: name_of
//   SurfaceTexture  Wall
//   Material  PartMaterials     how a surface scatters
//   FlatSurface  Multipath      which flat surfaces reflect sound, and how many bounces
//   SoundPath                   one path out and back
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/scattering_law.h"

namespace ensonify {

enum class CoherentModel { none, rician, kirchhoff };

// The words that scenarios and sequence.json use.
constexpr const char* name_of(CoherentModel model) {
  constexpr const char* kNames[] = {"none", "rician", "kirchhoff"};
  return kNames[static_cast<int>(model)];
}

enum class TextureModel { none, gamma, lognormal };
constexpr const char* name_of(TextureModel model) {
  constexpr const char* kNames[] = {"none", "gamma", "lognormal"};
  return kNames[static_cast<int>(model)];
}

// How the reflectivity varies over a surface, around its mean.
struct SurfaceTexture {
  TextureModel model = TextureModel::none;
  double shape = 1;      // nu of gamma: the relative variance is 1/nu
  double spread_db = 3;  // of lognormal: standard deviation of the level
  double correlation_m = 0;
};

// A thin wall that sound passes through: a plate of an elastic solid, or of a fluid if the shear
// speed is 0, with water in front of it.
struct Wall {
  double thickness_m = 0, density_kg_m3 = 0;
  double speed_m_s = 0, shear_speed_m_s = 0;  // of compressional and of shear waves
  double loss = 0.01;  // loss factor: the imaginary part of the elastic moduli over the real one
  bool water_inside = true;  // otherwise air, which lets nothing in

  bool operator==(const Wall&) const = default;
};

struct Material {
  ScatteringLaw law = Lambert{1};
  double reflectivity = 0;  // mu; without effect if the law states the strength itself
  CoherentModel coherent = CoherentModel::none;
  double rician_k = 0;         // K, power ratio of the constant part to the random one
  double reflection = 0;       // R of kirchhoff, -1 ... 1; 1 with a wall, which states its own
  double roughness_rms_m = 0;  // h of kirchhoff
  // L of kirchhoff; 0: the energy that roughness takes from the specular echo is lost.
  double roughness_correlation_m = 0;
  // Of this energy at a sonar's wavelength; null: none.
  std::shared_ptr<const BackscatterTable> rough = nullptr;
  bool edges = false;        // of kirchhoff: sharp edges diffract
  SurfaceTexture texture{};
  std::optional<Wall> wall{};
};

// Parts of a surface whose material differs from that of their object: parts of a mesh, and growth.
struct PartMaterials {
  std::vector<std::uint16_t> of_part;  // by Mesh::part: 0 the object's own, k: materials[k - 1]
  std::vector<Material> materials;     // of mesh parts, then of what has grown
};

// Horizontal and infinite.
struct FlatSurface {
  double z_m = 0;  // in the world
  double reflection = 0;
  double roughness_rms_m = 0;
};

struct Multipath {
  std::optional<FlatSurface> surface;  // sound stays below it
  std::optional<FlatSurface> bottom;
  bool objects = false;  // planes and faces of boxes whose material is kirchhoff
  int bounces = 2;       // at most, out and back together
};

inline constexpr int kMaxBounces = 4;
// Of `bounces`: surfaces beyond the first one on a path.
inline constexpr int kMostBounces = 3;
// Largest number of paths in a sequence: each is tried for every echo.
inline constexpr std::size_t kMaxSoundPaths = 4096;

// By the names of what it bounces off, in the order of the sound: surface, bottom, OBJECT.z of a
// plane, OBJECT.x- ... OBJECT.z+ of a box's faces; with `bounces`, "specular" or "diffuse" for each
// surface, all in `out`. Path 0 is the direct one and not listed.
struct SoundPath {
  std::uint16_t id = 0;  // Scatterer::path
  std::vector<std::string> out, back;
};

}  // namespace ensonify
