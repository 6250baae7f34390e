#include "app/object_looks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "app/pipeline.h"
#include "core/units.h"
#include "trace/refracted.h"
#include "world/outline.h"

namespace ensonify {
namespace {

bool is_within(const Sonar& sonar, Vec3 p) {
  const double range = length(p);
  const double azimuth = std::atan2(p.y, p.x), elevation = std::atan2(p.z, std::hypot(p.x, p.y));
  return range >= sonar.range_min_m && range <= sonar.range_max_m &&
         std::abs(azimuth) <= sonar.beam_count * sonar.beam_spacing_rad / 2 &&
         std::abs(elevation) <= sonar.elevation_fan_rad / 2;
}

// In the sonar's frame.
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
  const std::vector<Vec3> points = contact_points(object.shape);
  for (const Vec3& point : points) {
    const Vec3 world = pose.position_m + rotate(pose.rotation, point);
    look.share_in_fan += is_within(session.sonar, seen_from(sonar, world));
  }
  if (!points.empty()) look.share_in_fan /= static_cast<double>(points.size());
}

// By instance id.
std::vector<bool> grounds_of(const Session& session) {
  std::set<std::string> stood_on;
  for (const ObjectSpec& spec : session.scenario.objects) {
    if (spec.place) stood_on.insert(spec.place->on);
  }
  std::vector<bool> is_ground(session.world.instances.size() + 1);
  is_ground[0] = true;
  for (const WorldObject& object : session.world.objects) {
    const auto* mesh = std::get_if<MeshShape>(&object.shape);
    const auto* box = std::get_if<BoxShape>(&object.shape);
    const auto* sphere = std::get_if<SphereShape>(&object.shape);
    is_ground[object.instance] =
        std::holds_alternative<PlaneShape>(object.shape) || (mesh != nullptr && mesh->ground) ||
        (box != nullptr && box->inside) || (sphere != nullptr && sphere->inside) ||
        stood_on.contains(session.world.instances[object.instance - 1].name);
  }
  return is_ground;
}

struct MeanPower {
  double sum = 0;
  std::int64_t pixels = 0;
  void add(float level_db) {
    sum += level_db > kNoEnergyDb ? std::pow(10.0, level_db / 10.0) : 0;
    ++pixels;
  }
  std::optional<double> level_db() const {
    if (pixels == 0 || !(sum > 0)) return std::nullopt;
    return 10 * std::log10(sum / static_cast<double>(pixels));
  }
};

struct PixelBox {
  int top = INT32_MAX, bottom = -1, left = INT32_MAX, right = -1;
  void add(int row, int column) {
    top = std::min(top, row), bottom = std::max(bottom, row);
    left = std::min(left, column), right = std::max(right, column);
  }
};

PixelBox around(const PixelBox& box, const LabelledImage& image) {
  const int high = std::max(3, (box.bottom - box.top + 1) / 2);
  const int wide = std::max(3, (box.right - box.left + 1) / 2);
  return {std::max(0, box.top - high), std::min(image.rows - 1, box.bottom + high),
          std::max(0, box.left - wide), std::min(image.columns - 1, box.right + wide)};
}

template <class Use>
void for_pixels(const PixelBox& box, const LabelledImage& image, Use use) {
  for (int row = box.top; row <= box.bottom; ++row) {
    for (int column = box.left; column <= box.right; ++column) {
      use(row, column, static_cast<std::size_t>(row) * image.columns + column);
    }
  }
}

// `looks` of the session's objects, in their order.
void look_at_levels(const Session& session, const LabelledImage& image, double noise_power_pa2,
                    std::vector<ObjectLook>& looks) {
  const std::vector<bool> is_ground = grounds_of(session);
  std::vector<MeanPower> power(is_ground.size());
  std::vector<PixelBox> boxes(is_ground.size());
  for_pixels({0, image.rows - 1, 0, image.columns - 1}, image,
             [&](int row, int column, std::size_t pixel) {
               const std::uint16_t instance = image.instance[pixel];
               power[instance].add(image.clean_db[pixel]);
               boxes[instance].add(row, column);
             });
  for (std::size_t i = 0; i < looks.size(); ++i) {
    const std::uint32_t instance = session.world.objects[i].instance;
    const std::optional<double> level = power[instance].level_db();
    looks[i].pixels = power[instance].pixels;
    if (!level) continue;
    if (noise_power_pa2 > 0) {
      looks[i].over_noise_db = *level - (10 * std::log10(noise_power_pa2) + 120);
    }
    if (is_ground[instance]) continue;
    MeanPower ground;
    for_pixels(around(boxes[instance], image), image, [&](int, int, std::size_t pixel) {
      if (is_ground[image.instance[pixel]]) ground.add(image.clean_db[pixel]);
    });
    if (const auto around_it = ground.level_db()) looks[i].over_ground_db = *level - *around_it;
  }
}

std::string or_dash(const std::optional<double>& value) {
  return value ? fmt::format("{:.1f}", *value) : "-";
}

std::string where_text(const Session& session, const ObjectLook& look) {
  return fmt::format(
      "at ping 0 it is at range {:.3g} m, azimuth {:.3g} deg, elevation {:.3g} deg, with {:.0f} % of "
      "it in the fan of {:.3g} x {:.3g} deg from {:g} to {:g} m",
      look.range_m, degrees(look.azimuth_rad), degrees(look.elevation_rad),
      100 * look.share_in_fan, degrees(session.sonar.beam_count * session.sonar.beam_spacing_rad),
      degrees(session.sonar.elevation_fan_rad), session.sonar.range_min_m,
      session.sonar.range_max_m);
}

// Angles that would be large in radians, and are next to nothing in degrees.
bool looks_like_radians(const Scenario& scenario) {
  const auto* angles = std::get_if<std::array<double, 3>>(&scenario.sonar.mount.rotation);
  if (angles == nullptr) return false;
  double most = 0;
  for (const double angle : *angles) most = std::max(most, std::abs(angle));
  return most > 0 && most <= kPi + 0.01;
}

}  // namespace

