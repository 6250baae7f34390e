#include "trace/adaptive.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "acoustics/pulse.h"
#include "core/error.h"
#include "trace/echo.h"

namespace ensonify {
namespace {

// How much the steps between rays may differ from what tangent planes tell, and the share of step_m
// that is asked for where they differ by more.
constexpr double kEvenness = 0.03, kUnevenShare = 0.55;
// Of the error, for equal steps; the rest is for their changes from cell to cell.
constexpr double kRippleShare = 0.75;

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

bool differ(const Hit& a, const Hit& b, const Sonar& sonar) {
  const bool meets = is_usable(a, sonar);
  return meets != is_usable(b, sonar) || (meets && a.instance != b.instance);
}

// The counts of pieces for the cells of a fan.
class CellCuts {
 public:
  CellCuts(const SurfaceScattering& scattering, const ResolutionCell& cell, const FanMet& met)
      : scattering_(scattering),
        sonar_(scattering.sonar),
        cell_(cell),
        met_(met),
        slants_(met.fan, met.sonar_in_world) {
    ENSONIFY_ASSERT(met.hits.size() == met.fan.size());
  }

  bool is_usable(std::size_t ray) const { return ensonify::is_usable(met_.hits[ray], sonar_); }

  // Of range, along the column of a ray.
  double length_m(std::size_t ray) const {
    return std::abs(slants_.at(ray, met_.hits[ray]).elevation_m) * elevation_step_rad(sonar_);
  }

  // So that a resolution cell holds this number of scatterers.
  std::uint16_t by_count(std::size_t ray, int scatterers) const {
    const std::size_t beam = ray / met_.fan.rays_per_beam();
    const ResolutionCell own{width_of_beam_rad(sonar_, met_.fan.beam_of(beam)), cell_.range_m};
    const double of_fan = scatterers_per_cell(sonar_, own, slants_.at(ray, met_.hits[ray]),
                                              met_.fan.relative_width_of(beam));
    return limited(scatterers / of_fan);
  }

  std::uint16_t fine(std::size_t ray) const { return by_count(ray, kFineScatterers); }

  // Cuts the cells of a column by the rule of adaptive_pieces.
  void cut_column(std::size_t column, std::vector<double>& length_m,
                  std::span<std::uint16_t> pieces) const {
    const std::size_t rows = met_.fan.elevation_rad.size(), begin = column * rows;
    length_m.assign(rows, 0);
    for (std::size_t e = 0; e < rows; ++e) {
      if (is_usable(begin + e)) length_m[e] = this->length_m(begin + e);
    }
    for (std::size_t e = 0; e < rows; ++e) {
      if (is_usable(begin + e)) pieces[begin + e] = first(begin, e, length_m);
    }
    // A ray that misses takes the cut of its neighbors in elevation, since a part of its cell may
    // still meet their surface.
    for (std::size_t e = 0; e < rows; ++e) {
      if (is_usable(begin + e)) continue;
      std::uint16_t& own = pieces[begin + e];
      if (e > 0 && is_usable(begin + e - 1)) own = std::max(own, pieces[begin + e - 1]);
      if (e + 1 < rows && is_usable(begin + e + 1)) own = std::max(own, pieces[begin + e + 1]);
    }
  }

  static std::uint16_t limited(double pieces) {
    return static_cast<std::uint16_t>(std::clamp(std::ceil(pieces), 1.0, double{kMostPieces}));
  }

 private:
  std::uint16_t first(std::size_t begin, std::size_t e, std::span<const double> length_m) const {
    const std::size_t ray = begin + e;
    if (sonar_.rays_per_cell) return by_count(ray, *sonar_.rays_per_cell);
    const CoherentModel model = material_at(scattering_, met_.hits[ray]).coherent;
    if (model == CoherentModel::rician) return fine(ray);
    const bool is_even = (e == 0 || fits(begin, e - 1, length_m)) &&
                         (e + 1 == length_m.size() || fits(begin, e, length_m));
    return limited(length_m[e] / (is_even ? cell_.step_m : kUnevenShare * cell_.step_m));
  }

