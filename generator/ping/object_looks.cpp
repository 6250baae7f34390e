#include "ping/object_looks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "core/units.h"
#include "ping/pipeline.h"
#include "ping/scene_warnings.h"
#include "ping/sequence_info.h"
#include "trace/refracted.h"
#include "trace/truncation.h"

namespace ensonify {
namespace {

// In the frame of the sonar.
Vec3 seen_from(const Pose& sonar, Vec3 p) {
  return rotate(conjugate(sonar.rotation), p - sonar.position_m);
}

void look_at_geometry(const Session& session, const WorldObject& object, const Pose& pose,
                      ObjectLook& look) {
  const Pose sonar = sonar_pose(session, 0);
  const Instance& instance = session.world.instances[object.instance - 1];
  look.name = instance.name;
  Vec3 middle = pose.position_m;
  if (instance.box) {
    look.size_m = instance.box->size_m;
    middle = compose(pose, instance.box->pose).position_m;
  }
  const Vec3 p = seen_from(sonar, middle);
  look.range_m = length(p);
  look.azimuth_rad = std::atan2(p.y, p.x);
  look.elevation_rad = std::atan2(p.z, std::hypot(p.x, p.y));
  const double truncated =
      truncated_share(surface_samples(object.shape), pose, sonar, session.sonar);
  if (std::isfinite(truncated)) look.share_in_fan = 1 - truncated;
}

// Mean expected power over the pixels of an instance, dB re 1 uPa; empty if it has none.
std::optional<double> level_db(const LabelledImage& image, std::uint32_t instance) {
  double sum = 0, pixels = 0;
  for (std::size_t i = 0; i < image.instance.size(); ++i) {
    if (image.instance[i] != instance) continue;
    sum += image.clean_db[i] > kNoEnergyDb ? std::pow(10.0, image.clean_db[i] / 10.0) : 0;
    ++pixels;
  }
  if (!(sum > 0)) return std::nullopt;
  return 10 * std::log10(sum / pixels);
}

void add_levels(const PingResult& ping, double noise_power_pa2, std::uint32_t instance,
                ObjectLook& look) {
  const auto annotation =
      std::find_if(ping.polar_annotations.begin(), ping.polar_annotations.end(),
                   [&](const Annotation& of) { return of.instance == instance; });
  if (annotation == ping.polar_annotations.end()) return;
  look.pixels = annotation->area;
  const double contrast = annotation->measures.contrast_db;
  if (std::isfinite(contrast)) look.over_ground_db = contrast;
  const auto level = level_db(*ping.polar, instance);
  if (level && noise_power_pa2 > 0) {
    look.over_noise_db = *level - (10 * std::log10(noise_power_pa2) + 120);
  }
}

std::string or_dash(const std::optional<double>& value) {
  return value ? fmt::format("{:.1f}", *value) : "-";
}

// A small share is not printed as none. That of an infinite surface has no meaning.
std::string share_text(const std::optional<double>& share) {
  if (!share) return "-";
  return *share > 0 && *share < 0.005 ? "<1 %" : fmt::format("{:.0f} %", 100 * *share);
}

std::string where_text(const Session& session, const ObjectLook& look) {
  const std::string share =
      look.share_in_fan ? share_text(look.share_in_fan) + " of its surface" : "an infinite surface";
  const std::string why = look.share_in_fan > 0.0 ? "; it is hidden or lies between the rays" : "";
  return fmt::format(
      "at ping 0 it is at range {:.3g} m, azimuth {:.3g} deg, elevation {:.3g} deg, with {} in the "
      "fan of {:.3g} x {:.3g} deg from {:g} to {:g} m{}",
      look.range_m, degrees(look.azimuth_rad), degrees(look.elevation_rad), share,
      degrees(session.sonar.beam_count * session.sonar.beam_spacing_rad),
      degrees(session.sonar.elevation_fan_rad), session.sonar.range_min_m,
      session.sonar.range_max_m, why);
}

// Angles that would be large in radians but are tiny in degrees.
bool looks_like_radians(const Scenario& scenario) {
  const auto* angles = std::get_if<std::array<double, 3>>(&scenario.sonar.mount.rotation);
  if (angles == nullptr) return false;
  double most = 0;
  for (const double angle : *angles) most = std::max(most, std::abs(angle));
  return most > 0 && most <= kPi + 0.01;
}

}  // namespace

std::vector<ObjectLook> looks_at(const Session& session, const PingResult& ping_zero,
                                 double noise_power_pa2) {
  std::vector<ObjectLook> looks(session.world.objects.size());
  const std::vector<Pose> poses = object_poses(session, 0);
  for (std::size_t i = 0; i < looks.size(); ++i) {
    const WorldObject& object = session.world.objects[i];
    look_at_geometry(session, object, poses[i], looks[i]);
    add_levels(ping_zero, noise_power_pa2, object.instance, looks[i]);
  }
  return looks;
}

Result<std::vector<ObjectLook>> look_at_objects(const Session& session, const Tracer& tracer,
                                                std::uint32_t sequence, const Numerics& numerics,
                                                const Workers& workers) {
  SequenceInfo info = sequence_info(session, sequence, 0, 1);
  info.output = {};
  info.output.timeseries = info.output.cartesian = info.output.png = false;
  info.output.shadow = info.output.amodal = false;
  SharedParts shared;
  Result<ReadyPipeline> ready =
      make_pipeline(session, tracer, std::move(info), numerics, workers, shared, true);
  if (!ready) return ready.error();
  const PingResult ping = ready->pipeline.run(0, workers, std::move(ready->ping_zero));
  return looks_at(session, ping, ready->pipeline.info().noise_power_pa2);
}

std::vector<std::string> look_lines(const std::vector<ObjectLook>& looks) {
  constexpr std::size_t kMost = 24;
  std::size_t width = 6;
  for (const ObjectLook& look : looks) width = std::max(width, look.name.size());
  std::vector<std::string> lines;
  lines.push_back(fmt::format("{:<{}} {:>20} {:>8} {:>8} {:>9} {:>7} {:>7} {:>8} {:>8}", "object",
                              width, "size m", "range m", "azim deg", "elev deg", "in fan",
                              "pixels", "ground dB", "noise dB"));
  for (const ObjectLook& look : looks) {
    if (lines.size() > kMost) break;
    std::string size = "infinite";
    if (const auto& s = look.size_m)
      size = fmt::format("{:.3g} x {:.3g} x {:.3g}", s->x, s->y, s->z);
    lines.push_back(
        fmt::format("{:<{}} {:>20} {:>8.3g} {:>8.1f} {:>9.1f} {:>7} {:>7} {:>8} {:>8}",
                    look.name, width, size, look.range_m, degrees(look.azimuth_rad),
                    degrees(look.elevation_rad), share_text(look.share_in_fan), look.pixels,
                    or_dash(look.over_ground_db), or_dash(look.over_noise_db)));
  }
  if (looks.size() > kMost) lines.push_back(fmt::format("and {} more", looks.size() - kMost));
  return lines;
}

void note_seen(const Session& session, const Tracer& tracer, std::uint32_t sequence,
               const std::vector<ObjectLook>& looks, const Workers& workers, SeenObjects& seen) {
  std::set<std::uint32_t> met;
  const Fan fan = make_fan(session.sonar);
  const bool has_others = !session.world.point_targets.empty() || !session.world.volumes.empty() ||
                          !session.world.schools.empty() || is_empty_scene(session);
  for (const std::uint32_t ping : distinct_pings(session)) {
    const auto hits = trace_fan(tracer.at(object_poses(session, ping)), fan,
                                sonar_pose(session, ping), session.sonar, session.water, workers)
                          .hits;
    bool is_empty = !has_others;
    for (const Hit& hit : hits) {
      const bool is_heard = hit.instance != 0 && hit.range_m >= session.sonar.range_min_m &&
                            hit.range_m <= session.sonar.range_max_m;
      if (!is_heard) continue;
      is_empty = false;
      met.insert(hit.instance);
    }
    if (is_empty) seen.empty_pings.push_back(fmt::format("ping {} of sequence {}", ping, sequence));
  }
  for (std::size_t i = 0; i < looks.size(); ++i) {
    const std::uint32_t instance = session.world.objects[i].instance;
    const Instance& of = session.world.instances[instance - 1];
    const std::string key = session.scenario.has_draws ? "class " + of.class_name : of.name;
    const bool is_met = met.contains(instance) || looks[i].pixels > 0;
    seen.is_seen[key] = seen.is_seen[key] || is_met;
    if (!is_met) seen.where.emplace(key, where_text(session, looks[i]));
  }
}

std::vector<std::string> unseen_warnings(const SeenObjects& seen, const Scenario& scenario) {
  std::vector<std::string> warnings;
  const std::string radians =
      looks_like_radians(scenario) ? "; sonar.mount.rotation_deg is in degrees" : "";
  if (!seen.empty_pings.empty()) {
    std::string more;
    if (seen.empty_pings.size() > 1)
      more = fmt::format(" and {} more", seen.empty_pings.size() - 1);
    warnings.push_back(fmt::format("{}{}: no ray of the fan hits anything in range{}",
                                   seen.empty_pings[0], more, radians));
  }
  for (const auto& [key, is_seen] : seen.is_seen) {
    if (is_seen) continue;
    warnings.push_back(fmt::format("{} is never in view: {}", key, seen.where.at(key)));
  }
  return warnings;
}

}  // namespace ensonify
