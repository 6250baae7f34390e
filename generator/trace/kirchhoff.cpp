#include <algorithm>
#include <cmath>

#include "acoustics/scattering.h"
#include "core/error.h"
#include "trace/cell_cutting.h"
#include "trace/echo.h"
#include "trace/scatter.h"
#include "trace/walls.h"

namespace ensonify {

static bool same_body(const Hit& a, const Hit& b) { return a.instance == b.instance; }

// A change of material is an edge, even if the surface continues. Patches of growth are no edges:
// their outlines are random, and finding them would take a hundred times as many parts.
static bool same_surface(const Hit& a, const Hit& b) {
  return a.instance == b.instance && a.own_part == b.own_part;
}

namespace {

using Part = CellPart<Hit>;

bool is_smooth(const SurfaceScattering& scattering, const Hit& hit) {
  return hit.instance != 0 && material_at(scattering, hit).coherent == CoherentModel::kirchhoff;
}

bool any_smooth(std::span<const Material> materials) {
  return std::ranges::any_of(materials, [](const Material& material) {
    return material.coherent == CoherentModel::kirchhoff;
  });
}

// What the parts of one beam cell share.
struct Sector {
  const Tracer& tracer;
  const Pose& pose;
  const SurfaceScattering& scattering;
  double wavelength_m = 0;
  double range_limit_m = 0;
  int beam = 0;
  std::uint64_t next_key = 0;
  std::vector<Scatterer> scatterers;

  bool is_mirror(const Hit& hit) const { return is_smooth(scattering, hit); }
  Hit shoot(double azimuth_rad, double elevation_rad) const;
  void add(const Part& part);
};

Hit Sector::shoot(double azimuth_rad, double elevation_rad) const {
  const Vec3 direction = unit_vector(azimuth_rad, elevation_rad);
  return tracer.first_hit({pose.position_m, normalized(rotate(pose.rotation, direction))},
                          scattering.sonar.range_max_m);
}

std::complex<double> amplitude_of(const Part& part, const Sector& sector) {
  const Hit& middle = part.hits[1][1];
  const Material& material = material_at(sector.scattering, middle);
  const double solid_angle = cell_solid_angle_sr(part.azimuth_rad[2] - part.azimuth_rad[0],
                                                 part.elevation_rad[0], part.elevation_rad[2]);
  const auto with_changes = [&](double azimuth_m, double elevation_m) {
    return kirchhoff_amplitude_m(material, sector.wavelength_m, middle.cos_incidence,
                                 middle.range_m, solid_angle, azimuth_m, elevation_m);
  };
  const Bend bend = bend_of(part);
  return with_changes(bend.change_azimuth_m, bend.change_elevation_m) +
         with_changes(0, 0) * bend_factor(bend, sector.wavelength_m);
}

void Sector::add(const Part& part) {
  const Hit& middle = part.hits[1][1];
  if (!is_mirror(middle) || !in_range(middle.range_m, scattering.sonar)) return;
  const std::complex<double> amplitude = amplitude_of(part, *this);
  if (!std::isfinite(std::norm(amplitude))) return;
  Scatterer s = echo_from(middle.range_m, part.azimuth_rad[1], part.elevation_rad[1], beam,
                          scattering.sonar, scattering.water);
  s.mean = std::complex<float>(amplitude);
  s.cos_incidence = middle.cos_incidence;
  s.key = next_key++;
  s.instance = middle.instance;
  const WallResponse* wall = wall_at(scattering, middle);
  if (wall == nullptr) {
    scatterers.push_back(s);
    return;
  }
  WallEvents walls;
  walls.add(wall_event(wall, middle, true));
  add_with_walls(s, walls, scattering.sonar, scattering.water, scatterers);
}

// Whether the cell's own ray, or one of the eight around it, meets a smooth surface. `hits` are
// those of the whole fan.
bool is_candidate(const Fan& fan, std::span<const Hit> hits, std::size_t own_column, int elevation,
                  const SurfaceScattering& scattering) {
  const std::size_t columns = fan.rays_azimuth;
  const std::size_t column =
      static_cast<std::size_t>(fan.beam_of(own_column / columns)) * columns + own_column % columns;
  const std::size_t last_column = std::min(column + 1, hits.size() / fan.rays_elevation - 1);
  for (std::size_t c = column == 0 ? 0 : column - 1; c <= last_column; ++c) {
    for (int e = std::max(elevation - 1, 0); e <= std::min(elevation + 1, fan.rays_elevation - 1);
         ++e) {
      if (is_smooth(scattering, hits[c * fan.rays_elevation + e])) return true;
    }
  }
  return false;
}

}  // namespace

bool has_smooth_surfaces(const SurfaceScattering& scattering) {
  return any_smooth(scattering.material) ||
         std::ranges::any_of(scattering.part_material, any_smooth);
}

std::vector<Scatterer> kirchhoff_scatterers(const Fan& fan, std::span<const Hit> hits,
                                            const Tracer& tracer, const Pose& sonar_in_world,
                                            const SurfaceScattering& scattering,
                                            const Workers& workers, std::span<const Hit> all_hits) {
  ENSONIFY_ASSERT(hits.size() == fan.size());
  const std::span<const Hit> whole = all_hits.empty() ? hits : all_hits;
  if (!has_smooth_surfaces(scattering)) return {};
  const Sonar& sonar = scattering.sonar;
  const double elevation_step = sonar.elevation_fan_rad / fan.rays_elevation;
  std::vector<std::vector<Scatterer>> by_beam(fan.beams);
  workers.for_each(fan.beams, [&](std::size_t beam) {
    Sector sector{tracer,
                  sonar_in_world,
                  scattering,
                  scattering.water.sound_speed_m_s / sonar.frequency_hz,
                  kLongestRange_pulses * scattering.water.sound_speed_m_s / sonar.bandwidth_hz,
                  static_cast<int>(beam),
                  0,
                  {}};
    const double azimuth_step = cell_width_rad(sonar, fan.beam_of(beam)) / fan.rays_azimuth;
    for (int a = 0; a < fan.rays_azimuth; ++a) {
      const std::size_t column = beam * fan.rays_azimuth + a;
      for (int e = 0; e < fan.rays_elevation; ++e) {
        if (!is_candidate(fan, whole, column, e, scattering)) continue;
        // Keeps the keys apart from those of rays and targets. No amplitude is random here; keys
        // only order equal delays.
        sector.next_key =
            (std::uint64_t{1} << 62) | (std::uint64_t{column * fan.rays_elevation + e} << 28);
        divide(cell_of<Hit>(fan.azimuth_rad[column], azimuth_step, fan.elevation_rad[e],
                            elevation_step, sector),
               sector);
      }
    }
    by_beam[beam] = std::move(sector.scatterers);
  });
  std::vector<Scatterer> scatterers;
  append(by_beam, scatterers);
  return scatterers;
}

}  // namespace ensonify
