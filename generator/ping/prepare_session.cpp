#include "ping/prepare_session.h"

#include <malloc.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "ping/camera.h"
#include "ping/covisibility.h"
#include "ping/key_warnings.h"
#include "ping/navigation_files.h"
#include "ping/ping_echoes.h"
#include "ping/prepare_sonar.h"
#include "ping/scene_files.h"
#include "ping/scene_warnings.h"
#include "trace/bounces.h"

namespace ensonify {
namespace {

// A specular reflector has sound on one side only.
Status check_in_water(const Session& session) {
  if (!session.scenario.multipath || !is_sonar(session.scenario)) return {};
  const auto& [surface, bottom, objects, bounces] = *session.scenario.multipath;
  for (std::uint32_t ping = 0; ping < session.ping_times_s.size(); ++ping) {
    const double z = sonar_pose(session, ping).position_m.z;
    const bool above = surface && z >= surface->z_m;
    if (!above && !(bottom && z <= bottom->z_m)) continue;
    const double z_m = above ? surface->z_m : bottom->z_m;
    return Error{ErrorKind::usage,
                 fmt::format("multipath.{0}.z_m: at ping {1} the sonar is at z = {2} m, {3} the "
                             "{0} at {4} m; expected a {0} {5} the sonar at every ping",
                             above ? "surface" : "bottom", ping, z,
                             above ? "not below" : "not above", z_m, above ? "above" : "below")};
  }
  return {};
}

void remove_objects(Scenario& scenario, const std::vector<std::string>& names) {
  std::erase_if(scenario.objects, [&](const ObjectSpec& spec) {
    return std::find(names.begin(), names.end(), spec.name) != names.end();
  });
}

// Differences that interpolation between equal poses may leave.
constexpr double kSamePlaceM = 1e-9, kSameTurn = 1 - 1e-14;

bool same_pose(const Pose& a, const Pose& b) {
  const double turn = a.rotation.w * b.rotation.w + a.rotation.x * b.rotation.x +
                      a.rotation.y * b.rotation.y + a.rotation.z * b.rotation.z;
  return length(a.position_m - b.position_m) <= kSamePlaceM && std::abs(turn) >= kSameTurn;
}

Error not_draws(const std::string& why, const char* accepted) {
  return {ErrorKind::usage, fmt::format("output.statistics: {}; expected {}", why, accepted)};
}

// With output.statistics.
Status check_draws(const Session& session) {
  if (!session.scenario.output.selection.statistics) return {};
  if (session.scenario.scattering.speckle != SpeckleMode::per_ping) {
    return not_draws(
        "the pings of a sequence must be independent realizations, but scattering.speckle makes "
        "them share one random pattern",
        "speckle per_ping");
  }
  if (session.sonar.transmit && session.sonar.transmit->level_error_db > 0) {
    return not_draws(
        "the pings of a sequence must be realizations of one scene, but "
        "sonar.transmit.level_error_db varies the levels between pings",
        "level_error_db: 0");
  }
  const Pose sonar = sonar_pose(session, 0);
  const std::vector<Pose> objects = object_poses(session, 0);
  for (std::uint32_t ping = 1; ping < session.ping_times_s.size(); ++ping) {
    const bool rests = same_pose(sonar_pose(session, ping), sonar);
    const std::vector<Pose> now = object_poses(session, ping);
    if (rests && std::equal(now.begin(), now.end(), objects.begin(), same_pose)) continue;
    return not_draws(
        fmt::format("the pings of a sequence must be realizations of one scene, but at ping {} {} "
                    "has moved",
                    ping, rests ? "an object" : "the sonar"),
        "everything at rest (for several places, sample the pose for each of several sequences)");
  }
  return {};
}

// What a sonar of the rig sees of the surfaces of the session's world.
SurfaceViews views_of(const Session& session, const Session& instrument,
                      std::vector<double> times_s) {
  const auto seen_by = [&session, mount = instrument.mount,
                        times = std::move(times_s)](std::size_t object) {
    std::vector<Pose> poses;
    for (const double time_s : times) {
      poses.push_back(pose_in(object_pose(session.world.objects[object], time_s),
                              compose(pose_at(session.path, time_s), mount)));
    }
    return poses;
  };
  return {instrument.sonar, instrument.cell.range_m, seen_by,
          even_spacing(instrument.sonar, instrument.water, instrument.record.transform)};
}

// Of all sonars, in the order of the rig, so that each has the same.
Result<std::vector<SurfaceViews>> all_views(const Session& session, std::uint32_t sequence) {
  std::vector<SurfaceViews> views;
  const Scenario& scenario = session.scenario;
  for (std::size_t i = 0; i < std::max<std::size_t>(1, scenario.rig.size()); ++i) {
    const bool is_own = scenario.rig.empty() || chosen_index(scenario) == i;
    Session other;
    std::vector<double> times_s = session.ping_times_s;
    if (!is_own) {
      const Scenario of_other = for_instrument(scenario, i);
      if (!is_sonar(of_other)) continue;
      const bool has_cell = !session.world.objects.empty();
      if (Status ready = prepare_sonar(of_other, has_cell, other); !ready) {
        return Error{ready.error().kind, in_rig(ready.error().message, i)};
      }
      auto times = times_of(of_other, session.path, sequence);
      if (!times) return times.error();
      times_s = std::move(*times);
    }
    views.push_back(views_of(session, is_own ? session : other, std::move(times_s)));
  }
  return views;
}

// Cuts surfaces for all pings of the sequence, whatever range is run.
Status cut_surfaces(std::uint32_t sequence, Session& session) {
  if (session.scenario.scattering.speckle != SpeckleMode::surface || !is_sonar(session.scenario)) {
    return {};
  }
  if (!session.surface_tiles) {
    const auto views = all_views(session, sequence);
    if (!views) return views.error();
    session.surface_tiles =
        std::make_shared<const SurfaceTiles>(surface_tiles(session.world, *views, Workers()));
  }
  const std::uint64_t leaves = most_surface_points(session);
  if (leaves <= kMostLeaves) return {};
  return Error{
      ErrorKind::usage,
      fmt::format(
          "scattering.speckle: surface needs {} scatterers in one ping; expected up to {}, by a "
          "shorter range_max_m, a wider beam, a longer pulse or a sonar farther from the surfaces",
          leaves, kMostLeaves)};
}

// What sessions of one scenario share, as far as it exists.
struct Shared {
  RingingLibrary* ringing = nullptr;
  std::shared_ptr<const SurfaceTiles> tiles = {};
};

Result<Session> prepare(Scenario scenario, std::uint32_t sequence, Result<World> world,
                        bool is_built, Shared shared = {}) {
  Session session;
  const Status sonar = prepare_sonar(scenario, is_built, session);
  Result<Path> path =
      load_path(scenario.trajectory,
                stream_key(scenario.seed, Stream::motion, SequenceDraw(sequence, scenario.redraw)));
  if (std::optional<Error> error = all_errors(sonar, world, path)) return *error;
  Result<std::vector<double>> times = times_of(scenario, *path, sequence);
  if (!times) return times.error();

  if (const std::string text = path_warning(*path); !text.empty()) {
    world->warnings.push_back("trajectory.file: " + text);
  }
  remove_objects(scenario, world->left_out);
  session.world = std::move(*world);
  ring_bodies(scenario, session.sonar, session.water, shared.ringing, session.world);
  session.path = std::move(*path);
  session.ping_times_s = std::move(*times);
  session.scenario = std::move(scenario);
  session.surface_tiles = std::move(shared.tiles);
  if (Status fits = check_scene_files(session); !fits) return fits.error();
  Result<BouncePlan> bounces =
      make_bounce_plan(session.scenario.multipath, flat_reflectors(session.scenario));
  if (!bounces) return bounces.error();
  session.bounces = std::move(*bounces);
  for (const auto check : {check_in_water, check_mount}) {
    if (Status status = check(session); !status) return status.error();
  }
  if (Status fits = cut_surfaces(sequence, session); !fits) return fits.error();
  if (is_sonar(session.scenario)) {
    for (const auto check :
         {check_motion, check_ping_rate, check_groups, check_draws, check_covisibility}) {
      if (Status status = check(session); !status) return status.error();
    }
  }
  for (const auto check : {check_navigation, check_camera}) {
    if (Status status = check(session); !status) return status.error();
  }
  return session;
}

}  // namespace

void give_back_import(const World& world) {
  constexpr std::size_t kLargeMesh = 100'000;
  for (const WorldObject& object : world.objects) {
    const auto* shape = std::get_if<MeshShape>(&object.shape);
    if (shape == nullptr || shape->mesh->triangles.size() < kLargeMesh) continue;
    malloc_trim(0);
    return;
  }
}

Result<Session> prepare_session(Scenario scenario, std::uint32_t sequence, SharedWorlds* shared) {
  Result<World> world =
      build_world(scenario, sequence, shared != nullptr ? &shared->meshes : nullptr);
  if (world) give_back_import(*world);
  return prepare(std::move(scenario), sequence, std::move(world), true,
                 {shared != nullptr ? &shared->ringing : nullptr});
}

Result<Session> prepare_in_world(Scenario scenario, std::uint32_t sequence, Result<World> world,
                                 std::shared_ptr<const SurfaceTiles> tiles,
                                 RingingLibrary* ringing) {
  return prepare(std::move(scenario), sequence, std::move(world), true,
                 {ringing, std::move(tiles)});
}

Result<Session> prepare_without_world(Scenario scenario, std::uint32_t sequence) {
  World world = empty_world(scenario);
  return prepare(std::move(scenario), sequence, std::move(world), false);
}

namespace {

using Counts = std::map<std::string, std::uint64_t>;  // objects to be placed, by class

Counts placed_counts(const Scenario& scenario) {
  Counts counts;
  for (const ObjectSpec& spec : scenario.objects) counts[spec.class_name] += spec.place.has_value();
  std::erase_if(counts, [](const auto& entry) { return entry.second == 0; });
  return counts;
}

std::optional<Placement> placement_of(const Session& session, const Counts& first) {
  const Counts kept = placed_counts(session.scenario);
  if (kept.empty() && first.empty()) return std::nullopt;
  Placement placement{session.scenario.redraw, {}, session.world.left_out};
  Counts names = first;
  names.insert(kept.begin(), kept.end());
  const auto count_in = [](const Counts& counts, const std::string& name) {
    const auto found = counts.find(name);
    return found == counts.end() ? 0 : found->second;
  };
  for (const auto& [name, count] : names) {
    placement.classes.push_back({name, count_in(first, name), count_in(kept, name)});
  }
  return placement;
}

Error without_room(const Error& error) {
  return {ErrorKind::incomplete,
          fmt::format("{}; the sequence was sampled {} times", error.message, kMostRedraws + 1)};
}

}  // namespace

Result<Session> drawn_session(const DrawSteps& steps, std::uint32_t sequence) {
  Counts first;
  for (std::uint32_t redraw = 0;; ++redraw) {
    Result<Scenario> scenario = steps.scenario({sequence, redraw});
    if (!scenario) return scenario.error();
    if (redraw == 0) first = placed_counts(*scenario);
    Result<Session> session = steps.session(std::move(*scenario), sequence);
    if (session) {
      session->placement = placement_of(*session, first);
      return session;
    }
    if (session.error().kind != ErrorKind::redraw) return session.error();
    if (redraw == kMostRedraws) return without_room(session.error());
  }
}

}  // namespace ensonify
