#include "trace/piece_echoes.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/error.h"
#include "trace/echo.h"
#include "trace/sector_lists.h"

namespace ensonify {
namespace {

struct Piece {
  FanDirections::Part elevation;
  double solid_angle_sr = 0;  // in a beam cell of mean width
};

// The pieces into which cells of the fan are cut. Columns that cut a row into the same number of
// pieces share them.
class CutRows {
 public:
  // `known`, unless null: pieces of the same fan that need not be computed again.
  CutRows(const Sonar& sonar, const Fan& fan, std::span<const std::uint16_t> pieces,
          const CutRows* known)
      : rows_(fan.elevation_rad.size()),
        counts_(*std::ranges::max_element(pieces) + std::size_t{1}),
        first_(rows_ * counts_, kNone) {
    std::uint32_t end = 0;
    for (std::size_t ray = 0; ray < pieces.size(); ++ray) {
      std::uint32_t& first = first_[index(ray, pieces[ray])];
      if (first == kNone) first = std::exchange(end, end + pieces[ray]);
    }
    pieces_.resize(end);
    for (std::size_t i = 0; i < first_.size(); ++i) {
      if (first_[i] == kNone) continue;
      const std::size_t row = i / counts_, count = i % counts_;
      const std::span<Piece> own(&pieces_[first_[i]], count);
      if (known != nullptr && known->has(row, count)) {
        std::ranges::copy(known->of(row, static_cast<std::uint16_t>(count)), own.begin());
      } else {
        cut(sonar, fan.elevation_rad[row], own);
      }
    }
  }

  std::span<const Piece> of(std::size_t ray, std::uint16_t count) const {
    return {&pieces_[first_[index(ray, count)]], count};
  }

 private:
  static constexpr std::uint32_t kNone = ~0u;

  std::size_t index(std::size_t ray, std::uint16_t count) const {
    return ray % rows_ * counts_ + count;
  }
  bool has(std::size_t row, std::size_t count) const {
    return count < counts_ && first_[row * counts_ + count] != kNone;
  }

  static void cut(const Sonar& sonar, double middle_rad, std::span<Piece> pieces) {
    const double step = elevation_step_rad(sonar), low = middle_rad - step / 2;
    const double part = step / static_cast<double>(pieces.size());
    double below = std::sin(low);
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      const double above = std::sin(low + static_cast<double>(i + 1) * part);
      const double elevation =
          pieces.size() == 1 ? middle_rad : low + (static_cast<double>(i) + 0.5) * part;
      // As cell_solid_angle_sr, whose sines two pieces share.
      pieces[i] = {elevation_part(elevation, sonar), azimuth_step_rad(sonar) * (above - below)};
      below = above;
    }
  }

  std::size_t rows_, counts_;
  std::vector<std::uint32_t> first_;  // [rows x counts], into pieces_
  std::vector<Piece> pieces_;
};

// What all beam cells share.
struct CutFan {
  const Fan& fan;
  const FanRaysMet& met;
  std::vector<std::uint16_t> pieces;  // [fan.size()]
  const Tracer& tracer;
  const Pose& sonar_in_world;
  const SurfaceScattering& scattering;
  FanDirections directions;
  CutRows rows;
  // The rays through pieces that were traced before, and their numbers. Empty: none were.
  std::vector<std::uint16_t> traced = {};
  std::vector<PieceHits> before = {};

