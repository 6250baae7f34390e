#include "ping/key_warnings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>
#include <utility>
#include <variant>

#include "acoustics/pattern.h"
#include "acoustics/propagation.h"
#include "core/units.h"
#include "world/shapes.h"

namespace ensonify {
namespace {

using Warnings = std::vector<std::string>;

constexpr double kSameSpeed = 0.02, kSameDensity = 0.01, kNearProfile = 0.01;
constexpr double kSameTemperatureC = 1, kSameSalinityPsu = 1;

std::string water_text(double temperature_c, double salinity_psu) {
  return fmt::format("{:g} °C and {:g} psu", temperature_c, salinity_psu);
}

// The ranges for which the formula of the sound speed was made, and a little beyond.
bool has_sound_speed(const SeaAbsorptionSpec& sea) {
  return sea.temperature_c <= 40 && sea.salinity_psu <= 45;
}

// Temperature and salinity of the sound speed and of the absorption.
void warn_of_two_waters(const WaterSpec& water, Warnings& warnings) {
  const auto* sea = std::get_if<SeaAbsorptionSpec>(&water.absorption);
  const auto& from = water.sound_speed_from;
  if (sea == nullptr) return;
  if (from) {
    if (std::abs(from->temperature_c - sea->temperature_c) <= kSameTemperatureC &&
        std::abs(from->salinity_psu - sea->salinity_psu) <= kSameSalinityPsu) {
      return;
    }
    warnings.push_back(fmt::format(
        "water.absorption: {} are not the {} of the water described; leave out temperature_c and "
        "salinity_psu here, and absorption follows from that water",
        water_text(sea->temperature_c, sea->salinity_psu),
        water_text(from->temperature_c, from->salinity_psu)));
    return;
  }
  if (!has_sound_speed(*sea)) return;
  const double implied_m_s =
      sound_speed_m_s({sea->temperature_c, sea->salinity_psu, sea->ph, sea->depth_m});
  if (std::abs(water.sound_speed_m_s / implied_m_s - 1) <= kSameSpeed) return;
  warnings.push_back(fmt::format(
      "water.sound_speed_m_s: {:g} is not the {:.5g} of the water whose absorption is used ({}); "
      "leave out sound_speed_m_s and give water.temperature_c and salinity_psu, from which both "
      "follow",
      water.sound_speed_m_s, implied_m_s, water_text(sea->temperature_c, sea->salinity_psu)));
}

bool needs_density(const Scenario& scenario) {
  return std::ranges::any_of(scenario.materials,
                             [](const MaterialSpec& m) { return m.wall.has_value(); }) ||
         std::ranges::any_of(scenario.objects,
                             [](const ObjectSpec& o) { return o.elastic.has_value(); }) ||
         std::ranges::any_of(scenario.point_targets,
                             [](const PointTargetSpec& t) { return t.sphere.has_value(); });
}

// The density of the water, and that of the water that sound speed or absorption describe.
void warn_of_density(const Scenario& scenario, Warnings& warnings) {
  if (!needs_density(scenario)) return;
  SeaWater water;
  if (const auto& from = scenario.water.sound_speed_from) {
    water = {from->temperature_c, from->salinity_psu, 8, from->depth_m};
  } else if (const auto* sea = std::get_if<SeaAbsorptionSpec>(&scenario.water.absorption)) {
    water = {sea->temperature_c, sea->salinity_psu, sea->ph, sea->depth_m};
  } else {
    return;
  }
  const double implied = water_density_kg_m3(water);
  if (std::abs(scenario.water.density_kg_m3 / implied - 1) <= kSameDensity) return;
  warnings.push_back(fmt::format(
      "water.density_kg_m3: {:g} is not the {:.5g} of the water described ({}), and walls or "
      "elastic bodies echo with it; give water.density_kg_m3: {:.5g}",
      scenario.water.density_kg_m3, implied, water_text(water.temperature_c, water.salinity_psu),
      implied));
}

void warn_of_profile(const Session& session, Warnings& warnings) {
  const auto& profile = session.water.profile;
  if (!profile) return;
  const auto [low, high] = std::ranges::minmax(profile->speed_m_s);
  const double assumed = session.water.sound_speed_m_s;
  if (assumed >= (1 - kNearProfile) * low && assumed <= (1 + kNearProfile) * high) return;
  warnings.push_back(fmt::format(
      "water.sound_speed_m_s: the instrument assumes {:g}, but the profile has {:g} to {:g}, so "
      "ranges are wrong by {:.2g} %; give the speed at the depth of the sonar",
      assumed, low, high, 100 * std::abs(assumed / (assumed < low ? low : high) - 1)));
}

// A cell gives its whole echo to its beam, so beams far narrower than their cells are too loud.
constexpr double kWidestCell = 2;

void warn_of_cells(const Sonar& sonar, Warnings& warnings) {
  if (sonar.array) return;
  double widest = 0;
  int at = 0;
  for (int j = 0; j < sonar.beam_count; ++j) {
    const double ratio = cell_width_rad(sonar, j) / width_of_beam_rad(sonar, j);
    if (ratio > widest) std::tie(widest, at) = std::pair(ratio, j);
  }
  if (widest <= kWidestCell) return;
  warnings.push_back(fmt::format(
      "sonar.beams: the cell of beam {} is {:.3g} degrees wide and its beam {:.3g}, but it "
      "receives "
      "the echo of the whole cell, up to {:.2g} dB more than such a beam; give more beams, a "
      "smaller fov_deg or a larger receive_width_deg",
      at, degrees(cell_width_rad(sonar, at)), degrees(width_of_beam_rad(sonar, at)),
      10 * std::log10(widest)));
}

// Rounding of a rate that is exactly the highest.
constexpr double kSameTime = 1e-9;

// The error or warning about pings that overlap; empty if none do.
std::string overlap_text(const Session& session) {
  if (session.ping_times_s.size() < 2) return "";
  const double rate_hz = ping_rate_hz(session.scenario);
  const double two_way_s = 2 * session.sonar.range_max_m / session.water.sound_speed_m_s;
  if (1 / rate_hz >= two_way_s * (1 - kSameTime)) return "";
  const double exponent = std::pow(10, 2 - std::floor(std::log10(1 / two_way_s)));
  return fmt::format(
             "trajectory.ping_rate_hz: {:g} Hz sends a ping every {:.3g} s, but echoes from {:g} m "
             "(sonar.range_max_m) take {:.3g} s",
             rate_hz, 1 / rate_hz, session.sonar.range_max_m, two_way_s) +
         fmt::format("; expected at most {:g} Hz, or a shorter range",
                     std::floor(exponent / two_way_s) / exponent);
}

constexpr double kSameWidth = 0.1;

// Elements, spacing and weights of an array determine the width of its beams.
void warn_of_array(const Session& session, Warnings& warnings) {
  const auto& array = session.sonar.array;
  if (!array || !session.scenario.sonar.array->elements) return;
  const double wavelength_m = session.water.sound_speed_m_s / session.sonar.frequency_hz;
  const double aperture = array->elements * array->spacing_m / wavelength_m;
  const double width_rad = make_shaded_line(array->shading, 1).aperture / aperture;
  if (std::abs(session.sonar.beam_width_rad / width_rad - 1) <= kSameWidth) return;
  warnings.push_back(
      fmt::format("sonar.beams.receive_width_deg: {:.3g} is not the {:.3g} of {} elements {:.3g} m "
                  "apart, which "
                  "form the beams; leave out receiver.elements, or give the width of the array",
                  degrees(session.sonar.beam_width_rad), degrees(width_rad), array->elements,
                  array->spacing_m));
}

constexpr double kSameHeightM = 1e-3, kLevel = 1 - 1e-9;

// Horizontal planes that are neither the surface nor the bottom of multipath, but lie where one of
// them might be meant.
void warn_of_reflectors(const Session& session, Warnings& warnings) {
  const auto& multipath = session.scenario.multipath;
  if (!multipath || !multipath->bottom) return;
  const double bottom_m = multipath->bottom->z_m;
  for (const WorldObject& object : session.world.objects) {
    if (!std::holds_alternative<PlaneShape>(object.shape) || object.path) continue;
    const double height_m = object.pose.position_m.z;
    const bool is_level = std::abs(rotate(object.pose.rotation, {0, 0, 1}).z) >= kLevel;
    const double sonar_m = sonar_pose(session, 0).position_m.z;
    if (!is_level || height_m > sonar_m || std::abs(height_m - bottom_m) <= kSameHeightM) continue;
    warnings.push_back(fmt::format(
        "multipath.bottom.z_m: {:g} is not the height {:g} of {}, a horizontal plane below the "
        "sonar; give both the same height if they are one seabed",
        bottom_m, height_m, session.world.instances[object.instance - 1].name));
  }
}

// Objects that rest at an end of their path, because all pings are sent before or after it.
void warn_of_times(const Session& session, Warnings& warnings) {
  const double first_s = session.ping_times_s.front(), last_s = session.ping_times_s.back();
  std::size_t more = 0;
  for (const ObjectSpec& spec : session.scenario.objects) {
    if (!spec.trajectory) continue;
    const auto& instances = session.world.instances;
    const auto object = std::ranges::find_if(session.world.objects, [&](const WorldObject& of) {
      return of.path && instances[of.instance - 1].name == spec.name;
    });
    if (object == session.world.objects.end()) continue;
    const TimeSpan span = span_of(*object->path);
    if (span.start_s == span.end_s || (span.start_s <= last_s && span.end_s >= first_s)) continue;
    if (more++ > 0) continue;
    warnings.push_back(fmt::format(
        "objects.{}.trajectory: the path lasts from {:.13g} to {:.13g} s, but the pings are at "
        "{:.13g} to {:.13g} s, "
        "so the object rests; from_first_ping: true starts the path with the first ping",
        spec.name, span.start_s, span.end_s, first_s, last_s));
  }
  if (more > 1) warnings.back() += fmt::format("; so do {} more", more - 1);
}

void warn_of_rate(const Session& session, Warnings& warnings) {
  // Pings that are realizations of one scene are not sent one after the other.
  if (session.scenario.output.selection.statistics) return;
  std::string text = overlap_text(session);
  if (!text.empty()) warnings.push_back(std::move(text));
}

// Whether the bands of two groups overlap.
bool overlap(std::vector<double> carriers_hz, const Sonar& sonar) {
  std::ranges::sort(carriers_hz);
  for (std::size_t i = 1; i < carriers_hz.size(); ++i) {
    if (carriers_hz[i] - carriers_hz[i - 1] < sonar.bandwidth_hz * (1 - kSameTime)) return true;
  }
  return false;
}

// Echoes of a group are heard with those of the next, unless their carriers are a bandwidth apart.
void warn_of_interval(const Session& session, Warnings& warnings) {
  const auto& groups = session.sonar.transmit;
  if (!groups || groups->count == 1) return;
  const std::vector<double>& carriers_hz = groups->frequency_hz;
  if (carriers_hz.empty() ? groups->interval_s == 0 : !overlap(carriers_hz, session.sonar)) return;
  const double two_way_s = 2 * session.sonar.range_max_m / session.water.sound_speed_m_s;
  if (groups->interval_s >= two_way_s * (1 - kSameTime)) return;
  warnings.push_back(fmt::format(
      "sonar.transmit.interval_s: a group is sent {:.3g} s after the one before, but echoes from "
      "{:g} m (sonar.range_max_m) take {:.3g} s; the echoes of each group are computed alone{}",
      groups->interval_s, session.sonar.range_max_m, two_way_s,
      carriers_hz.empty() ? "" : ", although frequency_hz has bands that overlap"));
}

constexpr double kHeardDb = -20;

double level_db(const Sonar& sonar, double elevation_rad) {
  return 20 * std::log10(std::max(1e-10, std::abs(elevation_pattern(sonar, elevation_rad))));
}

// The largest angle, in steps of 0.1 degrees of the fan, at which the pattern exceeds -20 dB.
double heard_to_rad(const Sonar& sonar) {
  constexpr double kStepDeg = 0.05;
  for (double angle_deg = 90; angle_deg > 0; angle_deg -= kStepDeg) {
    if (level_db(sonar, radians(angle_deg)) > kHeardDb) return radians(angle_deg + kStepDeg);
  }
  return 0;
}

struct LeftOut {
  double near_m = 0, far_m = 0;
  std::size_t rays = 0;
};

// What rays beyond the fan meet at the first ping, where the pattern exceeds -20 dB.
std::map<std::uint32_t, LeftOut> left_out(const Session& session, const Tracer& tracer,
                                          double heard_rad, const Workers& workers) {
  Sonar wide = session.sonar;
  wide.elevation_fan_rad = std::min(kPi, 2 * heard_rad);
  wide.rays_elevation = 256;
  wide.rays_azimuth = 1;
  const Fan fan = make_fan(wide);
  const std::vector<Hit> hits = trace_fan(tracer.at(object_poses(session, 0)), fan,
                                          sonar_pose(session, 0), wide, session.water, workers)
                                    .hits;
  std::map<std::uint32_t, LeftOut> found;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const double elevation = std::abs(fan.elevation_rad[i % fan.elevation_rad.size()]);
    const Hit& hit = hits[i];
    if (elevation <= session.sonar.elevation_fan_rad / 2 || hit.instance == 0 ||
        hit.range_m < session.sonar.range_min_m || level_db(wide, elevation) <= kHeardDb) {
      continue;
    }
    LeftOut& of = found[hit.instance];
    of.near_m = of.rays == 0 ? hit.range_m : std::min(of.near_m, hit.range_m);
    of.far_m = std::max(of.far_m, hit.range_m);
    ++of.rays;
  }
  return found;
}

std::string left_out_text(const Session& session, const std::map<std::uint32_t, LeftOut>& found) {
  std::vector<std::pair<std::uint32_t, LeftOut>> most(found.begin(), found.end());
  std::ranges::stable_sort(
      most, [](const auto& a, const auto& b) { return a.second.rays > b.second.rays; });
  constexpr std::size_t kNamed = 3;
  std::string text;
  for (std::size_t i = 0; i < std::min(kNamed, most.size()); ++i) {
    const auto& [instance, of] = most[i];
    text += fmt::format("{}{} from {:.3g} to {:.3g} m", i == 0 ? "" : ", ",
                        session.world.instances[instance - 1].name, of.near_m, of.far_m);
  }
  if (most.size() > kNamed) text += fmt::format(" and {} more", most.size() - kNamed);
  return "at ping 0 " + text;
}

}  // namespace

