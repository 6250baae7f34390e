#include "trace/surface_scattering.h"

#include <algorithm>
#include <memory>

#include "acoustics/scattering.h"
#include "core/error.h"

namespace ensonify {

static void add_wall(const Material& material, SurfaceScattering& scattering) {
  if (!material.wall) return;
  const Wall& wall = *material.wall;
  const auto known = std::ranges::find(scattering.walls, wall, &SurfaceScattering::KnownWall::wall);
  if (known != scattering.walls.end()) return;
  const Sonar& sonar = scattering.sonar;
  scattering.walls.push_back(
      {wall, wall_response(wall, scattering.water, sonar.frequency_hz, sonar.bandwidth_hz)});
}

namespace {

// What depends on the sonar, computed once for equal surfaces.
class SonarMaterials {
 public:
  explicit SonarMaterials(SurfaceScattering& scattering) : scattering_(scattering) {}

  void complete(Material& material) {
    add_wall(material, scattering_);
    if (material.coherent != CoherentModel::kirchhoff || material.roughness_correlation_m == 0) {
      return;
    }
    const RoughSurface surface{material.reflection, material.roughness_rms_m,
                               material.roughness_correlation_m};
    const auto known = std::ranges::find(known_, surface, &Known::surface);
    if (known != known_.end()) {
      material.rough = known->table;
      return;
    }
    const double wavelength = scattering_.water.sound_speed_m_s / scattering_.sonar.frequency_hz;
    material.rough =
        std::make_shared<const BackscatterTable>(rough_backscatter_table(surface, wavelength));
    known_.push_back({surface, material.rough});
  }

 private:
  struct Known {
    RoughSurface surface;
    std::shared_ptr<const BackscatterTable> table;
  };
  SurfaceScattering& scattering_;
  std::vector<Known> known_;
};

}  // namespace

SurfaceScattering make_surface_scattering(const Sonar& sonar, const Water& water,
                                          const World& world) {
  SurfaceScattering scattering{sonar, water, {}, {}, {}};
  scattering.material.resize(world.instances.size() + 1);
  for (const WorldObject& object : world.objects) {
    scattering.material[object.instance] = object.material;
    if (object.parts.materials.empty()) continue;
    scattering.part_material.resize(scattering.material.size());
    scattering.part_material[object.instance] = object.parts.materials;
  }
  SonarMaterials materials(scattering);
  for (Material& material : scattering.material) materials.complete(material);
  for (auto& parts : scattering.part_material) {
    for (Material& material : parts) materials.complete(material);
  }
  scattering.edges = diffracting_edges(world, water.sound_speed_m_s / sonar.frequency_hz);
  return scattering;
}

const WallResponse* wall_at(const SurfaceScattering& scattering, const Hit& hit) {
  if (scattering.walls.empty()) return nullptr;
  const Material& material = material_at(scattering, hit);
  if (!material.wall) return nullptr;
  const auto known =
      std::ranges::find(scattering.walls, *material.wall, &SurfaceScattering::KnownWall::wall);
  ENSONIFY_ASSERT(known != scattering.walls.end());
  return &known->response;
}

}  // namespace ensonify
