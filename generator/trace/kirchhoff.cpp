#include "trace/scatter.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "acoustics/pattern.h"
#include "acoustics/scattering.h"
#include "core/error.h"
#include "core/units.h"
#include "trace/echo.h"

namespace ensonify {
namespace {

// What a part's bend may add to its linear phase. Its first order is in the amplitude; 0.02 rad are
// left.
constexpr double kBend_rad = 0.2;
// Where cutting ends: for the phase, and for an edge. One that runs along a side of its parts, and
// so errs by as much in all of them, is found more closely.
constexpr double kSmallestSide_wavelengths = 0.25;
constexpr double kSmallestEdge_wavelengths = 1.0 / 8;
constexpr double kSmallestStraightEdge_wavelengths = 1.0 / 32;
// In units of c/b. A part is heard at one delay, with the sinc of the carrier: longer ones leave
// echoes in the middle of an oblique plate.
constexpr double kLongestRange_pulses = 1.0 / 24;

// A cell of the fan or a part of one, with rays through its corners, the middles of its sides and
// its middle.
struct Part {
  std::array<double, 3> azimuth_rad{}, elevation_rad{};  // low, middle, high
  std::array<std::array<Hit, 3>, 3> hits;                // [azimuth][elevation]
};

// What the parts of one sector share.
struct Sector {
  const Tracer& tracer;
  const Pose& pose;
  const SurfaceScattering& scattering;
  double wavelength_m = 0;
  double range_limit_m = 0;  // the longest that a part may be in range
  int beam = 0;
  std::uint64_t next_key = 0;
  std::vector<Scatterer> scatterers;
};

// The range over a part: linear in the angles, and what bends away from that.
struct Bend {
  double change_azimuth_m = 0, change_elevation_m = 0;  // across the part
  double azimuth_m = 0, elevation_m = 0;                // at the middles of the sides
  double twist_m = 0;   // at the corners, of the product of both angles
  double corner_m = 0;  // at the corners, the largest in all
};

bool is_mirror(const SurfaceScattering& scattering, const Hit& hit) {
  return hit.instance != 0 && material_at(scattering, hit).coherent == CoherentModel::kirchhoff;
}

// Where the material changes there is an edge, though the surface goes on.
bool same_surface(const Hit& a, const Hit& b) {
  return a.instance == b.instance && a.part == b.part;
}

bool any_mirror(std::span<const Material> materials) {
  return std::ranges::any_of(materials, [](const Material& material) {
    return material.coherent == CoherentModel::kirchhoff;
  });
}

Hit shoot(const Sector& sector, double azimuth_rad, double elevation_rad) {
  const Vec3 direction = unit_vector(azimuth_rad, elevation_rad);
  return sector.tracer.first_hit(
      {sector.pose.position_m, normalized(rotate(sector.pose.rotation, direction))},
      sector.scattering.sonar.range_max_m);
}

// The change of range from side to side, from as many of the two sides as lie on the middle's own
// surface.
double change_across(const Hit& low, const Hit& middle, const Hit& high) {
  const bool below = low.instance == middle.instance, above = high.instance == middle.instance;
  if (below && above) return high.range_m - low.range_m;
  if (above) return 2 * (high.range_m - middle.range_m);
  return below ? 2 * (middle.range_m - low.range_m) : 0;
}

// From the hits on the middle's own surface; what they do not tell is taken for none.
Bend bend_of(const Part& part) {
  const auto& hits = part.hits;
  const Hit& middle = hits[1][1];
  const auto same = [&](int a, int e) { return hits[a][e].instance == middle.instance; };
  const auto range = [&](int a, int e) { return hits[a][e].range_m; };
  Bend bend;
  bend.change_azimuth_m = change_across(hits[0][1], middle, hits[2][1]);
  bend.change_elevation_m = change_across(hits[1][0], middle, hits[1][2]);
  if (same(0, 1) && same(2, 1)) bend.azimuth_m = (range(0, 1) + range(2, 1)) / 2 - middle.range_m;
  if (same(1, 0) && same(1, 2)) {
    bend.elevation_m = (range(1, 0) + range(1, 2)) / 2 - middle.range_m;
  }
  if (same(0, 0) && same(0, 2) && same(2, 0) && same(2, 2)) {
    bend.twist_m = (range(0, 0) + range(2, 2) - range(0, 2) - range(2, 0)) / 4;
  }
  for (const int a : {0, 2}) {
    for (const int e : {0, 2}) {
      if (!same(a, e)) continue;
      const double linear =
          middle.range_m +
          ((a - 1) * bend.change_azimuth_m + (e - 1) * bend.change_elevation_m) / 2;
      bend.corner_m = std::max(bend.corner_m, std::abs(range(a, e) - linear));
    }
  }
  return bend;
}

enum class Cut { none, across_azimuth, across_elevation };

struct Want {
  bool azimuth = false, elevation = false;
};

// Where an edge runs through the part: between rays that are neighbours.
Want cuts_for_edges(const Part& part) {
  Want want;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 2; ++k) {
      want.azimuth |= !same_surface(part.hits[k][i], part.hits[k + 1][i]);
      want.elevation |= !same_surface(part.hits[i][k], part.hits[i][k + 1]);
    }
  }
  return want;
}

