#include "world/smooth_body.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "world/curved_mesh.h"

namespace ensonify {
namespace {

// Below the sound speed of any water, so that a world does not depend on it.
constexpr double kSlowestSound_m_s = 1400;

// Facets that depart more from their body are warned of. They echo within about 1 dB, which is the
// rule of docs/physics/1_scattering.md for meshes with face normals.
constexpr double kFacetSag_wavelengths = 1.0 / 32;

bool has_specular_echo(const Scenario& scenario, const ObjectSpec& spec) {
  std::vector<std::string> names = {spec.material};
  if (const auto* mesh = std::get_if<MeshSpec>(&spec.shape)) {
    for (const PartSpec& part : mesh->parts) names.push_back(part.material);
  }
  // Growth is of a material without growth.
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto material = std::ranges::find(scenario.materials, names[i], &MaterialSpec::name);
    if (material == scenario.materials.end()) continue;
    if (std::holds_alternative<KirchhoffSpec>(material->coherent)) return true;
    if (material->growth) names.push_back(material->growth->material);
  }
  return false;
}

bool wants_smooth_normals(const ShapeSpec& shape) {
  if (const auto* mesh = std::get_if<MeshSpec>(&shape)) return mesh->smooth_normals;
  const auto* level_set = std::get_if<LevelSetSpec>(&shape);
  return level_set != nullptr && level_set->smooth_normals;
}

double highest_hz(const Scenario& scenario) {
  double highest = scenario.sonar.frequency_hz;
  for (const InstrumentSpec& instrument : scenario.rig) {
    if (instrument.sonar) highest = std::max(highest, instrument.sonar->frequency_hz);
  }
  return highest;
}

}  // namespace

std::optional<double> smoothness_hz(const Scenario& scenario) {
  const auto is_mirror = [&](const ObjectSpec& spec) {
    const bool is_mesh = std::holds_alternative<MeshSpec>(spec.shape) ||
                         std::holds_alternative<LevelSetSpec>(spec.shape);
    return is_mesh && has_specular_echo(scenario, spec);
  };
  if (std::ranges::none_of(scenario.objects, is_mirror)) return std::nullopt;
  return highest_hz(scenario);
}

Status smooth_body(const Scenario& scenario, const ObjectSpec& spec, const std::string& key,
                   MeshLibrary& library, MeshShape& shape, std::vector<std::string>& warnings) {
  if (!has_specular_echo(scenario, spec)) return {};
  const double wavelength_m = kSlowestSound_m_s / highest_hz(scenario);
  if (wants_smooth_normals(spec.shape)) {
    Result<std::shared_ptr<const Mesh>> curved =
        library.mesh(fmt::format("{}\nsmooth {:a}", key, wavelength_m),
                     [&] { return curved_mesh(*shape.mesh, wavelength_m); });
    if (!curved) return curved.error();
    shape.mesh = std::move(*curved);
    return {};
  }
  const FacetSag worst = facet_sag(*shape.mesh);
  if (worst.sag_m <= kFacetSag_wavelengths * wavelength_m) return {};
  warnings.push_back(fmt::format(
      "the material has a specular echo, and each facet of the mesh is a mirror of its own: sides "
      "of "
      "{:.2g} m stand for a body with a radius of {:.2g} m, which needs sides of at most {:.2g} m "
      "at "
      "{:.4g} kHz; expected `normals: smooth`, which makes the body smooth, or a finer mesh",
      worst.side_m, worst.radius_m, std::sqrt(wavelength_m * worst.radius_m) / 2,
      highest_hz(scenario) / 1e3));
  return {};
}

}  // namespace ensonify
