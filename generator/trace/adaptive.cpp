#include "trace/adaptive.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "acoustics/pulse.h"
#include "acoustics/scattering.h"
#include "core/error.h"
#include "trace/echo.h"

namespace ensonify {
namespace {

double elevation_step_rad(const Sonar& sonar) {
  return sonar.elevation_fan_rad / sonar.rays_elevation;
}

double azimuth_step_rad(const Sonar& sonar) { return sonar.beam_spacing_rad / sonar.rays_azimuth; }

struct Turn {
  double cosine = 1, sine = 0;
};

Slant slant_of(Vec3 normal, double range_m, const Turn& azimuth, const Turn& elevation) {
  const auto [ca, sa] = azimuth;
  const auto [ce, se] = elevation;
  const double along = dot(normal, {ce * ca, ce * sa, se});
  const double turned = dot(normal, {-ce * sa, ce * ca, 0}),
               raised = dot(normal, {-se * ca, -se * sa, ce});
  return {-range_m * turned / along, -range_m * raised / along};
}

Turn turn_of(double angle_rad) { return {std::cos(angle_rad), std::sin(angle_rad)}; }

// The slants at hits of a fan, whose rows and columns share their angles.
class FanSlants {
 public:
  FanSlants(const Fan& fan, const Pose& sonar_in_world)
      : to_sonar_(conjugate(sonar_in_world.rotation)) {
    for (const double angle_rad : fan.azimuth_rad) azimuth_.push_back(turn_of(angle_rad));
    for (const double angle_rad : fan.elevation_rad) elevation_.push_back(turn_of(angle_rad));
  }
  Slant at(std::size_t ray, const Hit& hit) const {
    return slant_of(rotate(to_sonar_, hit.normal), hit.range_m, azimuth_[ray / elevation_.size()],
                    elevation_[ray % elevation_.size()]);
  }