Warnings key_warnings(const Session& session) {
  Warnings warnings;
  warn_of_two_waters(session.scenario.water, warnings);
  warn_of_density(session.scenario, warnings);
  warn_of_profile(session, warnings);
  warn_of_cells(session.sonar, warnings);
  warn_of_array(session, warnings);
  warn_of_reflectors(session, warnings);
  warn_of_times(session, warnings);
  warn_of_rate(session, warnings);
  warn_of_interval(session, warnings);
  return warnings;
}

Warnings fan_warnings(const Session& session, const Tracer& tracer, const Workers& workers) {
  const Sonar& sonar = session.sonar;
  const double edge_rad = sonar.elevation_fan_rad / 2, heard_rad = heard_to_rad(sonar);
  if (heard_rad <= edge_rad || edge_rad >= kPi / 2) return {};
  const auto missed = left_out(session, tracer, heard_rad, workers);
  if (missed.empty()) return {};
  double loudest_db = kHeardDb;
  for (double angle = edge_rad; angle < heard_rad; angle += radians(0.05)) {
    loudest_db = std::max(loudest_db, level_db(sonar, angle));
  }
  const double fan_deg = std::min(180.0, std::ceil(20 * degrees(heard_rad)) / 10);
  const double rays = std::ceil(sonar.rays_elevation * fan_deg / degrees(2 * edge_rad));
  return {fmt::format(
      "sonar.elevation.fan_deg: the fan ends at {:.3g} degrees of elevation, but the pattern of "
      "width_deg {:.3g} has up to {:.2g} dB beyond; it leaves out {}; fan_deg: {:g} with "
      "rays.elevation: {:g} has all above {:g} dB",
      degrees(edge_rad), degrees(sonar.elevation_width_rad), loudest_db,
      left_out_text(session, missed), fan_deg, rays, kHeardDb)};
}