// Where the range bends or changes too much for one scatterer.
Want cuts_for_phase(const Part& part, const Sector& sector) {
  const Bend bend = bend_of(part);
  Want want{std::abs(bend.change_azimuth_m) > sector.range_limit_m,
            std::abs(bend.change_elevation_m) > sector.range_limit_m};
  const double in_azimuth = std::abs(bend.azimuth_m), in_elevation = std::abs(bend.elevation_m);
  const double worst = std::max({in_azimuth, in_elevation, bend.corner_m});
  if (4 * kPi / sector.wavelength_m * worst <= kBend_rad) return want;
  // What the sides do not explain of a corner's bend is a twist, which either cut lessens.
  const double twist = std::max(0.0, bend.corner_m - in_azimuth - in_elevation);
  want.azimuth |= in_azimuth + twist >= (in_elevation + twist) / 2;
  want.elevation |= in_elevation + twist >= (in_azimuth + twist) / 2;
  return want;
}

// The side to cut, the longer one where both want it; none where the part is done.
Cut cut_of(const Part& part, const Sector& sector) {
  double range = 0;
  for (const auto& column : part.hits) {
    for (const Hit& hit : column) range = std::max(range, hit.range_m);
  }
  const double width =
      range * std::cos(part.elevation_rad[1]) * (part.azimuth_rad[2] - part.azimuth_rad[0]);
  const double height = range * (part.elevation_rad[2] - part.elevation_rad[0]);
  const auto allowed = [&](Want want, double smallest_wavelengths) {
    const double smallest = smallest_wavelengths * sector.wavelength_m;
    return Want{want.azimuth && width > smallest, want.elevation && height > smallest};
  };
  const Want edge = cuts_for_edges(part);
  const bool straight = edge.azimuth != edge.elevation;
  Want want =
      allowed(edge, straight ? kSmallestStraightEdge_wavelengths : kSmallestEdge_wavelengths);
  if (is_mirror(sector.scattering, part.hits[1][1])) {
    const Want phase = allowed(cuts_for_phase(part, sector), kSmallestSide_wavelengths);
    want = {want.azimuth || phase.azimuth, want.elevation || phase.elevation};
  }
  if (want.azimuth && (!want.elevation || width >= height)) return Cut::across_azimuth;
  return want.elevation ? Cut::across_elevation : Cut::none;
}

// Means of x e^(-i g x), over i, and of x^2 e^(-i g x) over x in [-1, 1]. Below 1e-2 the series are
// exact to 1e-9; the quotients would lose their digits.
double first_moment(double g) {
  if (std::abs(g) < 1e-2) return -g / 3 * (1 - g * g / 10);
  return (std::cos(g) - std::sin(g) / g) / g;
}
double second_moment(double g) {
  if (std::abs(g) < 1e-2) return 1.0 / 3 - g * g / 10;
  return std::sin(g) / g + 2 * (std::cos(g) - std::sin(g) / g) / (g * g);
}

