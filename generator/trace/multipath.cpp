#include "trace/multipath.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "acoustics/pattern.h"
#include "acoustics/propagation.h"
#include "acoustics/scattering.h"
#include "trace/echo.h"

namespace ensonify {
namespace {

constexpr int kPairShift = 40;

// What scatters the sound: a surface element or a target.
struct Reflector {
  Vec3 position_m;  // sonar frame
  std::uint32_t instance = 0;
  std::uint64_t key = 0;
};

// Adds both directions of a path over two ends, unless it is out of range.
void add_echoes(const LegPair& pair, const LegEnd& first, const LegEnd& second, const Bounces& b,
                const Reflector& reflector, const ScattererMoments& moments,
                std::vector<Scatterer>& scatterers) {
  const auto add = [&](const LegEnd& out, const LegEnd& back, std::uint16_t path) {
    std::optional<Scatterer> s = echo_of(out, back, b.scattering.sonar, b.scattering.water);
    if (!s) return;
    s->position_m = reflector.position_m;
    s->mean = static_cast<float>(moments.mean_m);
    s->standard_deviation = static_cast<float>(std::sqrt(moments.variance_m2));
    s->instance = reflector.instance;
    s->key = reflector.key;
    s->path = path;
    scatterers.push_back(*s);
  };
  add(first, second, pair.out_first);
  if (pair.first != pair.second) add(second, first, pair.out_second);
}

// The pairs that start with one leg.
std::span<const LegPair> pairs_of(const BouncePlan& plan, std::size_t leg) {
  const auto starts_before = [](const LegPair& pair, std::size_t x) { return pair.first < x; };
  const auto first = std::lower_bound(plan.pairs.begin(), plan.pairs.end(), leg, starts_before);
  const auto last = std::lower_bound(first, plan.pairs.end(), leg + 1, starts_before);
  return {first, last};
}

// The echoes of one element over its own leg and all later ones.
class ElementEchoes {
 public:
  ElementEchoes(const Bounces& bounces, std::vector<Scatterer>& scatterers)
      : b_(bounces), scatterers_(scatterers) {}

  // `first`: the end that the ray found; `solid_angle_sr`: of the ray's cell.
  void add(std::span<const LegPair> pairs, const Hit& hit, LegEnd& first, std::size_t ray,
           double solid_angle_sr) {
    if (!(hit.cos_incidence >= 0 && hit.cos_incidence <= 1) || !b_.is_in_water(first.point_m)) {
      return;
    }
    first.cos_incidence = hit.cos_incidence;
    Reflector reflector;
    reflector.instance = hit.instance;
    reflector.position_m = b_.to_sonar(first.point_m);
    const double side = dot(hit.normal, first.direction);
    for (const LegPair& pair : pairs) {
      reflector.key = std::uint64_t{std::min(pair.out_first, pair.out_second)} << kPairShift | ray;
      if (pair.second == pair.first) {
        b_.add_extinction(first);
        emit(pair, hit, first, first, reflector, solid_angle_sr);
        continue;
      }
      std::optional<LegEnd> second = b_.reach(pair.second, first.point_m, first.length_m);
      if (!second) continue;
      const double other_side = dot(hit.normal, second->direction);
      if (side * other_side < 0 || !b_.is_free(*second)) continue;
      second->cos_incidence = std::min(1.0, std::abs(other_side));
      b_.add_extinction(first);
      b_.add_extinction(*second);
      emit(pair, hit, first, *second, reflector, solid_angle_sr);
    }
  }

 private:
  void emit(const LegPair& pair, const Hit& hit, const LegEnd& first, const LegEnd& second,
            const Reflector& reflector, double solid_angle_sr) {
    const ScattererMoments moments =
        bistatic_moments(material_at(b_.scattering, hit), hit.reflectivity, first.cos_incidence,
                         second.cos_incidence, first.length_m, solid_angle_sr);
    if (is_an_echo(moments)) {
      add_echoes(pair, first, second, b_, reflector, moments, scatterers_);
    }
  }