Status check_groups(const Session& session) {
  const auto& groups = session.sonar.transmit;
  const std::vector<double>& times = session.ping_times_s;
  if (!groups || groups->count == 1 || session.scenario.output.selection.statistics ||
      times.size() < 2) {
    return {};
  }
  double shortest_s = times[1] - times[0];
  for (std::size_t i = 2; i < times.size(); ++i) {
    shortest_s = std::min(shortest_s, times[i] - times[i - 1]);
  }
  const double needed_s = groups->count * groups->interval_s;
  if (needed_s <= shortest_s * (1 + kSameTime)) return {};
  return Error{ErrorKind::usage,
               fmt::format("sonar.transmit.interval_s: {} groups every {:g} s need {:.4g} s, but a "
                           "ping follows {:.4g} s after the one before; expected at most {:g} s, "
                           "or a lower trajectory.ping_rate_hz",
                           groups->count, groups->interval_s, needed_s, shortest_s,
                           std::floor(1e6 * shortest_s / groups->count) / 1e6)};
}

Status check_ping_rate(const Session& session) {
  if (!session.scenario.motion_within_ping) return {};
  const std::string text = overlap_text(session);
  if (text.empty()) return {};
  return Error{ErrorKind::usage, text + ", or motion_within_ping: false"};
}

}  // namespace ensonify
