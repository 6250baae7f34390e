#include "trace/bounces.h"

#include <algorithm>
#include <cmath>

#include "acoustics/scattering.h"
#include "core/error.h"
#include "core/random.h"
#include "trace/mirror_chains.h"

namespace ensonify {
namespace {

// Keeps the keys apart from those of rays, targets and kirchhoff_scatterers.
constexpr std::uint64_t kBounceKey = std::uint64_t{1} << 61;
constexpr int kKeysOfRay = 8;  // bits for the echoes of a ray, and the first bit of those beyond
constexpr int kMoreKeys = 50;
// A sampled direction is followed with the probability kFollowed times its share of the energy,
// limited to [kLeastFollowed, 1].
constexpr double kLeastFollowed = 1.0 / 8, kFollowed = 4;
constexpr double kLeastCosine = 1e-6;

bool scatters(const Material& material, const Hit& hit) {
  return hit.reflectivity > 0 &&
         (states_strength(material.law) || material.reflectivity > 0);
}

// A path from the sonar, as far as it has been followed.
struct Travel {
  WalkStep at;         // the surface that it has reached
  double energy = 0;   // W of bounced_off_surfaces
  int surfaces = 1;    // reached so far, including `at`
  unsigned kinds = 0;  // of the surfaces before `at`
  std::array<std::uint32_t, kMostSurfaces> instance{};
  WallEvents walls;
  // The first surface that scattered the sound, counted from 1; 0: none yet.
  int first_scatterer = 0;
  Vec3 first_point_m;
  double first_length_m = 0;

  void reach(const WalkStep& step) {
    at = step;
    instance[surfaces++] = step.hit.instance;
  }
  // A wall that the path passes through does not count as a surface; the next surface takes its
  // place.
  void pass_to(const WalkStep& step) {
    at = step;
    instance[surfaces - 1] = step.hit.instance;
  }
  // The surface that the path has reached scatters the sound.
  void scatter() {
    if (first_scatterer != 0) return;
    first_scatterer = surfaces;
    first_point_m = at.point_m;
    first_length_m = at.length_m;
  }
};

// What the echoes of one ray of the fan share.
struct FanRay {
  std::size_t index = 0;
  std::uint32_t beam = 0;
  double azimuth_rad = 0, elevation_rad = 0, solid_angle_sr = 0;
};

class RayEchoes {
 public:
  RayEchoes(const BounceContext& context, const FanRay& ray, std::vector<Scatterer>& scatterers)
      : context_(context), ray_(ray), scatterers_(scatterers) {}

  // Adds the echoes of all paths whose specular reflections at the start are those of a walk.
  void follow(const MirrorWalk& walk);

 private:
  std::optional<Travel> travel_along(const MirrorWalk& walk) const;
  int most() const { return context_.ping.bounces + 1; }
  void hear(Travel travel);
  void hear_over_same_mirrors(Travel travel, double spreading_per_m2);
  void scatter_on(Travel travel);
  enum class Turn { reflected, scattered, passed };
  std::optional<Turn> choose_direction(Travel& travel, Vec3& direction);
  LegEnd sent(double length_m) const;
  std::optional<Scatterer> echo(const Travel& travel, const LegEnd& out, const LegEnd& back,
                                double energy, bool reversed) const;
  void add(const Scatterer& echo, const WallEvents& walls) {
    add_with_walls(echo, walls, context_.ping.scattering.sonar, context_.ping.scattering.water,
                   scatterers_);
  }
  double bistatic(const WalkStep& at, double cos_scattering) const;