  const Bounces& b_;
  std::vector<Scatterer>& scatterers_;
};

// The echoes of the rays of one beam cell over one leg.
void add_beam(const Bounces& b, const Fan& fan, std::span<const Hit> hits, std::uint16_t leg,
              std::size_t beam, std::vector<Scatterer>& scatterers) {
  const std::span<const LegPair> pairs = pairs_of(b.plan, leg);
  if (pairs.empty() || !b.is_possible(leg)) return;
  ElementEchoes elements(b, scatterers);
  std::size_t ray = beam * fan.rays_per_beam();
  for (int a = 0; a < fan.rays_azimuth; ++a) {
    const double azimuth = fan.azimuth_rad[beam * fan.rays_azimuth + a];
    for (int e = 0; e < fan.rays_elevation; ++e, ++ray) {
      const Vec3 direction = unit_vector(azimuth, fan.elevation_rad[e]);
      LegEnd end;
      Hit hit;
      if (b.plan.legs[leg].empty()) {
        hit = hits[ray];
        if (hit.instance == 0 || !(hit.range_m > 0)) continue;
        end = b.straight(direction, hit.range_m);
      } else {
        std::optional<LegEnd> found = b.trace(leg, direction, hit);
        if (!found) continue;
        end = *found;
      }
      end.azimuth_rad = azimuth;
      end.elevation_rad = fan.elevation_rad[e];
      end.beam = static_cast<std::uint32_t>(fan.beam_of(beam));
      elements.add(pairs, hit, end, ray + (end.beam - beam) * fan.rays_per_beam(),
                   fan.cell_sr(beam, e));
    }
  }
}

// Without taps: of a target strength alone.
void add_target(const Bounces& b, Vec3 position_m, double target_strength_db,
                std::span<const Tap> taps, std::uint32_t instance, std::uint64_t key,
                std::vector<Scatterer>& scatterers) {
  const Vec3 point = position_m - b.pose.position_m;
  if (!b.is_in_water(point)) return;
  std::vector<std::optional<LegEnd>> ends(b.plan.legs.size());
  for (std::size_t leg = 0; leg < ends.size(); ++leg) {
    std::optional<LegEnd> end = b.reach(static_cast<std::uint16_t>(leg), point, 0);
    if (!end || !b.is_free(*end)) continue;
    end->cos_incidence = 1;
    b.add_extinction(*end);
    ends[leg] = end;
  }
  const ScattererMoments moments{target_amplitude_m(target_strength_db), 0};
  const Reflector reflector{b.to_sonar(point), instance, key};
  for (const LegPair& pair : b.plan.pairs) {
    const auto &first = ends[pair.first], &second = ends[pair.second];
    if (!first || !second) continue;
    const std::size_t before = scatterers.size();
    add_echoes(pair, *first, *second, b, reflector, moments, scatterers);
    if (taps.empty()) continue;
    const std::vector<Scatterer> centers(scatterers.begin() + static_cast<std::ptrdiff_t>(before),
                                         scatterers.end());
    scatterers.resize(before);
    // The two directions of a tap stay together (both_ways_as_one).
    for (std::size_t i = 0; i < taps.size(); ++i) {
      for (const Scatterer& center : centers) add_tap(center, taps[i], i, scatterers);
    }
  }
}

void add_targets(const Bounces& b, const World& world, const Workers& workers,
                 std::vector<Scatterer>& all) {
  for (const PointTarget& target : world.point_targets) {
    add_target(b, target.position_m, target.target_strength_db, target.ringing.taps,
               target.instance, point_target_key(target.instance), all);
  }
  for (const School& school : world.schools) {
    constexpr std::size_t kBlock = 256;
    const std::size_t fish = school.fish_m.size(), blocks = (fish + kBlock - 1) / kBlock;
    std::vector<std::vector<Scatterer>> found(blocks);
    workers.for_each(blocks, [&](std::size_t block) {
      for (std::size_t i = block * kBlock; i < std::min((block + 1) * kBlock, fish); ++i) {
        add_target(b, school.fish_m[i], school.target_strength_db, {}, school.instance,
                   fish_key(school.instance, i), found[block]);
      }
    });
    append(found, all);
  }
}

}  // namespace

std::vector<Scatterer> bounced_echoes(const BouncedMoment& moment, const Fan& fan,
                                      std::span<const Hit> hits, const Workers& workers) {
  std::vector<Scatterer> all;
  if (moment.plan.paths.empty()) return all;
  const Bounces bounces = make_bounces(moment);
  if (!bounces.is_in_water({})) return all;
  for (std::size_t leg = 0; leg < moment.plan.legs.size(); ++leg) {
    std::vector<std::vector<Scatterer>> of_beam(fan.beams);
    workers.for_each(fan.beams, [&](std::size_t beam) {
      add_beam(bounces, fan, hits, static_cast<std::uint16_t>(leg), beam, of_beam[beam]);
    });
    append(of_beam, all);
  }
  add_targets(bounces, moment.world, workers, all);
  return all;
}

std::vector<Scatterer> both_ways_as_one(std::vector<Scatterer> echoes) {
  std::size_t kept = 0;
  for (const Scatterer& s : echoes) {
    Scatterer* before = kept > 0 ? &echoes[kept - 1] : nullptr;
    const bool other_way = before != nullptr && before->key == s.key &&
                           before->instance == s.instance && before->delay_s == s.delay_s &&
                           before->path != s.path && before->beam == s.beam;
    if (other_way) {
      before->gain += s.gain;
    } else {
      echoes[kept++] = s;
    }
  }
  echoes.resize(kept);
  return echoes;
}

}  // namespace ensonify