 private:
  Quat to_sonar_;
  std::vector<Turn> azimuth_, elevation_;
};

std::uint16_t pieces_for(const Sonar& sonar, double scatterers) {
  const double wanted = std::ceil(sonar.rays_per_cell / scatterers);
  return static_cast<std::uint16_t>(std::clamp(wanted, 1.0, double{kMostPieces}));
}

// One column of the fan with its cells cut.
void cut_column(const Sonar& sonar, const Fan& fan, std::size_t column,
                std::span<const std::uint16_t> pieces, Fan& cut) {
  cut = {1, 1, 0, {fan.azimuth_rad[column]}, {}, {}};
  const double step = elevation_step_rad(sonar), azimuth_step = azimuth_step_rad(sonar);
  for (int e = 0; e < fan.rays_elevation; ++e) {
    const double low = fan.elevation_rad[e] - step / 2, part = step / pieces[e];
    for (int i = 0; i < pieces[e]; ++i) {
      cut.elevation_rad.push_back(pieces[e] == 1 ? fan.elevation_rad[e] : low + (i + 0.5) * part);
      cut.solid_angle_sr.push_back(
          cell_solid_angle_sr(azimuth_step, low + i * part, low + (i + 1) * part));
    }
  }
  cut.rays_elevation = static_cast<int>(cut.elevation_rad.size());
}

// The scatterers of one column, `first_ray` being its lowest ray in the whole fan.
void add_column(const Fan& cut, const FanHits& found, std::span<const std::uint16_t> pieces,
                const SurfaceScattering& scattering, std::uint32_t beam, std::uint64_t first_ray,
                std::vector<Scatterer>& scatterers) {
  const SurfaceEchoes echoes{cut, scattering};
  ScattererMoments moments;
  std::uint32_t ray = 0;
  for (std::size_t e = 0; e < pieces.size(); ++e) {
    for (std::uint64_t piece = 0; piece < pieces[e]; ++piece, ++ray) {
      const Hit& hit = found.hits[ray];
      const RayPath* path = found.paths.empty() ? nullptr : &found.paths[ray];
      if (!echoes.moments(hit, ray, moments, path)) continue;
      Scatterer& s = scatterers.emplace_back();
      echoes.set(0, ray, hit, moments, s, path);
      s.beam = beam;
      s.key = piece << 32 | (first_ray + e);
    }
  }
}

}  // namespace

ResolutionCell resolution_cell(const Sonar& sonar, const Water& water, int transform) {
  return {sonar.beam_width_rad, water.sound_speed_m_s * pulse_width_s(sonar, transform) / 2};
}

Slant slant_of(Vec3 normal, double range_m, double azimuth_rad, double elevation_rad) {
  return slant_of(normal, range_m, turn_of(azimuth_rad), turn_of(elevation_rad));
}

double scatterers_per_cell(const Sonar& sonar, const ResolutionCell& cell, const Slant& slant) {
  const double across = std::min(cell.width_rad, cell.range_m / std::abs(slant.azimuth_m));
  const double area = std::min(cell.width_rad * cell.range_m / std::abs(slant.elevation_m),
                               across * sonar.elevation_fan_rad);
  return area / (azimuth_step_rad(sonar) * elevation_step_rad(sonar));
}

double undersampled_share(const Sonar& sonar, const ResolutionCell& cell, const Fan& fan,
                          std::span<const Hit> hits, const Pose& sonar_in_world, double least) {
  ENSONIFY_ASSERT(hits.size() == fan.size());
  const FanSlants slants(fan, sonar_in_world);
  double all_m = 0, undersampled_m = 0;
  for (std::size_t ray = 0; ray < hits.size(); ++ray) {
    if (!is_usable(hits[ray], sonar)) continue;
    const Slant slant = slants.at(ray, hits[ray]);
    double count = scatterers_per_cell(sonar, cell, slant);
    if (sonar.rays_per_cell > 0) count *= pieces_for(sonar, count);
    const double passes_m = std::clamp(std::abs(slant.elevation_m) * elevation_step_rad(sonar),
                                       cell.range_m, sonar.range_max_m);
    all_m += passes_m;
    if (count < least) undersampled_m += passes_m;
  }
  return all_m > 0 ? undersampled_m / all_m : 0;
}

std::vector<std::uint16_t> adaptive_pieces(const Sonar& sonar, const ResolutionCell& cell,
                                           const Fan& fan, std::span<const Hit> hits,
                                           const Pose& sonar_in_world) {
  ENSONIFY_ASSERT(hits.size() == fan.size());
  const FanSlants slants(fan, sonar_in_world);
  std::vector<std::uint16_t> pieces(hits.size(), 1);
  for (std::size_t ray = 0; ray < hits.size(); ++ray) {
    if (!is_usable(hits[ray], sonar)) continue;
    const Slant slant = slants.at(ray, hits[ray]);
    pieces[ray] = pieces_for(sonar, scatterers_per_cell(sonar, cell, slant));
  }
  // A surface that leaves the range within a cell is met by a part of it.
  std::vector<std::uint16_t> all = pieces;
  const std::size_t rows = fan.elevation_rad.size();
  for (std::size_t ray = 0; ray < hits.size(); ++ray) {
    if (is_usable(hits[ray], sonar)) continue;
    if (ray % rows > 0) all[ray] = std::max(all[ray], pieces[ray - 1]);
    if (ray % rows + 1 < rows) all[ray] = std::max(all[ray], pieces[ray + 1]);
  }
  return all;
}

ScattererList adaptive_surface_scatterers(const Fan& fan, const FanRaysMet& met,
                                          std::span<const std::uint16_t> pieces,
                                          const Tracer& tracer, const Pose& sonar_in_world,
                                          const SurfaceScattering& scattering,
                                          const Workers& workers) {
  ENSONIFY_ASSERT(met.hits.size() == fan.size() && pieces.size() == fan.size());
  const Sonar& sonar = scattering.sonar;
  const std::size_t rows = fan.elevation_rad.size();
  std::vector<std::vector<Scatterer>> of_beam(fan.beams);
  workers.for_each(fan.beams, [&](std::size_t beam) {
    Fan cut;
    const auto of_sector = pieces.subspan(beam * fan.rays_per_beam(), fan.rays_per_beam());
    of_beam[beam].reserve(std::accumulate(of_sector.begin(), of_sector.end(), std::size_t{0}));
    for (int a = 0; a < fan.rays_azimuth; ++a) {
      const std::size_t column = beam * fan.rays_azimuth + a, first = column * rows;
      const auto part = pieces.subspan(first, rows);
      cut_column(sonar, fan, column, part, cut);
      const bool is_cut = cut.elevation_rad.size() > rows;
      FanHits found;
      if (is_cut) {
        found = trace_fan(tracer, cut, sonar_in_world, sonar, scattering.water, Workers(1));
      } else {
        const auto hits = met.hits.subspan(first, rows);
        found.hits.assign(hits.begin(), hits.end());
        if (!met.paths.empty()) {
          const auto paths = met.paths.subspan(first, rows);
          found.paths.assign(paths.begin(), paths.end());
        }
      }
      add_column(cut, found, part, scattering, static_cast<std::uint32_t>(beam), first,
                 of_beam[beam]);
    }
  });
  return sorted_by_delay(of_beam, workers);
}

}  // namespace ensonify