// What the bend adds to sinc . sinc, to first order: the mean over the part of
// -i 2k (azimuth x^2 + elevation y^2 + twist x y) e^(-i (g_x x + g_y y)), x and y in [-1, 1].
std::complex<double> bend_factor(const Bend& bend, double wavelength_m) {
  const double two_k = 4 * kPi / wavelength_m;
  const double gx = two_k * bend.change_azimuth_m / 2, gy = two_k * bend.change_elevation_m / 2;
  // Beyond what is cut for, at limbs and creases, a first order says nothing.
  const auto phase = [&](double range_m) {
    return std::clamp(two_k * range_m, -kBend_rad, kBend_rad);
  };
  const double sum = phase(bend.azimuth_m) * second_moment(gx) * sinc(gy / kPi) +
                     phase(bend.elevation_m) * second_moment(gy) * sinc(gx / kPi) -
                     phase(bend.twist_m) * first_moment(gx) * first_moment(gy);
  return {0, -sum};
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

void add_scatterer(const Part& part, Sector& sector) {
  const Hit& middle = part.hits[1][1];
  const SurfaceScattering& scattering = sector.scattering;
  if (!is_mirror(scattering, middle) || !in_range(middle.range_m, scattering.sonar)) return;
  const std::complex<double> amplitude = amplitude_of(part, sector);
  if (!std::isfinite(std::norm(amplitude))) return;
  Scatterer s = echo_from(middle.range_m, part.azimuth_rad[1], part.elevation_rad[1], sector.beam,
                          scattering.sonar, scattering.water);
  s.mean = std::complex<float>(amplitude);
  s.cos_incidence = middle.cos_incidence;
  s.key = sector.next_key++;
  s.instance = middle.instance;
  sector.scatterers.push_back(s);
}

// One half of a part: 0 low, 1 high.
Part half_of(const Part& part, Cut cut, int half, const Sector& sector) {
  const bool in_azimuth = cut == Cut::across_azimuth;
  Part result = part;
  auto& angle = in_azimuth ? result.azimuth_rad : result.elevation_rad;
  const double low = angle[half], high = angle[half + 1];
  angle = {low, (low + high) / 2, high};
  for (int i = 0; i < 3; ++i) {
    const auto hit = [&](Part& p, int k) -> Hit& {
      return in_azimuth ? p.hits[k][i] : p.hits[i][k];
    };
    // The outer ones first: both are the parent's, and one of them stays where it was.
    const Hit first = hit(result, half), last = hit(result, half + 1);
    hit(result, 0) = first;
    hit(result, 2) = last;
    hit(result, 1) = in_azimuth ? shoot(sector, angle[1], part.elevation_rad[i])
                                : shoot(sector, part.azimuth_rad[i], angle[1]);
  }
  return result;
}

void divide(const Part& part, Sector& sector) {
  const bool any = std::any_of(part.hits.begin(), part.hits.end(), [&](const auto& column) {
    return std::any_of(column.begin(), column.end(),
                       [&](const Hit& hit) { return is_mirror(sector.scattering, hit); });
  });
  if (!any) return;
  const Cut cut = cut_of(part, sector);
  if (cut == Cut::none) return add_scatterer(part, sector);
  for (const int half : {0, 1}) divide(half_of(part, cut, half, sector), sector);
}

// Whether the cell's own ray, or that of one of the eight around it, meets a mirror.
bool is_candidate(const Fan& fan, std::span<const Hit> hits, std::size_t column, int elevation,
                  const SurfaceScattering& scattering) {
  const std::size_t last_column = std::min(column + 1, fan.azimuth_rad.size() - 1);
  for (std::size_t c = column == 0 ? 0 : column - 1; c <= last_column; ++c) {
    for (int e = std::max(elevation - 1, 0); e <= std::min(elevation + 1, fan.rays_elevation - 1);
         ++e) {
      if (is_mirror(scattering, hits[c * fan.rays_elevation + e])) return true;
    }
  }
  return false;
}

Part cell_of(double azimuth_rad, double azimuth_step_rad, double elevation_rad,
             double elevation_step_rad, const Sector& sector) {
  Part part;
  for (int i = 0; i < 3; ++i) {
    part.azimuth_rad[i] = azimuth_rad + (i - 1) * azimuth_step_rad / 2;
    part.elevation_rad[i] = elevation_rad + (i - 1) * elevation_step_rad / 2;
  }
  for (int a = 0; a < 3; ++a) {
    for (int e = 0; e < 3; ++e) {
      part.hits[a][e] = shoot(sector, part.azimuth_rad[a], part.elevation_rad[e]);
    }
  }
  return part;
}

}  // namespace

std::vector<Scatterer> kirchhoff_scatterers(const Fan& fan, std::span<const Hit> hits,
                                            const Tracer& tracer, const Pose& sonar_in_world,
                                            const SurfaceScattering& scattering,
                                            const Workers& workers) {
  ENSONIFY_ASSERT(hits.size() == fan.size());
  if (!any_mirror(scattering.material) &&
      std::ranges::none_of(scattering.part_material, any_mirror)) {
    return {};
  }
  const Sonar& sonar = scattering.sonar;
  const double azimuth_step = sonar.beam_spacing_rad / fan.rays_azimuth;
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
    for (int a = 0; a < fan.rays_azimuth; ++a) {
      const std::size_t column = beam * fan.rays_azimuth + a;
      for (int e = 0; e < fan.rays_elevation; ++e) {
        if (!is_candidate(fan, hits, column, e, scattering)) continue;
        // Beside the rays' keys and the targets'; nothing is drawn, they only settle ties.
        sector.next_key =
            (std::uint64_t{1} << 62) | (std::uint64_t{column * fan.rays_elevation + e} << 28);
        divide(cell_of(fan.azimuth_rad[column], azimuth_step, fan.elevation_rad[e], elevation_step,
                       sector),
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