  bool is_cut(std::size_t ray) const { return pieces[ray] > 1; }
  bool was_traced(std::size_t ray) const { return !traced.empty() && traced[ray] == pieces[ray]; }
};

// Calls visit(column, pieces of a cell) for the cells of a beam whose pieces have no rays yet.
template <class Visit>
void for_each_new_cell(const CutFan& cut, std::size_t beam, Visit&& visit) {
  const std::size_t rows = cut.fan.elevation_rad.size(), rays = cut.fan.rays_per_beam();
  for (std::size_t ray = beam * rays; ray < (beam + 1) * rays; ++ray) {
    if (!cut.is_cut(ray) || cut.was_traced(ray)) continue;
    const std::uint16_t count = cut.pieces[ray];
    visit(ray / rows, cut.rows.of(ray, count));
  }
}

// Buffers for the rays through the pieces of a beam.
struct PieceRays {
  std::vector<Vec3> direction;  // in the sonar's frame
  PieceHits met;
};

void trace_straight(const CutFan& cut, std::size_t beam, PieceRays& rays) {
  std::size_t count = 0;
  for_each_new_cell(cut, beam, [&](std::size_t, auto pieces) { count += pieces.size(); });
  rays.direction.resize(count);
  auto next = rays.direction.begin();
  for_each_new_cell(cut, beam, [&](std::size_t column, std::span<const Piece> pieces) {
    const FanDirections::Part& along = cut.directions.azimuth[column];
    for (const Piece& piece : pieces) {
      const FanDirections::Part& up = piece.elevation;
      *next++ = {up.cosine * along.cosine, up.cosine * along.sine, up.sine};
    }
  });
  rays.met.hits.resize(count);
  cut.tracer.first_hits(cut.sonar_in_world, rays.direction, cut.scattering.sonar.range_max_m,
                        rays.met.hits);
}

void trace_refracted(const CutFan& cut, std::size_t beam, PieceRays& rays) {
  PieceHits& met = rays.met;
  met = {};
  Fan column_fan{1, 1, 0, {0}, {}, {}};
  std::size_t last = beam * cut.fan.rays_azimuth;
  const auto trace_column = [&] {
    if (column_fan.elevation_rad.empty()) return;
    column_fan.azimuth_rad[0] = cut.fan.azimuth_rad[last];
    column_fan.rays_elevation = static_cast<int>(column_fan.elevation_rad.size());
    const FanHits found = trace_fan(cut.tracer, column_fan, cut.sonar_in_world,
                                    cut.scattering.sonar, cut.scattering.water, Workers(1));
    met.hits.insert(met.hits.end(), found.hits.begin(), found.hits.end());
    met.paths.insert(met.paths.end(), found.paths.begin(), found.paths.end());
    column_fan.elevation_rad.clear();
  };
  for_each_new_cell(cut, beam, [&](std::size_t column, std::span<const Piece> pieces) {
    if (column != last) trace_column();
    last = column;
    for (const Piece& piece : pieces) {
      column_fan.elevation_rad.push_back(piece.elevation.angle_rad);
    }
  });
  trace_column();
}

void trace_new_pieces(const CutFan& cut, std::size_t beam, PieceRays& rays) {
  if (cut.met.paths.empty()) {
    trace_straight(cut, beam, rays);
  } else {
    trace_refracted(cut, beam, rays);
  }
}

struct Echo {
  const Piece* piece;
  const Hit* hit;
  const RayPath* path;  // null where rays are straight
};

// A scatterer before its moments are known.
struct Sample {
  Echo echo;
  std::uint64_t key = 0;
  double solid_angle_sr = 0;
};

// The rays through the cut cells of one beam cell, column by column, and the echoes of the beam
// cell.
struct PieceWork : SectorWork {
  PieceRays rays;
  std::vector<Sample> samples;
  std::vector<Echo> echoes;
};

// Takes the rays through pieces in turn.
class RaysInTurn {
 public:
  explicit RaysInTurn(const PieceHits& met) : met_(met) {}
  Echo take(const Piece* piece) {
    const std::size_t at = next_++;
    return {piece, &met_.hits[at], met_.paths.empty() ? nullptr : &met_.paths[at]};
  }
  void skip(std::size_t count) { next_ += count; }

