#include "trace/adaptive.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "acoustics/pulse.h"
#include "acoustics/scattering.h"
#include "core/error.h"
#include "trace/echo.h"
#include "trace/sector_lists.h"

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

// The slants at the hits of a fan. The rays of a row share an elevation, those of a column an
// azimuth.
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

// scatterers_per_cell at the hit of a ray, for the width of its beam.
double scatterers_at(const Sonar& sonar, const ResolutionCell& cell, const Fan& fan,
                     std::size_t ray, const Slant& slant) {
  const std::size_t beam = ray / fan.rays_per_beam();
  return scatterers_per_cell(sonar,
                             {width_of_beam_rad(sonar, static_cast<int>(beam)), cell.range_m},
                             slant, fan.relative_width_of(beam));
}

std::uint16_t pieces_for(const Sonar& sonar, double scatterers) {
  const double wanted = std::ceil(sonar.rays_per_cell / scatterers);
  return static_cast<std::uint16_t>(std::clamp(wanted, 1.0, double{kMostPieces}));
}

struct Piece {
  FanDirections::Part elevation;
  double solid_angle_sr = 0;  // in a beam cell of mean width
};

// The pieces into which cells of the fan are cut. Columns that cut a row into the same number of
// pieces share them.
class CutRows {
 public:
  CutRows(const Sonar& sonar, const Fan& fan, std::span<const std::uint16_t> pieces)
      : first_(fan.elevation_rad.size() * kCounts, kNone) {
    const std::size_t rows = fan.elevation_rad.size();
    std::uint32_t end = 0;
    for (std::size_t ray = 0; ray < pieces.size(); ++ray) {
      std::uint32_t& first = first_[ray % rows * kCounts + pieces[ray]];
      if (first == kNone) first = std::exchange(end, end + pieces[ray]);
    }
    pieces_.resize(end);
    for (std::size_t e = 0; e < rows; ++e) {
      for (int count = 1; count <= kMostPieces; ++count) {
        const std::uint32_t first = first_[e * kCounts + count];
        if (first != kNone) cut(sonar, fan.elevation_rad[e], {&pieces_[first], std::size_t(count)});
      }
    }
  }

  const Piece* at(std::size_t e, std::uint16_t count) const {
    return &pieces_[first_[e * kCounts + count]];
  }

 private:
  static constexpr std::size_t kCounts = kMostPieces + 1;
  static constexpr std::uint32_t kNone = ~0u;

  static void cut(const Sonar& sonar, double middle_rad, std::span<Piece> pieces) {
    const double step = elevation_step_rad(sonar), low = middle_rad - step / 2;
    const double part = step / static_cast<double>(pieces.size());
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      const double from = low + static_cast<double>(i) * part,
                   to = low + static_cast<double>(i + 1) * part;
      const double elevation =
          pieces.size() == 1 ? middle_rad : low + (static_cast<double>(i) + 0.5) * part;
      pieces[i] = {elevation_part(elevation, sonar),
                   cell_solid_angle_sr(azimuth_step_rad(sonar), from, to)};
    }
  }

  std::vector<std::uint32_t> first_;  // [rows x kCounts], into pieces_
  std::vector<Piece> pieces_;
};

// What all beam cells share.
struct CutFan {
  const Fan& fan;
  const FanRaysMet& met;
  std::span<const std::uint16_t> pieces;  // [fan.size()]
  const Tracer& tracer;
  const Pose& sonar_in_world;
  const SurfaceScattering& scattering;
  CutRows rows;
  FanDirections directions;
};

struct Echo {
  const Piece* piece;
  const Hit* hit;
  const RayPath* path;  // null where rays are straight
};

// The rays through the cut cells of one beam cell, column by column, and the echoes of the beam
// cell.
struct PieceWork : SectorWork {
  std::vector<Vec3> direction;  // in the world
  std::vector<Hit> hits;
  std::vector<RayPath> paths;
  std::vector<Echo> echoes;
};

void trace_straight(const CutFan& cut, std::size_t beam, PieceWork& work) {
  const std::size_t rows = cut.fan.elevation_rad.size();
  work.direction.clear();
  for (int a = 0; a < cut.fan.rays_azimuth; ++a) {
    const std::size_t column = beam * cut.fan.rays_azimuth + a;
    const FanDirections::Part& along = cut.directions.azimuth[column];
    for (std::size_t e = 0; e < rows; ++e) {
      const std::uint16_t count = cut.pieces[column * rows + e];
      if (count == 1) continue;
      for (const Piece& piece : std::span(cut.rows.at(e, count), count)) {
        const auto& up = piece.elevation;
        work.direction.push_back(
            normalized(rotate(cut.sonar_in_world.rotation,
                              {up.cosine * along.cosine, up.cosine * along.sine, up.sine})));
      }
    }
  }
  work.hits.resize(work.direction.size());
  cut.tracer.first_hits(cut.sonar_in_world.position_m, work.direction,
                        cut.scattering.sonar.range_max_m, work.hits);
}

