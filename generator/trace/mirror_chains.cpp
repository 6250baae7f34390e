#include "trace/mirror_chains.h"

#include <algorithm>
#include <cmath>

#include "acoustics/scattering.h"
#include "trace/cell_cutting.h"
#include "trace/volume.h"

namespace ensonify {

// Normals whose cosine is below this belong to different faces of a body.
static constexpr double kSameFace = 0.9;

// A ray over a chain of specular reflectors and walls, and straight back to the sonar.
struct ChainSample {
  double range_m = 0;  // half of the path
  int steps = 0;       // 0: no chain
  std::array<Hit, kMostSteps> hit;
  Vec3 end_m;  // from the sonar
  double reflection = 0, obliquity = 0, leaving_sine = 0;
  LegEnd out, back;
  WallEvents walls;
};

static bool same_body(const ChainSample& a, const ChainSample& b) {
  if (a.steps != b.steps) return false;
  for (int i = 0; i < a.steps; ++i) {
    if (a.hit[i].instance != b.hit[i].instance || a.hit[i].own_part != b.hit[i].own_part ||
        std::abs(dot(a.hit[i].normal, b.hit[i].normal)) < kSameFace) {
      return false;
    }
  }
  return true;
}
static bool same_surface(const ChainSample& a, const ChainSample& b) { return same_body(a, b); }

namespace {

using ChainPart = CellPart<ChainSample>;

// Limits of the sine of the angle between the ray that leaves the last reflector and the direction
// to the sonar. A part counts fully up to the first limit and not at all beyond the second, where
// only the edges of a chain contribute. Curved reflectors need a smooth transition: a sharp limit
// would be an edge whose echo is as strong as that of the reflector.
constexpr double kLeavingSine = 0.15, kLargestLeavingSine = 0.5;

double leaving_weight(double sine) {
  if (sine <= kLeavingSine) return 1;
  const double part = (sine - kLeavingSine) / (kLargestLeavingSine - kLeavingSine);
  return 0.5 + 0.5 * std::cos(kPi * std::min(part, 1.0));
}

// Keeps the keys apart from those of rays, targets and kirchhoff_scatterers.
constexpr std::uint64_t kChainKey = std::uint64_t{1} << 62 | std::uint64_t{1} << 61;

// Connects the last surface of a walk, which reflects, to the sonar.
ChainSample sample_of(const BounceContext& context, const MirrorWalk& walk) {
  ChainSample sample;
  const WalkStep& last = walk.last();
  if (last.reflection == 0) return sample;
  sample.reflection = 1;
  for (int i = 0; i < walk.steps; ++i) {
    const WalkStep& at = walk.step[i];
    const bool reflected = i + 1 == walk.steps || walk.turned(i);
    if (at.wall != nullptr && !sample.walls.add(at.event(reflected))) return sample;
    sample.hit[i] = at.hit;
    if (reflected) sample.reflection *= at.reflection;
  }
  const std::optional<LegEnd> back = connect(context, last, sample.walls);
  if (!back) return sample;
  sample.steps = walk.steps;
  sample.end_m = last.point_m;
  sample.out.length_m = last.length_m;
  sample.out.extinction_db = last.extinction_db;
  sample.out.cos_incidence = last.hit.cos_incidence;
  sample.back = *back;
  sample.range_m = (last.length_m + back->length_m) / 2;
  constexpr double kMostOblique = 2;
  sample.obliquity = std::min(
      (1 + back->cos_incidence / std::max(sample.out.cos_incidence, 1e-6)) / 2, kMostOblique);
  const Vec3 leaving = reflected_direction(last);
  sample.leaving_sine =
      dot(leaving, back->direction) < 0 ? length(cross(leaving, back->direction)) : 1;
  return sample;
}

// What the parts of one beam cell share, for chains of one code.
struct ChainSector {
  const BounceContext& context;
  int steps = 2;
  unsigned turns = 0;  // of all steps, including the last
  double wavelength_m = 0, range_limit_m = 0;
  std::uint32_t beam = 0;
  std::uint64_t next_key = 0;
  std::vector<Scatterer> scatterers;