  // Whether the tangent planes at the hits of row e and the next tell the range between them.
  bool fits(std::size_t begin, std::size_t e, std::span<const double> length_m) const {
    const Hit &below = met_.hits[begin + e], &above = met_.hits[begin + e + 1];
    if (differ(below, above, sonar_)) return true;
    const double told = (length_m[e] + length_m[e + 1]) / 2;
    const double between = std::abs(below.range_m - above.range_m);
    return std::abs(between - told) <= kEvenness * told;
  }

  const SurfaceScattering& scattering_;
  const Sonar& sonar_;
  const ResolutionCell& cell_;
  const FanMet& met_;
  FanSlants slants_;
};

// What consecutive rays of a column show of a cell.
struct CellLook {
  bool is_edge = false;
  double steps = 0;  // the longest one between rays on one instance, relative to step_m
};

// Looks at consecutive rays of the columns of a beam. `looks` are those of its rays.
class ColumnLooks {
 public:
  ColumnLooks(const Sonar& sonar, double step_m, std::span<CellLook> looks)
      : sonar_(sonar), step_m_(step_m), looks_(looks) {}

  void begin_column() { last_ = nullptr; }

  void add(std::size_t cell, const Hit& hit) {
    if (last_ != nullptr) compare(cell, hit);
    last_ = &hit;
    last_cell_ = cell;
  }

 private:
  void compare(std::size_t cell, const Hit& hit) {
    CellLook &before = looks_[last_cell_], &here = looks_[cell];
    if (differ(*last_, hit, sonar_)) {
      before.is_edge = here.is_edge = true;
    } else if (is_usable(hit, sonar_)) {
      const double steps = std::abs(hit.range_m - last_->range_m) / step_m_;
      before.steps = std::max(before.steps, steps);
      here.steps = std::max(here.steps, steps);
    }
  }