void trace_refracted(const CutFan& cut, std::size_t beam, PieceWork& work) {
  const std::size_t rows = cut.fan.elevation_rad.size();
  work.hits.clear();
  work.paths.clear();
  for (int a = 0; a < cut.fan.rays_azimuth; ++a) {
    const std::size_t column = beam * cut.fan.rays_azimuth + a;
    Fan fan{1, 1, 0, {cut.fan.azimuth_rad[column]}, {}, {}};
    for (std::size_t e = 0; e < rows; ++e) {
      const std::uint16_t count = cut.pieces[column * rows + e];
      if (count == 1) continue;
      for (const Piece& piece : std::span(cut.rows.at(e, count), count)) {
        fan.elevation_rad.push_back(piece.elevation.angle_rad);
      }
    }
    fan.rays_elevation = static_cast<int>(fan.elevation_rad.size());
    const FanHits found = trace_fan(cut.tracer, fan, cut.sonar_in_world, cut.scattering.sonar,
                                    cut.scattering.water, Workers(1));
    work.hits.insert(work.hits.end(), found.hits.begin(), found.hits.end());
    work.paths.insert(work.paths.end(), found.paths.begin(), found.paths.end());
  }
}

// A cell that is not cut keeps the fan's own ray.
void gather_echoes(const CutFan& cut, std::size_t beam, PieceWork& work) {
  const bool refracted = !cut.met.paths.empty();
  const std::size_t rays = cut.fan.rays_per_beam(), rows = cut.fan.elevation_rad.size();
  work.order.clear();
  work.echoes.clear();
  work.moments.clear();
  ScattererMoments moments;
  std::size_t next = 0;
  const double width = cut.fan.relative_width_of(beam);
  for (std::size_t ray = beam * rays; ray < (beam + 1) * rays; ++ray) {
    const std::uint16_t count = cut.pieces[ray];
    const Piece* piece = cut.rows.at(ray % rows, count);
    for (std::uint16_t i = 0; i < count; ++i, ++piece) {
      const bool own = count == 1;
      const Hit* hit = own ? &cut.met.hits[ray] : &work.hits[next];
      const RayPath* path = nullptr;
      if (refracted) path = own ? &cut.met.paths[ray] : &work.paths[next];
      next += !own;
      if (!surface_moments(cut.scattering, *hit, width * piece->solid_angle_sr, path, moments)) {
        continue;
      }
      work.order.push_back({two_way_delay_s(hit->range_m, cut.scattering.water.sound_speed_m_s),
                            std::uint64_t{i} << 32 | ray,
                            static_cast<std::uint32_t>(work.echoes.size())});
      work.echoes.push_back({piece, hit, path});
      work.moments.push_back(moments);
    }
  }
}

void add_sector(const CutFan& cut, std::size_t beam, PieceWork& work,
                std::vector<Scatterer>& scatterers) {
  if (cut.met.paths.empty()) {
    trace_straight(cut, beam, work);
  } else {
    trace_refracted(cut, beam, work);
  }
  gather_echoes(cut, beam, work);
  sort_keys(work.order);
  for (const SortKey& key : work.order) {
    const auto& [piece, hit, path] = work.echoes[key.index];
    const std::size_t column = (key.key & 0xffffffffu) / cut.fan.elevation_rad.size();
    set_surface_echo(cut.scattering,
                     FanDirections::of(cut.directions.azimuth[column], piece->elevation),
                     static_cast<std::uint32_t>(beam), key.key, *hit, work.moments[key.index], path,
                     scatterers.emplace_back());
  }
}

}  // namespace

ResolutionCell resolution_cell(const Sonar& sonar, const Water& water, int transform) {
  return {sonar.beam_width_rad, water.sound_speed_m_s * pulse_width_s(sonar, transform) / 2};
}

Slant slant_of(Vec3 normal, double range_m, double azimuth_rad, double elevation_rad) {
  return slant_of(normal, range_m, turn_of(azimuth_rad), turn_of(elevation_rad));
}

double scatterers_per_cell(const Sonar& sonar, const ResolutionCell& cell, const Slant& slant,
                           double relative_width) {
  const double across = std::min(cell.width_rad, cell.range_m / std::abs(slant.azimuth_m));
  const double area = std::min(cell.width_rad * cell.range_m / std::abs(slant.elevation_m),
                               across * sonar.elevation_fan_rad);
  return area / (relative_width * azimuth_step_rad(sonar) * elevation_step_rad(sonar));
}

double undersampled_share(const Sonar& sonar, const ResolutionCell& cell, const Fan& fan,
                          std::span<const Hit> hits, const Pose& sonar_in_world, double least) {
  ENSONIFY_ASSERT(hits.size() == fan.size());
  const FanSlants slants(fan, sonar_in_world);
  double all_m = 0, undersampled_m = 0;
  for (std::size_t ray = 0; ray < hits.size(); ++ray) {
    if (!is_usable(hits[ray], sonar)) continue;
    const Slant slant = slants.at(ray, hits[ray]);
    double count = scatterers_at(sonar, cell, fan, ray, slant);
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
    pieces[ray] = pieces_for(sonar, scatterers_at(sonar, cell, fan, ray, slant));
  }
  // A ray that misses takes the cut of its neighbors in elevation, since a part of its cell may
  // still meet their surface.
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
  const CutFan cut{fan,
                   met,
                   pieces,
                   tracer,
                   sonar_in_world,
                   scattering,
                   CutRows(sonar, fan, pieces),
                   directions_of(fan, sonar)};
  std::vector<std::uint32_t> most(static_cast<std::size_t>(fan.beams), 0);
  for (std::size_t ray = 0; ray < pieces.size(); ++ray) {
    most[ray / fan.rays_per_beam()] +=
        pieces[ray] > 1 ? pieces[ray] : is_usable(met.hits[ray], sonar);
  }
  return list_of_sectors<PieceWork>(
      most, workers, [&](std::size_t beam, PieceWork& work, std::vector<Scatterer>& scatterers) {
        add_sector(cut, beam, work, scatterers);
      });
}

}  // namespace ensonify