  bool is_mirror(const ChainSample& sample) const {
    return sample.steps > 0 && sample.leaving_sine < kLargestLeavingSine;
  }
  ChainSample shoot(double azimuth_rad, double elevation_rad) const;
  void add(const ChainPart& part);
};

ChainSample ChainSector::shoot(double azimuth_rad, double elevation_rad) const {
  const Vec3 direction = context.to_world(azimuth_rad, elevation_rad);
  const Hit hit = context.ping.tracer.first_hit({context.ping.sonar_in_world.position_m, direction},
                                                context.ping.scattering.sonar.range_max_m);
  if (hit.instance == 0) return {};
  const MirrorWalk walk = follow_turns(context, direction, hit, turns, steps);
  return walk.steps == steps ? sample_of(context, walk) : ChainSample{};
}

// The cross-section of the part's ray tube at the last reflector, from differences between
// positions on those sides that belong to the chain of the middle.
double tube_area_m2(const ChainPart& part) {
  const auto across = [&](const ChainSample& low, const ChainSample& high) {
    const ChainSample& middle = part.hits[1][1];
    const bool below = same_body(low, middle), above = same_body(high, middle);
    if (below && above) return high.end_m - low.end_m;
    if (above) return 2 * (high.end_m - middle.end_m);
    return below ? 2 * (middle.end_m - low.end_m) : Vec3{};
  };
  const Vec3 in_azimuth = across(part.hits[0][1], part.hits[2][1]);
  const Vec3 in_elevation = across(part.hits[1][0], part.hits[1][2]);
  const ChainSample& middle = part.hits[1][1];
  const Hit& last = middle.hit[middle.steps - 1];
  // The area on the surface, projected across the ray.
  return std::abs(dot(cross(in_azimuth, in_elevation), last.normal)) * middle.out.cos_incidence;
}

void ChainSector::add(const ChainPart& part) {
  const ChainSample& middle = part.hits[1][1];
  const SurfaceScattering& scattering = context.ping.scattering;
  if (!is_mirror(middle)) return;
  LegEnd out = middle.out;
  out.azimuth_rad = part.azimuth_rad[1];
  out.elevation_rad = part.elevation_rad[1];
  std::optional<Scatterer> s = echo_of(out, middle.back, scattering.sonar, scattering.water);
  if (!s) return;
  const double solid_angle = cell_solid_angle_sr(part.azimuth_rad[2] - part.azimuth_rad[0],
                                                 part.elevation_rad[0], part.elevation_rad[2]);
  const Bend bend = bend_of(part);
  const std::complex<double> sum = sinc(2 * bend.change_azimuth_m / wavelength_m) *
                                       sinc(2 * bend.change_elevation_m / wavelength_m) +
                                   bend_factor(bend, wavelength_m);
  const double size = middle.reflection * middle.obliquity * leaving_weight(middle.leaving_sine) *
                      out.length_m / wavelength_m * std::sqrt(solid_angle * tube_area_m2(part));
  s->mean = std::complex<float>(std::complex<double>(0, size) * sum);
  if (!std::isfinite(std::norm(s->mean)) || s->mean == 0.0f) return;
  s->position_m = context.to_sonar(middle.end_m);
  s->key = next_key++;
  s->instance = middle.hit[steps - 1].instance;
  const int mirrors = std::popcount(turns);
  s->path = path_of_kinds(mirrors, (1u << mirrors) - 1);
  int others = 0;
  for (int i = 0; i + 1 < steps; ++i) {
    if ((turns >> i & 1u) == 0) continue;
    s->via[others++] = static_cast<std::uint16_t>(middle.hit[i].instance);
  }
  add_with_walls(*s, middle.walls, scattering.sonar, scattering.water, scatterers);
}

// The bits of the cell's own ray and the eight around it.
ComesBack around(const Fan& fan, std::span<const ComesBack> found, std::size_t column,
                 int elevation) {
  ComesBack any = 0;
  const std::size_t last_column = std::min(column + 1, fan.azimuth_rad.size() - 1);
  for (std::size_t c = column == 0 ? 0 : column - 1; c <= last_column; ++c) {
    for (int e = std::max(elevation - 1, 0); e <= std::min(elevation + 1, fan.rays_elevation - 1);
         ++e) {
      any |= found[c * fan.rays_elevation + e];
    }
  }
  return any;
}

void add_chains(const BounceContext& context, const Fan& fan, std::span<const ComesBack> found,
                std::size_t beam, std::vector<Scatterer>& all) {
  const Sonar& sonar = context.ping.scattering.sonar;
  const double azimuth_step = cell_width_rad(sonar, fan.beam_of(beam)) / fan.rays_azimuth;
  const double elevation_step = sonar.elevation_fan_rad / fan.rays_elevation;
  const double range_limit_m =
      kLongestRange_pulses * context.ping.scattering.water.sound_speed_m_s / sonar.bandwidth_hz;
  for (int a = 0; a < fan.rays_azimuth; ++a) {
    const std::size_t column = beam * fan.rays_azimuth + a;
    for (int e = 0; e < fan.rays_elevation; ++e) {
      const ComesBack chains = around(fan, found, column, e);
      if (chains.none()) continue;
      for (unsigned code = 0; code < chains.size(); ++code) {
        if (!chains[code]) continue;
        const std::uint64_t cell = column * fan.rays_elevation + e;
        const int steps = static_cast<int>(std::bit_width(code)) - 1;
        ChainSector sector{context,
                           steps,
                           code ^ 1u << steps,
                           context.wavelength_m,
                           range_limit_m,
                           static_cast<std::uint32_t>(fan.beam_of(beam)),
                           kChainKey | cell << 28 | std::uint64_t{code} << 20,
                           {}};
        divide(cell_of<ChainSample>(fan.azimuth_rad[column], azimuth_step, fan.elevation_rad[e],
                                    elevation_step, sector),
               sector);
        all.insert(all.end(), sector.scatterers.begin(), sector.scatterers.end());
      }
    }
  }
}

}  // namespace

double BounceContext::piece_extinction_db(Vec3 from_m, Vec3 direction, double piece_m) const {
  if (!volumes_attenuate) return 0;
  DensityColumn column;
  return extinction_db(ping.volumes, {ping.sonar_in_world.position_m + from_m, direction},
                       extinction_step_m, piece_m, column);
}

WalkStep BounceContext::step(const WalkStep& from, Vec3 direction, const Hit& hit) const {
  WalkStep step;
  step.direction = direction;
  step.hit = hit;
  step.point_m = from.point_m + hit.range_m * direction;
  step.length_m = from.length_m + hit.range_m;
  step.normal = dot(hit.normal, direction) > 0 ? -hit.normal : hit.normal;
  step.extinction_db =
      from.extinction_db + piece_extinction_db(from.point_m, direction, hit.range_m);
  const Material& m = material(hit);
  if (m.coherent == CoherentModel::kirchhoff) {
    step.reflection =
        coherent_reflection(m.reflection, m.roughness_rms_m, wavelength_m, hit.cos_incidence);
  }
  step.wall = wall_at(ping.scattering, hit);
  return step;
}

std::optional<WalkStep> BounceContext::next(const WalkStep& from, Vec3 direction) const {
  const Hit hit = hit_after(ping.tracer, ping.sonar_in_world.position_m + from.point_m, direction,
                            length_max_m - from.length_m, true);
  if (hit.instance == 0 || !std::isfinite(hit.range_m) || !(hit.cos_incidence > 0)) {
    return std::nullopt;
  }
  return step(from, direction, hit);
}

BounceContext bounce_context(const BouncePing& ping) {
  const SurfaceScattering& scattering = ping.scattering;
  const double c = scattering.water.sound_speed_m_s;
  BounceContext context{ping, c / scattering.sonar.frequency_hz, 2 * scattering.sonar.range_max_m,
                        c / (4 * scattering.sonar.bandwidth_hz)};
  context.volumes_attenuate = std::ranges::any_of(
      ping.volumes, [](const Volume& volume) { return volume.extinction_db_m > 0; });
  return context;
}

bool walk_on(const BounceContext& context, MirrorWalk& walk, bool reflected) {
  const WalkStep& last = walk.last();
  const Vec3 direction = reflected ? normalized(reflected_direction(last)) : last.direction;
  const std::optional<WalkStep> next = context.next(last, direction);
  if (!next) return false;
  if (reflected) walk.turns |= 1u << (walk.steps - 1);
  walk.step[walk.steps++] = *next;
  return true;
}

MirrorWalk follow_turns(const BounceContext& context, Vec3 direction, const Hit& first,
                        unsigned turns, int steps) {
  MirrorWalk walk;
  walk.step[walk.steps++] = context.step({}, direction, first);
  while (walk.steps < steps) {
    const WalkStep& last = walk.last();
    const bool reflected = (turns >> (walk.steps - 1) & 1u) != 0;
    if (reflected ? last.reflection == 0 : !last.lets_through()) return walk;
    if (!walk_on(context, walk, reflected)) return walk;
  }
  return walk;
}

double spreading_per_m2(const BounceContext& context, double azimuth_rad, double elevation_rad,
                        const MirrorWalk& walk, int surface) {
  constexpr double kBeside_rad = 1e-4;
  const WalkStep& end = walk.step[surface];
  const double flat = 1 / (end.length_m * end.length_m);
  std::array<Vec3, 2> moved;
  for (int i = 0; i < 2; ++i) {
    const Vec3 direction = normalized(
        rotate(context.ping.sonar_in_world.rotation,
               unit_vector(azimuth_rad + (i == 0 ? kBeside_rad / std::cos(elevation_rad) : 0),
                           elevation_rad + (i == 1 ? kBeside_rad : 0))));
    const Hit hit = context.ping.tracer.first_hit(
        {context.ping.sonar_in_world.position_m, direction}, context.length_max_m);
    if (hit.instance == 0) return flat;
    const MirrorWalk beside = follow_turns(context, direction, hit, walk.turns, surface + 1);
    if (beside.steps <= surface) return flat;
    for (int k = 0; k <= surface; ++k) {
      const WalkStep &a = beside.step[k], &b = walk.step[k];
      if (a.hit.instance != b.hit.instance || dot(a.normal, b.normal) < kSameFace) return flat;
    }
    moved[i] = beside.step[surface].point_m - end.point_m;
  }
  const double area = std::abs(dot(cross(moved[0], moved[1]), end.direction));
  const double most = 1 / (context.wavelength_m * std::max(end.hit.range_m, context.wavelength_m));
  return std::min(kBeside_rad * kBeside_rad / area, most);
}

// Follows a piece of a path through walls to a point `piece_m` away. Returns false if anything else
// blocks the piece.
static bool passes(const BounceContext& context, const WalkStep& from, Vec3 direction,
                   double piece_m, WallEvents& walls) {
  WalkStep at = from;
  double left_m = piece_m;
  while (true) {
    const Hit hit =
        hit_after(context.ping.tracer, context.ping.sonar_in_world.position_m + at.point_m,
                  direction, left_m, true);
    if (hit.instance == 0 || hit.range_m >= left_m * (1 - kOnSurface)) return true;
    const WalkStep wall = context.step(at, direction, hit);
    if (!wall.lets_through() || !walls.add(wall.event(false))) return false;
    left_m -= hit.range_m;
    at = wall;
  }
}

std::optional<LegEnd> connect(const BounceContext& context, const WalkStep& from,
                              WallEvents& walls) {
  LegEnd back;
  back.point_m = from.point_m;
  back.length_m = length(from.point_m);
  if (!(back.length_m > 0) || from.length_m + back.length_m > context.length_max_m) {
    return std::nullopt;
  }
  back.direction = (1 / back.length_m) * from.point_m;
  back.cos_incidence = std::min(-dot(back.direction, from.normal), 1.0);
  if (!(back.cos_incidence > 0)) return std::nullopt;
  if (!set_direction(context.ping.scattering.sonar, context.to_sonar(from.point_m), back)) {
    return std::nullopt;
  }
  if (!passes(context, from, -back.direction, back.length_m, walls)) return std::nullopt;
  back.extinction_db = context.piece_extinction_db(from.point_m, -back.direction, back.length_m);
  return back;
}

bool comes_back(const BounceContext& context, const MirrorWalk& walk) {
  if (walk.last().reflection == 0 || walk.steps < 2) return false;
  const ChainSample sample = sample_of(context, walk);
  return sample.steps > 0 && sample.leaving_sine < kLargestLeavingSine;
}

std::vector<Scatterer> chain_scatterers(const BounceContext& context, const Fan& fan,
                                        std::span<const ComesBack> found, const Workers& workers) {
  std::vector<std::vector<Scatterer>> by_beam(fan.beams);
  workers.for_each(fan.beams,
                   [&](std::size_t beam) { add_chains(context, fan, found, beam, by_beam[beam]); });
  std::vector<Scatterer> all;
  append(by_beam, all);
  return all;
}

}  // namespace ensonify
