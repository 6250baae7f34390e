#include "trace/bounces.h"

#include <algorithm>
#include <cmath>

#include "acoustics/pattern.h"
#include "acoustics/propagation.h"
#include "acoustics/scattering.h"
#include "core/error.h"
#include "core/random.h"
#include "trace/echo.h"
#include "trace/mirror_chains.h"
#include "trace/pieces.h"

namespace ensonify {
namespace {

// Keeps the keys apart from those of rays, targets and kirchhoff_scatterers.
constexpr std::uint64_t kBounceKey = std::uint64_t{1} << 61;
constexpr int kKeysOfRay = 8;  // bits for the echoes of a ray
// A sampled direction is followed with a probability of kFollowed times its share of the energy,
// limited to [kLeastFollowed, 1].
constexpr double kLeastFollowed = 1.0 / 8, kFollowed = 4;
constexpr double kLeastCosine = 1e-6;

bool scatters(const Material& material, const Hit& hit) {
  return hit.reflectivity > 0 &&
         (material.law == ScatteringLaw::table || material.reflectivity > 0);
}

// A path from the sonar, as far as it has been followed.
struct Travel {
  WalkStep at;         // the surface that it has reached
  double energy = 0;   // W of bounced_off_surfaces
  int surfaces = 1;    // reached so far, including `at`
  unsigned kinds = 0;  // of the surfaces before `at`
  std::array<std::uint32_t, kMostSurfaces> instance{};
  // The first surface that scattered the sound, counted from 1; 0: none yet.
  int first_scatterer = 0;
  Vec3 first_point_m;
  double first_length_m = 0;

  void reach(const WalkStep& step) {
    at = step;
    instance[surfaces++] = step.hit.instance;
  }
};

// What the echoes of one ray of the fan share.
struct FanRay {
  std::size_t index = 0;
  std::uint32_t beam = 0;
  double azimuth_rad = 0, elevation_rad = 0, solid_angle_sr = 0;
};

// The direction at the sonar in which a path leaves or arrives, and its beam.
struct SonarSide {
  double azimuth_rad = 0, elevation_rad = 0;
  std::uint32_t beam = 0;
};

class RayEchoes {
 public:
  RayEchoes(const BounceContext& context, const FanRay& ray, std::vector<Scatterer>& scatterers)
      : context_(context), ray_(ray), scatterers_(scatterers) {}

  void follow(const MirrorWalk& walk);