 private:
  const PieceHits& met_;
  std::size_t next_ = 0;
};

// The rays of a column from the lowest to the highest.
void take_column(const CutFan& cut, std::size_t column, RaysInTurn& recent, RaysInTurn& before,
                 std::vector<Sample>& samples) {
  samples.clear();
  const std::size_t rows = cut.fan.elevation_rad.size();
  const double width = cut.fan.relative_width_of(column / cut.fan.rays_azimuth);
  for (std::size_t ray = column * rows; ray < (column + 1) * rows; ++ray) {
    const bool was_traced = cut.was_traced(ray);
    if (!was_traced && !cut.traced.empty() && cut.traced[ray] > 1) before.skip(cut.traced[ray]);
    std::uint64_t number = 0;
    for (const Piece& piece : cut.rows.of(ray, cut.pieces[ray])) {
      const Echo echo = cut.is_cut(ray)
                            ? (was_traced ? before : recent).take(&piece)
                            : Echo{&piece, &cut.met.hits[ray],
                                   cut.met.paths.empty() ? nullptr : &cut.met.paths[ray]};
      samples.push_back({echo, number++ << 32 | ray, width * piece.solid_angle_sr});
    }
  }
}

// The midpoint rule errs by (h2^2 - h1^2)/24 f' where its step changes from h1 to h2. A twelfth of
// the difference between the weights on both sides removes this term.
void balance_steps(std::vector<Sample>& samples) {
  double taken = 0;
  for (std::size_t i = 0; i + 1 < samples.size(); ++i) {
    Sample &here = samples[i], &next = samples[i + 1];
    const double own = here.solid_angle_sr;
    here.solid_angle_sr += taken;
    taken = 0;
    if (here.echo.hit->instance != next.echo.hit->instance) continue;
    const double moved = (next.solid_angle_sr - own) / 12;
    here.solid_angle_sr += moved;
    taken = -moved;
  }
  if (!samples.empty()) samples.back().solid_angle_sr += taken;
}

void gather_echoes(const CutFan& cut, std::size_t beam, PieceWork& work) {
  work.order.clear();
  work.echoes.clear();
  work.moments.clear();
  static const PieceHits none;
  RaysInTurn recent(work.rays.met), before(cut.before.empty() ? none : cut.before[beam]);
  ScattererMoments moments;
  const std::size_t columns = cut.fan.rays_azimuth;
  for (std::size_t column = beam * columns; column < (beam + 1) * columns; ++column) {
    take_column(cut, column, recent, before, work.samples);
    if (!cut.scattering.sonar.rays_per_cell) balance_steps(work.samples);
    for (const auto& [echo, key, solid_angle_sr] : work.samples) {
      if (!surface_moments(cut.scattering, *echo.hit, solid_angle_sr, echo.path, moments)) continue;
      const double c = cut.scattering.water.sound_speed_m_s;
      work.order.push_back({two_way_delay_s(echo.hit->range_m, c), key,
                            static_cast<std::uint32_t>(work.echoes.size())});
      work.echoes.push_back(echo);
      work.moments.push_back(moments);
    }
  }
}

void add_sector(const CutFan& cut, std::size_t beam, PieceWork& work,
                std::vector<Scatterer>& scatterers) {
  trace_new_pieces(cut, beam, work.rays);
  gather_echoes(cut, beam, work);
  sort_keys(work.order);
  static constexpr Scatterer kBlank{};  // is copied in half the time of clearing a new one
  for (const SortKey& key : work.order) {
    const auto& [piece, hit, path] = work.echoes[key.index];
    const std::size_t column = (key.key & 0xffffffffu) / cut.fan.elevation_rad.size();
    set_surface_echo(cut.scattering,
                     FanDirections::of(cut.directions.azimuth[column], piece->elevation),
                     static_cast<std::uint32_t>(beam), key.key, *hit, work.moments[key.index], path,
                     scatterers.emplace_back(kBlank));
  }
}

void cut_finer(CutFan& cut, const ResolutionCell& cell, const Workers& workers) {
  cut.before.resize(static_cast<std::size_t>(cut.fan.beams));
  workers.for_each(cut.before.size(), [&](std::size_t beam) {
    PieceRays rays;
    trace_new_pieces(cut, beam, rays);
    cut.before[beam] = std::move(rays.met);
  });
  std::vector<std::uint16_t> finer = finer_pieces(
      cut.scattering, cell, {cut.fan, cut.met.hits, cut.sonar_in_world, cut.met.all_hits},
      cut.pieces, cut.before, workers);
  cut.traced = std::exchange(cut.pieces, std::move(finer));
  cut.rows = CutRows(cut.scattering.sonar, cut.fan, cut.pieces, &cut.rows);
}

}  // namespace

ScattererList adaptive_surface_scatterers(const Fan& fan, const FanRaysMet& met,
                                          const ResolutionCell& cell, const Tracer& tracer,
                                          const Pose& sonar_in_world,
                                          const SurfaceScattering& scattering,
                                          const Workers& workers) {
  const Sonar& sonar = scattering.sonar;
  std::vector<std::uint16_t> pieces =
      adaptive_pieces(scattering, cell, {fan, met.hits, sonar_in_world}, workers);
  CutRows rows(sonar, fan, pieces, nullptr);
  CutFan cut{fan,
             met,
             std::move(pieces),
             tracer,
             sonar_in_world,
             scattering,
             directions_of(fan, sonar),
             std::move(rows)};
  if (!sonar.rays_per_cell) cut_finer(cut, cell, workers);
  std::vector<std::uint32_t> most(static_cast<std::size_t>(fan.beams), 0);
  for (std::size_t ray = 0; ray < cut.pieces.size(); ++ray) {
    most[ray / fan.rays_per_beam()] +=
        cut.is_cut(ray) ? cut.pieces[ray] : is_usable(met.hits[ray], sonar);
  }
  return list_of_sectors<PieceWork>(
      most, workers, [&](std::size_t beam, PieceWork& work, std::vector<Scatterer>& scatterers) {
        add_sector(cut, beam, work, scatterers);
      });
}

}  // namespace ensonify