  const BounceContext& context_;
  const FanRay& ray_;
  std::vector<Scatterer>& scatterers_;
  std::uint64_t next_key_ = 0;
  std::uint32_t next_draw_ = 0;
};

double RayEchoes::bistatic(const WalkStep& at, double cos_scattering) const {
  return at.hit.reflectivity *
         bistatic_strength(context_.material(at.hit), at.hit.cos_incidence, cos_scattering);
}

// The end of a leg in the direction of the ray.
LegEnd RayEchoes::sent(double length_m) const {
  LegEnd end;
  end.length_m = length_m;
  end.azimuth_rad = ray_.azimuth_rad;
  end.elevation_rad = ray_.elevation_rad;
  end.beam = ray_.beam;
  return end;
}

// `energy` includes all spreading. A Scatterer has an amplitude in m and a gain in 1/m^2, of which
// only the product matters. The lengths of `out` and `back` add up to the path, and that of `back`
// reaches to the last surface that scattered the sound.
std::optional<Scatterer> RayEchoes::echo(const Travel& travel, const LegEnd& out,
                                         const LegEnd& back, double energy, bool reversed) const {
  if (!(energy > 0) || !std::isfinite(energy)) return std::nullopt;
  const SurfaceScattering& scattering = context_.ping.scattering;
  std::optional<Scatterer> s = echo_of(out, back, scattering.sonar, scattering.water);
  if (!s) return std::nullopt;
  s->standard_deviation = static_cast<float>(std::sqrt(energy) * out.length_m * back.length_m);
  s->cos_incidence = travel.at.hit.cos_incidence;
  s->position_m = context_.to_sonar(reversed ? travel.first_point_m : travel.at.point_m);
  s->key = kBounceKey | std::uint64_t{ray_.index} << kKeysOfRay |
           (next_key_ & ((1u << kKeysOfRay) - 1)) | next_key_ >> kKeysOfRay << kMoreKeys;
  const int last = reversed ? travel.first_scatterer - 1 : travel.surfaces - 1;
  s->instance = travel.instance[last];
  unsigned kinds = 0;
  int others = 0;
  for (int i = 0; i < travel.surfaces; ++i) {
    const int surface = reversed ? travel.surfaces - 1 - i : i;
    kinds |= (travel.kinds >> surface & 1u) << i;
    if (surface != last) s->via[others++] = static_cast<std::uint16_t>(travel.instance[surface]);
  }
  s->path = path_of_kinds(travel.surfaces, kinds);
  return s;
}

// Connects a surface that scatters to the sonar, and adds both directions of the path. If the path
// goes straight out and back through walls, both directions are the same.
void RayEchoes::hear(Travel travel) {
  const int passed_out = travel.walls.passed;
  const std::optional<LegEnd> back = connect(context_, travel.at, travel.walls);
  if (!back) return;
  const bool straight = travel.surfaces == 1;
  // A ray of the fan does not find a path that begins with more walls.
  const bool from_both_ends =
      travel.first_scatterer == 1 && travel.walls.passed - passed_out <= kMostPassesOut;
  const double energy = travel.energy * bistatic(travel.at, back->cos_incidence) /
                        (travel.at.hit.cos_incidence * back->length_m * back->length_m) *
                        (from_both_ends ? 0.5 : 1);
  travel.scatter();
  LegEnd out = sent(travel.at.length_m);
  out.extinction_db = travel.at.extinction_db;
  std::optional<Scatterer> one = echo(travel, out, *back, energy, false);
  // The other direction: the same path, received over the piece from its first scatterer.
  LegEnd first = sent(travel.first_length_m), rest = *back;
  first.extinction_db = out.extinction_db;
  rest.length_m = travel.at.length_m + back->length_m - travel.first_length_m;
  std::optional<Scatterer> other;
  if (!straight) other = echo(travel, rest, first, energy, true);
  if (one && other && back->beam == ray_.beam && context_.ping.ways_as_one) {
    one->gain += other->gain;
    other.reset();
  }
  if (one) add(*one, travel.walls);
  if (other) add(*other, travel.walls);
  ++next_key_;
}

// Adds the path over specular reflectors to a surface that scatters, and back over the same ones.
void RayEchoes::hear_over_same_mirrors(Travel travel, double spreading_per_m2) {
  const int mirrors = travel.surfaces - 1;
  const double cosine = travel.at.hit.cos_incidence;
  const double reflected = travel.energy / ray_.solid_angle_sr;  // R^2 of all specular reflectors
  const double energy =
      travel.energy * reflected * bistatic(travel.at, cosine) / cosine * spreading_per_m2;
  if (!travel.walls.add(WallEvents(travel.walls))) return;
  travel.scatter();
  travel.surfaces = 2 * mirrors + 1;
  for (int i = 0; i < mirrors; ++i) {
    travel.kinds |= 1u << (travel.surfaces - 1 - i);
    travel.instance[travel.surfaces - 1 - i] = travel.instance[i];
  }
  LegEnd leg = sent(travel.at.length_m);
  leg.extinction_db = travel.at.extinction_db;
  // The label is the surface that scatters, as in a reversed path.
  if (const auto s = echo(travel, leg, leg, energy, true)) add(*s, travel.walls);
  ++next_key_;
}

// Chooses the next direction, which is specular, sampled or straight through a wall, and updates
// the energy. Returns none if the path ends here.
std::optional<RayEchoes::Turn> RayEchoes::choose_direction(Travel& travel, Vec3& direction) {
  const WalkStep& at = travel.at;
  const Material& material = context_.material(at.hit);
  const Philox4 words =
      random_words(context_.ping.key, context_.ping.ping, ray_.index, next_draw_++);
  const double incidence = at.hit.cos_incidence;
  const bool may_turn = travel.surfaces < most();
  // After its first scattering, a path continues in only one of these directions, chosen by energy.
  const bool one_way = travel.first_scatterer > 0;
  const WallEvent wall = at.event(false);
  const double by_wall = at.wall != nullptr ? at.wall->at(wall.sine).reflected_energy : 1;
  const double by_mirror = one_way && may_turn ? at.reflection * at.reflection * by_wall : 0;
  const double passed =
      one_way && at.lets_through() ? at.wall->at(wall.sine).transmitted_energy : 0;
  const double scattered = may_turn && scatters(material, at.hit)
                               ? kPi * bistatic(at, incidence) / (incidence * incidence)
                               : 0;
  const double all = by_mirror + passed + scattered;
  const double chosen = uniform_from_word(words.v[2]) * all;
  // The taps of the wall contain the reflected energy.
  if (chosen < by_mirror) {
    if (at.wall != nullptr && !travel.walls.add(at.event(true))) return std::nullopt;
    travel.energy *= all / by_wall;
    travel.kinds |= 1u << (travel.surfaces - 1);
    direction = normalized(reflected_direction(at));
    return Turn::reflected;
  }
  if (chosen < by_mirror + passed) {
    if (!travel.walls.add(wall)) return std::nullopt;
    travel.energy *= all / passed;
    direction = at.direction;
    return Turn::passed;
  }
  if (scattered == 0) return std::nullopt;
  const double cosine = std::sqrt(uniform_from_word(words.v[0]));
  const double turn = 2 * kPi * uniform_from_word(words.v[1]);
  if (!(cosine > kLeastCosine)) return std::nullopt;
  const Vec3 any = std::abs(at.normal.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 u = normalized(cross(any, at.normal)), v = cross(at.normal, u);
  const double sine = std::sqrt(1 - cosine * cosine);
  direction =
      normalized(cosine * at.normal + sine * std::cos(turn) * u + sine * std::sin(turn) * v);
  const double share = kPi * bistatic(at, cosine) / (incidence * cosine);
  const double followed = std::clamp(kFollowed * share, kLeastFollowed, 1.0);
  if (!(uniform_from_word(words.v[3]) < followed)) return std::nullopt;
  travel.energy *= share / followed * all / scattered;
  travel.scatter();
  return Turn::scattered;
}

void RayEchoes::scatter_on(Travel travel) {
  while (travel.surfaces < most() || (travel.first_scatterer > 0 && travel.at.lets_through())) {
    Vec3 direction;
    const std::optional<Turn> turn = choose_direction(travel, direction);
    if (!turn) return;
    const std::optional<WalkStep> next = context_.next(travel.at, direction);
    if (!next) return;
    if (*turn == Turn::passed) {
      travel.pass_to(*next);
    } else {
      travel.reach(*next);
    }
    if (scatters(context_.material(next->hit), next->hit)) hear(travel);
  }
}

// Returns none if the walk has more walls than a path may have.
std::optional<Travel> RayEchoes::travel_along(const MirrorWalk& walk) const {
  Travel travel;
  travel.at = walk.step[0];
  travel.energy = ray_.solid_angle_sr;
  travel.instance[0] = travel.at.hit.instance;
  for (int i = 0; i + 1 < walk.steps; ++i) {
    const WalkStep& at = walk.step[i];
    const bool reflected = walk.turned(i);
    if (at.wall != nullptr && !travel.walls.add(at.event(reflected))) return std::nullopt;
    if (!reflected) {
      travel.pass_to(walk.step[i + 1]);
      continue;
    }
    travel.energy *= at.reflection * at.reflection;
    travel.kinds |= 1u << (travel.surfaces - 1);
    travel.reach(walk.step[i + 1]);
  }
  return travel;
}

void RayEchoes::follow(const MirrorWalk& walk) {
  if (!scatters(context_.material(walk.last().hit), walk.last().hit)) return;
  const std::optional<Travel> travel = travel_along(walk);
  if (!travel) return;
  if (walk.steps > 1) hear(*travel);
  const int mirrors = walk.reflections();
  if (mirrors > 0 && 2 * mirrors + 1 <= most()) {
    hear_over_same_mirrors(*travel, spreading_per_m2(context_, ray_.azimuth_rad, ray_.elevation_rad,
                                                     walk, walk.steps - 1));
  }
  // If the specular reflector also scatters, both parts are followed.
  scatter_on(*travel);
}

}  // namespace

std::vector<SoundPath> bounce_paths(int bounces, bool walls) {
  std::vector<SoundPath> paths;
  const auto add = [&](int surfaces, bool through) {
    for (unsigned kinds = 0; kinds < 1u << surfaces; ++kinds) {
      SoundPath path{path_of_kinds(surfaces, kinds), {}, {}};
      if (through) {
        path.id |= kThroughWalls;
        path.out.push_back("walls");
      }
      for (int i = 0; i < surfaces; ++i) {
        path.out.push_back((kinds >> i & 1u) != 0 ? "specular" : "diffuse");
      }
      paths.push_back(std::move(path));
    }
  };
  for (int surfaces = 2; surfaces <= bounces + 1; ++surfaces) add(surfaces, false);
  for (int surfaces = 1; walls && surfaces <= bounces + 1; ++surfaces) add(surfaces, true);
  return paths;
}

std::vector<Scatterer> bounced_off_surfaces(const BouncePing& ping, const Fan& fan,
                                            std::span<const Hit> hits, const Workers& workers) {
  ENSONIFY_ASSERT(hits.size() == fan.size() && ping.bounces <= kMostBounces);
  const BounceContext context = bounce_context(ping);
  const bool has_mirrors = has_smooth_surfaces(ping.scattering);
  std::vector<ComesBack> found(has_mirrors ? hits.size() : 0);
  const std::size_t rays = fan.rays_per_beam();
  std::vector<std::vector<Scatterer>> by_beam(fan.beams);
  workers.for_each(fan.beams, [&](std::size_t beam) {
    for (std::size_t i = 0; i < rays; ++i) {
      const Hit& hit = hits[beam * rays + i];
      if (hit.instance == 0 || !(hit.range_m > 0) || !(hit.cos_incidence > 0)) continue;
      const std::size_t row = i % fan.rays_elevation;
      const auto own = static_cast<std::uint32_t>(fan.beam_of(beam));
      const FanRay ray{own * rays + i, own,
                       fan.azimuth_rad[beam * fan.rays_azimuth + i / fan.rays_elevation],
                       fan.elevation_rad[row], fan.cell_sr(beam, row)};
      MirrorWalk start;
      start.steps = 1;
      start.step[0] = context.step({}, context.to_world(ray.azimuth_rad, ray.elevation_rad), hit);
      RayEchoes echoes(context, ray, by_beam[beam]);
      const auto visit = [&](const MirrorWalk& walk) {
        echoes.follow(walk);
        if (comes_back(context, walk)) found[beam * rays + i].set(chain_code(walk));
      };
      each_walk(context, start, ping.bounces + 1, visit);
    }
  });
  std::vector<Scatterer> all;
  append(by_beam, all);
  if (!has_mirrors) return all;
  const std::vector<Scatterer> chains = chain_scatterers(context, fan, found, workers);
  all.insert(all.end(), chains.begin(), chains.end());
  return all;
}

}  // namespace ensonify