 private:
  int most() const { return context_.ping.bounces + 1; }
  void hear(const Travel& travel);
  void hear_over_same_mirrors(const Travel& travel, double spreading_per_m2);
  void scatter_on(Travel travel);
  bool choose_direction(Travel& travel, Vec3& direction);
  bool add(const Travel& travel, const SonarSide& out, const SonarSide& back, double delay_m,
           double energy, double extinction_db, bool reversed, double received_m, Vec3 place_m);
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

// `energy` includes all spreading. A Scatterer has an amplitude in m and a gain in 1/m^2, of which
// only the product matters.
bool RayEchoes::add(const Travel& travel, const SonarSide& out, const SonarSide& back,
                    double delay_m, double energy, double extinction_db, bool reversed,
                    double received_m, Vec3 place_m) {
  const SurfaceScattering& scattering = context_.ping.scattering;
  const Sonar& sonar = scattering.sonar;
  if (!in_range(delay_m / 2, sonar) || !(energy > 0) || !std::isfinite(energy)) return false;
  Scatterer s;
  s.delay_s = delay_m / scattering.water.sound_speed_m_s;
  s.position_m = context_.to_sonar(place_m);
  s.departure = {static_cast<float>(out.azimuth_rad), static_cast<float>(out.elevation_rad)};
  s.arrival = {static_cast<float>(back.azimuth_rad), static_cast<float>(back.elevation_rad)};
  const double pattern = two_direction_pattern(elevation_pattern(sonar, out.elevation_rad),
                                               elevation_pattern(sonar, back.elevation_rad)) *
                         transmit_pattern(out.azimuth_rad, sonar.transmit_width_rad);
  const double loss = path_loss(delay_m / 2, delay_m / 2, scattering.water.absorption_db_m);
  s.gain = static_cast<float>(loss * pattern * std::pow(10.0, -extinction_db / 20));
  if (s.gain == 0 || !std::isfinite(s.gain)) return false;
  s.standard_deviation = static_cast<float>(std::sqrt(energy) * delay_m * delay_m / 4);
  s.cos_incidence = travel.at.hit.cos_incidence;
  s.key = kBounceKey | std::uint64_t{ray_.index} << kKeysOfRay | next_key_;
  s.beam = back.beam;
  s.received_path_m = static_cast<float>(received_m);
  const int last = reversed ? travel.first_scatterer - 1 : travel.surfaces - 1;
  s.instance = travel.instance[last];
  unsigned kinds = 0;
  int others = 0;
  for (int i = 0; i < travel.surfaces; ++i) {
    const int surface = reversed ? travel.surfaces - 1 - i : i;
    kinds |= (travel.kinds >> surface & 1u) << i;
    if (surface != last) s.via[others++] = static_cast<std::uint16_t>(travel.instance[surface]);
  }
  s.path = path_of_kinds(travel.surfaces, kinds);
  scatterers_.push_back(s);
  return true;
}

// Connects a surface that scatters to the sonar, and adds both directions of the path.
void RayEchoes::hear(const Travel& travel) {
  const std::optional<Connection> back = connect(context_, travel.at);
  if (!back) return;
  const bool from_both_ends = travel.first_scatterer == 1;
  const double energy = travel.energy * bistatic(travel.at, back->cosine) /
                        (travel.at.hit.cos_incidence * back->length_m * back->length_m) *
                        (from_both_ends ? 0.5 : 1);
  const double path_m = travel.at.length_m + back->length_m;
  const double extinction_db = travel.at.extinction_db + back->extinction_db;
  const SonarSide sent{ray_.azimuth_rad, ray_.elevation_rad, ray_.beam};
  const SonarSide heard{back->azimuth_rad, back->elevation_rad, back->beam};
  Travel whole = travel;
  if (whole.first_scatterer == 0) {
    whole.first_scatterer = whole.surfaces;
    whole.first_point_m = whole.at.point_m;
    whole.first_length_m = whole.at.length_m;
  }
  const bool one = add(whole, sent, heard, path_m, energy, extinction_db, false, back->length_m,
                       whole.at.point_m);
  const bool other = add(whole, heard, sent, path_m, energy, extinction_db, true,
                         whole.first_length_m, whole.first_point_m);
  if (one && other && heard.beam == sent.beam && context_.ping.ways_as_one) {
    const float gain = scatterers_.back().gain;
    scatterers_.pop_back();
    scatterers_.back().gain += gain;
  }
  ++next_key_;
}

// Adds the path over specular reflectors to a surface that scatters, and back over the same ones.
void RayEchoes::hear_over_same_mirrors(const Travel& travel, double spreading_per_m2) {
  const int mirrors = travel.surfaces - 1;
  Travel whole = travel;
  whole.surfaces = 2 * mirrors + 1;
  whole.first_scatterer = travel.surfaces;
  for (int i = 0; i < mirrors; ++i) {
    whole.kinds |= 1u << (whole.surfaces - 1 - i);
    whole.instance[whole.surfaces - 1 - i] = travel.instance[i];
  }
  const double cosine = travel.at.hit.cos_incidence;
  const double reflected = travel.energy / ray_.solid_angle_sr;  // R^2 of all specular reflectors
  const double energy =
      travel.energy * reflected * bistatic(travel.at, cosine) / cosine * spreading_per_m2;
  const SonarSide side{ray_.azimuth_rad, ray_.elevation_rad, ray_.beam};
  // The label is the surface that scatters, as in a reversed path.
  add(whole, side, side, 2 * travel.at.length_m, energy, 2 * travel.at.extinction_db, true,
      travel.at.length_m, travel.at.point_m);
  ++next_key_;
}

// Chooses the next direction, specular or sampled, and updates the energy. False: the path ends
// here.
bool RayEchoes::choose_direction(Travel& travel, Vec3& direction) {
  const WalkStep& at = travel.at;
  const Material& material = context_.material(at.hit);
  const Philox4 words =
      random_words(context_.ping.key, context_.ping.ping, ray_.index, next_draw_++);
  const double incidence = at.hit.cos_incidence;
  // After its first scattering, a path continues in one of two ways, chosen by their energies:
  // reflected or scattered.
  const double by_mirror = travel.first_scatterer > 0 ? at.reflection * at.reflection : 0;
  const double scattered =
      scatters(material, at.hit) ? kPi * bistatic(at, incidence) / (incidence * incidence) : 0;
  const double chosen = uniform_from_word(words.v[2]) * (by_mirror + scattered);
  if (chosen < by_mirror) {
    travel.energy *= by_mirror + scattered;
    travel.kinds |= 1u << (travel.surfaces - 1);
    direction = normalized(at.direction - 2 * dot(at.direction, at.normal) * at.normal);
    return true;
  }
  if (scattered == 0) return false;
  const double cosine = std::sqrt(uniform_from_word(words.v[0]));
  const double turn = 2 * kPi * uniform_from_word(words.v[1]);
  if (!(cosine > kLeastCosine)) return false;
  const Vec3 any = std::abs(at.normal.x) < 0.5 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 u = normalized(cross(any, at.normal)), v = cross(at.normal, u);
  const double sine = std::sqrt(1 - cosine * cosine);
  direction =
      normalized(cosine * at.normal + sine * std::cos(turn) * u + sine * std::sin(turn) * v);
  const double share = kPi * bistatic(at, cosine) / (incidence * cosine);
  const double followed = std::clamp(kFollowed * share, kLeastFollowed, 1.0);
  if (!(uniform_from_word(words.v[3]) < followed)) return false;
  travel.energy *= share / followed * (by_mirror + scattered) / scattered;
  if (travel.first_scatterer == 0) {
    travel.first_scatterer = travel.surfaces;
    travel.first_point_m = at.point_m;
    travel.first_length_m = at.length_m;
  }
  return true;
}

void RayEchoes::scatter_on(Travel travel) {
  while (travel.surfaces < most()) {
    Vec3 direction;
    if (!choose_direction(travel, direction)) return;
    const std::optional<WalkStep> next = context_.next(travel.at, direction);
    if (!next) return;
    travel.reach(*next);
    if (scatters(context_.material(next->hit), next->hit)) hear(travel);
  }
}

void RayEchoes::follow(const MirrorWalk& walk) {
  Travel travel;
  travel.at = walk.step[0];
  travel.energy = ray_.solid_angle_sr;
  travel.instance[0] = travel.at.hit.instance;
  for (int i = 0; i < walk.steps; ++i) {
    if (i > 0) travel.reach(walk.step[i]);
    const WalkStep& at = travel.at;
    if (scatters(context_.material(at.hit), at.hit)) {
      if (i > 0) hear(travel);
      if (i > 0 && 2 * i + 1 <= most()) {
        hear_over_same_mirrors(
            travel, spreading_per_m2(context_, ray_.azimuth_rad, ray_.elevation_rad, walk, i));
      }
      // If the specular reflector also scatters, both parts are followed.
      Travel scattered = travel;
      scatter_on(scattered);
    }
    travel.energy *= at.reflection * at.reflection;
    travel.kinds |= 1u << i;
  }
}

std::vector<MirrorWalk> walks_of(const BounceContext& context, const Fan& fan,
                                 std::span<const Hit> hits, const Workers& workers) {
  std::vector<MirrorWalk> walks(hits.size());
  const std::size_t rays = fan.rays_per_beam();
  workers.for_each(fan.beams, [&](std::size_t beam) {
    for (std::size_t i = 0; i < rays; ++i) {
      const std::size_t ray = beam * rays + i;
      const Hit& hit = hits[ray];
      if (hit.instance == 0 || !(hit.range_m > 0) || !(hit.cos_incidence > 0)) continue;
      const double azimuth = fan.azimuth_rad[beam * fan.rays_azimuth + i / fan.rays_elevation];
      const Vec3 direction =
          normalized(rotate(context.ping.sonar_in_world.rotation,
                            unit_vector(azimuth, fan.elevation_rad[i % fan.rays_elevation])));
      walks[ray] =
          follow_mirrors(context, first_step(context, direction, hit), context.ping.bounces + 1);
    }
  });
  return walks;
}

}  // namespace

std::vector<SoundPath> bounce_paths(int bounces) {
  std::vector<SoundPath> paths;
  for (int surfaces = 2; bounces > 0 && surfaces <= bounces + 1; ++surfaces) {
    for (unsigned kinds = 0; kinds < 1u << surfaces; ++kinds) {
      SoundPath path{path_of_kinds(surfaces, kinds), {}, {}};
      for (int i = 0; i < surfaces; ++i) {
        path.out.push_back((kinds >> i & 1u) != 0 ? "specular" : "diffuse");
      }
      paths.push_back(std::move(path));
    }
  }
  return paths;
}

std::vector<Scatterer> bounced_off_surfaces(const BouncePing& ping, const Fan& fan,
                                            std::span<const Hit> hits, const Workers& workers) {
  ENSONIFY_ASSERT(hits.size() == fan.size() && ping.bounces <= kMostBounces);
  const BounceContext context = bounce_context(ping);
  const std::vector<MirrorWalk> walks = walks_of(context, fan, hits, workers);
  const std::size_t rays = fan.rays_per_beam();
  std::vector<std::vector<Scatterer>> by_beam(fan.beams);
  workers.for_each(fan.beams, [&](std::size_t beam) {
    for (std::size_t i = 0; i < rays; ++i) {
      const MirrorWalk& walk = walks[beam * rays + i];
      if (walk.steps == 0) continue;
      const std::size_t row = i % fan.rays_elevation;
      const FanRay ray{beam * rays + i, static_cast<std::uint32_t>(beam),
                       fan.azimuth_rad[beam * fan.rays_azimuth + i / fan.rays_elevation],
                       fan.elevation_rad[row], fan.solid_angle_sr[row]};
      RayEchoes(context, ray, by_beam[beam]).follow(walk);
    }
  });
  std::vector<Scatterer> all;
  append(by_beam, all);
  if (!has_smooth_surfaces(ping.scattering)) return all;
  const std::vector<Scatterer> chains = chain_scatterers(context, fan, walks, workers);
  all.insert(all.end(), chains.begin(), chains.end());
  return all;
}

}  // namespace ensonify