Result<std::vector<ObjectLook>> look_at_objects(const Session& session, const Tracer& tracer,
                                                std::uint32_t sequence, const Numerics& numerics,
                                                const Workers& workers) {
  std::vector<ObjectLook> looks(session.world.objects.size());
  const std::vector<Pose> poses = object_poses(session, 0);
  for (std::size_t i = 0; i < looks.size(); ++i) {
    look_at_geometry(session, session.world.objects[i], poses[i], looks[i]);
  }
  SequenceInfo info = sequence_info(session, sequence, 0, 1);
  info.output = {};
  info.output.timeseries = info.output.cartesian = info.output.png = false;
  info.output.shadow = info.output.amodal = false;
  SharedParts shared;
  Result<ReadyPipeline> ready =
      make_pipeline(session, tracer, std::move(info), numerics, workers, shared, true);
  if (!ready) return ready.error();
  const double noise = ready->pipeline.info().noise_power_pa2;
  const PingResult ping = ready->pipeline.run(0, workers, std::move(ready->ping_zero));
  if (ping.polar) look_at_levels(session, *ping.polar, noise, looks);
  return looks;
}

std::vector<std::string> look_lines(const std::vector<ObjectLook>& looks) {
  constexpr std::size_t kMost = 24;
  std::size_t width = 6;
  for (const ObjectLook& look : looks) width = std::max(width, look.name.size());
  std::vector<std::string> lines;
  lines.push_back(fmt::format("{:<{}} {:>20} {:>8} {:>8} {:>9} {:>7} {:>7} {:>8} {:>8}", "object",
                              width, "size m", "range m", "azim deg", "elev deg", "in fan", "pixels",
                              "ground dB", "noise dB"));
  for (const ObjectLook& look : looks) {
    if (lines.size() > kMost) break;
    std::string size = "without end";
    if (const auto& s = look.size_m) size = fmt::format("{:.3g} x {:.3g} x {:.3g}", s->x, s->y, s->z);
    lines.push_back(fmt::format(
        "{:<{}} {:>20} {:>8.3g} {:>8.1f} {:>9.1f} {:>5.0f} % {:>7} {:>8} {:>8}", look.name, width,
        size, look.range_m, degrees(look.azimuth_rad), degrees(look.elevation_rad),
        100 * look.share_in_fan, look.pixels, or_dash(look.over_ground_db),
        or_dash(look.over_noise_db)));
  }
  if (looks.size() > kMost) lines.push_back(fmt::format("and {} more", looks.size() - kMost));
  return lines;
}

void note_seen(const Session& session, const Tracer& tracer, std::uint32_t sequence,
               const std::vector<ObjectLook>& looks, const Workers& workers, SeenObjects& seen) {
  std::set<std::uint32_t> met;
  const Fan fan = make_fan(session.sonar);
  const auto last = static_cast<std::uint32_t>(session.ping_times_s.size() - 1);
  const bool has_others = !session.world.point_targets.empty() || !session.world.volumes.empty() ||
                          !session.world.schools.empty();
  for (const std::uint32_t ping : std::set{0u, last / 2, last}) {
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
    if (seen.empty_pings.size() > 1) more = fmt::format(" and {} more", seen.empty_pings.size() - 1);
    warnings.push_back(fmt::format("{}{}: no ray of the fan meets anything in range{}",
                                   seen.empty_pings[0], more, radians));
  }
  for (const auto& [key, is_seen] : seen.is_seen) {
    if (is_seen) continue;
    warnings.push_back(
        fmt::format("{} is never in view: {}", key, seen.where.at(key)));
  }
  return warnings;
}

}  // namespace ensonify