  const Sonar& sonar_;
  double step_m_;
  std::span<CellLook> looks_;
  const Hit* last_ = nullptr;
  std::size_t last_cell_ = 0;
};

// Whether a ray of the whole fan and that of an adjacent column meet different instances.
bool differs_beside(const FanMet& met, const Sonar& sonar, std::size_t place) {
  const std::size_t rows = met.fan.elevation_rad.size();
  const std::span<const Hit> whole = met.whole();
  return (place >= rows && differ(whole[place], whole[place - rows], sonar)) ||
         (place + rows < whole.size() && differ(whole[place], whole[place + rows], sonar));
}

// Whether a column beside that of a ray has an edge there. Of other groups, only hits are known.
bool has_edge_beside(const FanMet& met, const Sonar& sonar, std::span<const CellLook> looks,
                     std::size_t ray) {
  const std::size_t rows = met.fan.elevation_rad.size();
  if (met.all_hits.empty()) {
    return (ray >= rows && looks[ray - rows].is_edge) ||
           (ray + rows < looks.size() && looks[ray + rows].is_edge);
  }
  const std::span<const Hit> whole = met.whole();
  const auto is_edge = [&](std::size_t place) {
    const std::size_t row = place % rows;
    return differs_beside(met, sonar, place) ||
           (row > 0 && differ(whole[place], whole[place - 1], sonar)) ||
           (row + 1 < rows && differ(whole[place], whole[place + 1], sonar));
  };
  const std::size_t place = met.place(ray);
  return (place >= rows && is_edge(place - rows)) ||
         (place + rows < whole.size() && is_edge(place + rows));
}

std::vector<CellLook> looks_at_cells(const Sonar& sonar, const ResolutionCell& cell,
                                     const FanMet& met, std::span<const std::uint16_t> pieces,
                                     std::span<const PieceHits> first, const Workers& workers) {
  const std::size_t rows = met.fan.elevation_rad.size(), rays = met.fan.rays_per_beam();
  std::vector<CellLook> looks(met.hits.size());
  workers.for_each(first.size(), [&](std::size_t beam) {
    const std::size_t begin = beam * rays;
    ColumnLooks columns(sonar, cell.step_m, std::span(looks).subspan(begin, rays));
    const Hit* piece = first[beam].hits.data();
    for (std::size_t i = 0; i < rays; ++i) {
      const std::size_t ray = begin + i;
      if (i % rows == 0) columns.begin_column();
      if (pieces[ray] == 1) columns.add(i, met.hits[ray]);
      for (int k = 0; pieces[ray] > 1 && k < pieces[ray]; ++k) columns.add(i, *piece++);
      looks[ray].is_edge |= differs_beside(met, sonar, met.place(ray));
    }
  });
  return looks;
}

}  // namespace

ResolutionCell resolution_cell(const Sonar& sonar, const Water& water, int transform) {
  const double c = water.sound_speed_m_s, sample_m = c / (2 * sonar.bandwidth_hz);
  return {sonar.beam_width_rad, c * pulse_width_s(sonar, transform) / 2,
          sample_m * echo_step_samples(sonar, transform, kRippleShare * kLevelErrorDb),
          2 * sample_m};
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

double gapped_share(const SurfaceScattering& scattering, const ResolutionCell& cell,
                    const FanMet& met, std::span<const std::uint16_t> pieces) {
  const CellCuts cuts(scattering, cell, met);
  double all_m = 0, gapped_m = 0;
  for (std::size_t ray = 0; ray < met.hits.size(); ++ray) {
    if (!cuts.is_usable(ray)) continue;
    const double length_m = cuts.length_m(ray);
    const double passes_m = std::clamp(length_m, cell.range_m, scattering.sonar.range_max_m);
    all_m += passes_m;
    if (length_m > cell.gap_m * (pieces.empty() ? 1 : pieces[ray])) gapped_m += passes_m;
  }
  return all_m > 0 ? gapped_m / all_m : 0;
}

std::vector<std::uint16_t> adaptive_pieces(const SurfaceScattering& scattering,
                                           const ResolutionCell& cell, const FanMet& met,
                                           const Workers& workers) {
  const CellCuts cuts(scattering, cell, met);
  std::vector<std::uint16_t> pieces(met.hits.size(), 1);
  workers.for_each(static_cast<std::size_t>(met.fan.beams), [&](std::size_t beam) {
    std::vector<double> length_m;
    const std::size_t columns = met.fan.rays_azimuth;
    for (std::size_t column = beam * columns; column < (beam + 1) * columns; ++column) {
      cuts.cut_column(column, length_m, pieces);
    }
  });
  return pieces;
}

std::vector<std::uint16_t> finer_pieces(const SurfaceScattering& scattering,
                                        const ResolutionCell& cell, const FanMet& met,
                                        std::span<const std::uint16_t> pieces,
                                        std::span<const PieceHits> first, const Workers& workers) {
  const CellCuts cuts(scattering, cell, met);
  const std::vector<CellLook> looks =
      looks_at_cells(scattering.sonar, cell, met, pieces, first, workers);
  const std::size_t rows = met.fan.elevation_rad.size(), rays = met.fan.rays_per_beam();
  std::vector<std::uint16_t> finer(pieces.begin(), pieces.end());
  const auto fine_about = [&](std::size_t ray) {
    const std::size_t row = ray % rows;
    std::uint16_t most = 1;
    for (std::size_t at = ray - (row > 0); at <= ray + (row + 1 < rows); ++at) {
      if (cuts.is_usable(at)) most = std::max(most, cuts.fine(at));
    }
    return most;
  };
  workers.for_each(first.size(), [&](std::size_t beam) {
    for (std::size_t ray = beam * rays; ray < (beam + 1) * rays; ++ray) {
      const bool is_edge = looks[ray].is_edge || has_edge_beside(met, scattering.sonar, looks, ray);
      if (is_edge) {
        finer[ray] = std::max(finer[ray], fine_about(ray));
      } else if (looks[ray].steps > 1) {
        const double wanted = pieces[ray] * looks[ray].steps / kUnevenShare;
        const int most = 2 * std::max(fine_about(ray), pieces[ray]);
        finer[ray] = CellCuts::limited(std::min<double>(wanted, most));
      }
    }
  });
  return finer;
}

}  // namespace ensonify
