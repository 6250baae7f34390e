#include "trace/multipath.h"

#include <algorithm>
#include <cmath>

#include "acoustics/pattern.h"
#include "acoustics/propagation.h"
#include "trace/echo.h"
#include "trace/tracer.h"
#include "trace/volume.h"

namespace ensonify {
namespace {

double signed_height_m(const PlacedMirror& mirror, Vec3 point_m) {
  return dot(mirror.normal, point_m) - mirror.offset_m;
}

// Returns false if an image of the sonar lies behind the next reflector of the leg, or if the
// distance between them is longer than sound travels.
bool images_are_before(std::span<const PlacedMirror> mirrors, const Leg& leg, double length_max_m) {
  Vec3 image;
  for (const std::uint16_t m : leg) {
    const double height = signed_height_m(mirrors[m], image);
    if ((mirrors[m].one_sided && height <= 0) || std::abs(height) > length_max_m) return false;
    image = image - 2 * height * mirrors[m].normal;
  }
  return true;
}

}  // namespace

bool set_direction(const Sonar& sonar, Vec3 seen_m, LegEnd& end) {
  end.elevation_rad = std::asin(std::clamp(seen_m.z / end.length_m, -1.0, 1.0));
  if (std::abs(end.elevation_rad) > sonar.elevation_fan_rad / 2) return false;
  end.azimuth_rad = std::atan2(seen_m.y, seen_m.x);
  const std::optional<int> beam = sector_of(sonar, end.azimuth_rad);
  if (!beam) return false;
  end.beam = static_cast<std::uint32_t>(*beam);
  return true;
}

bool Bounces::is_in_water(Vec3 point_m) const {
  if (plan.surface < 0) return true;
  return signed_height_m(mirrors[plan.surface], point_m) >= -kOnSurface;
}

bool Bounces::stays_in_water(const Leg& leg, const Walk& way) const {
  const bool by_bottom = std::ranges::find(leg, plan.bottom) != leg.end();
  for (std::size_t i = 0; i < leg.size(); ++i) {
    if (!is_in_water(way.at_m[i])) return false;
    if (by_bottom && signed_height_m(mirrors[plan.bottom], way.at_m[i]) < -kOnSurface) {
      return false;
    }
  }
  return true;
}

bool Bounces::mirrors_are_met(const Leg& leg, const Walk& way) const {
  Vec3 from = pose.position_m;
  for (std::size_t i = 0; i < leg.size(); ++i) {
    const double piece = way.piece_m[i];
    const Hit hit = hit_after(tracer, from, way.direction[i], piece, i > 0);
    if (hit.instance != 0 && hit.range_m < piece * (1 - kOnSurface)) return false;
    from = pose.position_m + way.at_m[i];
  }
  return true;
}

LegEnd Bounces::straight(Vec3 sonar_direction, double range_m) const {
  LegEnd end;
  end.direction = rotate(pose.rotation, sonar_direction);
  end.way.direction[0] = end.direction;
  end.point_m = range_m * end.direction;
  end.length_m = range_m;
  return end;
}

std::optional<LegEnd> Bounces::trace(std::uint16_t number, Vec3 sonar_direction, Hit& hit) const {
  const Leg& leg = plan.legs[number];
  LegEnd end;
  end.leg = number;
  const Vec3 direction = normalized(rotate(pose.rotation, sonar_direction));
  if (!walk(mirrors, leg, direction, length_max_m, wavelength_m, end.way)) return std::nullopt;
  if (end.way.reflection == 0 || !stays_in_water(leg, end.way) || !mirrors_are_met(leg, end.way)) {
    return std::nullopt;
  }
  const Vec3 from = end.way.at_m[leg.size() - 1];
  end.direction = normalized(end.way.direction[leg.size()]);
  hit = hit_after(tracer, pose.position_m + from, end.direction, length_max_m - end.way.length_m,
                  true);
  if (hit.instance == 0 || !std::isfinite(hit.range_m)) return std::nullopt;
  end.point_m = from + hit.range_m * end.direction;
  end.length_m = end.way.length_m + hit.range_m;
  end.reflection = end.way.reflection;
  return end;
}

std::optional<LegEnd> Bounces::reach(std::uint16_t number, Vec3 point_m, double other_m) const {
  if (!is_possible(number)) return std::nullopt;
  const Leg& leg = plan.legs[number];
  LegEnd end;
  end.leg = number;
  end.point_m = point_m;
  const Vec3 image = image_seen_over(mirrors, leg, point_m);
  end.length_m = length(image);
  if (!(end.length_m > 0 && end.length_m + other_m <= length_max_m)) return std::nullopt;
  if (!set_direction(scattering.sonar, to_sonar(image), end)) return std::nullopt;
  if (!walk(mirrors, leg, (1 / end.length_m) * image, end.length_m, wavelength_m, end.way)) {
    return std::nullopt;
  }
  // The last reflector shows no image of a point that lies on it or behind it.
  if (end.length_m - end.way.length_m <= end.length_m * kOnSurface ||
      !stays_in_water(leg, end.way)) {
    return std::nullopt;
  }
  const bool by_bottom = std::ranges::find(leg, plan.bottom) != leg.end();
  if (by_bottom && signed_height_m(mirrors[plan.bottom], point_m) < -kOnSurface) {
    return std::nullopt;
  }
  end.direction = end.way.direction[leg.size()];
  end.reflection = end.way.reflection;
  if (end.reflection == 0) return std::nullopt;
  return end;
}

bool Bounces::is_free(const LegEnd& end) const {
  const Leg& leg = plan.legs[end.leg];
  if (!mirrors_are_met(leg, end.way)) return false;
  const Vec3 from = leg.empty() ? Vec3{} : end.way.at_m[leg.size() - 1];
  const double piece = end.length_m - end.way.length_m;
  const Hit hit = hit_after(tracer, pose.position_m + from, end.direction, piece, !leg.empty());
  return hit.instance == 0 || hit.range_m >= piece * (1 - kOnSurface);
}

void Bounces::add_extinction(LegEnd& end) const {
  if (!volumes_attenuate || end.extinction_db) return;
  const Leg& leg = plan.legs[end.leg];
  const double step_m = scattering.water.sound_speed_m_s / (4 * scattering.sonar.bandwidth_hz);
  DensityColumn column;
  double sum_db = 0;
  Vec3 from;
  for (std::size_t i = 0; i <= leg.size(); ++i) {
    const double piece = i < leg.size() ? end.way.piece_m[i] : end.length_m - end.way.length_m;
    sum_db += extinction_db(volumes, {pose.position_m + from, end.way.direction[i]}, step_m, piece,
                            column);
    if (i < leg.size()) from = end.way.at_m[i];
  }
  end.extinction_db = sum_db;
}

Bounces make_bounces(const BouncedMoment& moment) {
  const SurfaceScattering& scattering = moment.scattering;
  const Vec3 at = moment.sonar_in_world.position_m;
  Bounces b{moment.plan,
            moment.tracer,
            moment.world.volumes,
            scattering,
            moment.sonar_in_world,
            place_mirrors(moment.plan, moment.world, moment.object_in_world, at),
            {}};
  b.wavelength_m = scattering.water.sound_speed_m_s / scattering.sonar.frequency_hz;
  b.length_max_m = 2 * scattering.sonar.range_max_m;
  b.volumes_attenuate = std::ranges::any_of(
      b.volumes, [](const Volume& volume) { return volume.extinction_db_m > 0; });
  for (const Leg& leg : moment.plan.legs) {
    b.possible.push_back(images_are_before(b.mirrors, leg, b.length_max_m));
  }
  return b;
}

std::optional<Scatterer> echo_of(const LegEnd& out, const LegEnd& back, const Sonar& sonar,
                                 const Water& water) {
  const double whole_m = out.length_m + back.length_m;
  if (!in_range(whole_m / 2, sonar)) return std::nullopt;
  Scatterer s;
  s.delay_s = whole_m / water.sound_speed_m_s;
  s.departure = {static_cast<float>(out.azimuth_rad), static_cast<float>(out.elevation_rad)};
  s.arrival = {static_cast<float>(back.azimuth_rad), static_cast<float>(back.elevation_rad)};
  const double pattern = two_direction_pattern(elevation_pattern(sonar, out.elevation_rad),
                                               elevation_pattern(sonar, back.elevation_rad)) *
                         transmit_pattern(out.azimuth_rad, sonar.transmit_width_rad);
  const double extinction_db = out.extinction_db.value_or(0) + back.extinction_db.value_or(0);
  s.gain = static_cast<float>(path_loss(out.length_m, back.length_m, water.absorption_db_m) *
                              out.reflection * back.reflection * pattern *
                              std::pow(10.0, -extinction_db / 20));
  if (s.gain == 0 || !std::isfinite(s.gain)) return std::nullopt;
  s.beam = back.beam;
  s.received_path_m = static_cast<float>(back.length_m);
  s.cos_incidence = static_cast<float>(out.cos_incidence);
  return s;
}

}  // namespace ensonify
