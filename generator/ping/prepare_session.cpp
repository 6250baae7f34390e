#include "ping/prepare_session.h"

#include <malloc.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "acoustics/pattern.h"
#include "acoustics/propagation.h"
#include "acoustics/pulse.h"
#include "core/units.h"
#include "instrument/detector.h"
#include "instrument/front_end.h"
#include "ping/array_receiver.h"
#include "ping/camera.h"
#include "ping/covisibility.h"
#include "ping/key_warnings.h"
#include "ping/navigation_files.h"
#include "ping/ping_echoes.h"
#include "ping/scene_files.h"
#include "scenario/tables.h"
#include "trace/bounces.h"

namespace ensonify {
namespace {

Water water_of(const WaterSpec& spec, double frequency_hz) {
  Water water;
  water.density_kg_m3 = spec.density_kg_m3;
  water.sound_speed_m_s = spec.sound_speed_m_s;
  if (const auto& from = spec.sound_speed_from) {
    water.sound_speed_m_s =
        sound_speed_m_s({from->temperature_c, from->salinity_psu, 8, from->depth_m});
  }
  if (const auto* fixed = std::get_if<FixedAbsorptionSpec>(&spec.absorption)) {
    water.absorption_db_m = fixed->db_m;
  } else {
    const auto& sea = std::get<SeaAbsorptionSpec>(spec.absorption);
    const SeaWater sea_water{sea.temperature_c, sea.salinity_psu, sea.ph, sea.depth_m};
    water.absorption_db_m = sea.model == AbsorptionModel::francois_garrison
                                ? francois_garrison_db_m(frequency_hz, sea_water)
                                : ainslie_mccolm_db_m(frequency_hz, sea_water);
  }
  return water;
}

Result<std::optional<SoundProfile>> profile_of(const WaterSpec& spec) {
  if (!spec.profile) return std::optional<SoundProfile>();
  SoundProfile profile{0, spec.profile->depth_m, spec.profile->sound_speed_m_s};
  if (!spec.profile->file.empty()) {
    auto loaded = load_sound_profile(spec.profile->file);
    if (!loaded) {
      return Error{loaded.error().kind, "water.profile.file: " + loaded.error().message};
    }
    profile = std::move(*loaded);
  }
  profile.surface_z_m = spec.profile->surface_z_m;
  return std::optional(std::move(profile));
}

Result<std::vector<PulseTableRow>> pulse_table_of(const Scenario& scenario, const Sonar& sonar) {
  if (sonar.pulse.shape != PulseShape::table) return std::vector<PulseTableRow>();
  auto table = load_pulse_table(scenario.sonar.pulse.file, sonar);
  if (table) return table;
  return Error{table.error().kind, "sonar.pulse.table.file: " + table.error().message};
}

// Collects the errors of all results, one per line.
template <class... T>
std::optional<Error> all_errors(const Result<T>&... results) {
  std::optional<Error> all;
  const auto add = [&](const auto& result) {
    if (result) return;
    if (!all) {
      all = result.error();
    } else {
      all->message += "\n" + result.error().message;
    }
  };
  (add(results), ...);
  return all;
}

// A specular reflector has sound on one side only.
Status check_in_water(const Session& session) {
  if (!session.scenario.multipath) return {};
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

// Cuts surfaces for all pings of the sequence, whatever range is run.
Status cut_surfaces(Session& session) {
  if (session.scenario.scattering.speckle != SpeckleMode::surface) return {};
  std::vector<Pose> sonar_in_world;
  for (std::uint32_t ping = 0; ping < session.ping_times_s.size(); ++ping) {
    sonar_in_world.push_back(sonar_pose(session, ping));
  }
  const auto seen_by = [&](std::size_t object) {
    std::vector<Pose> poses;
    for (std::size_t ping = 0; ping < sonar_in_world.size(); ++ping) {
      poses.push_back(
          pose_in(object_pose(session.world.objects[object], session.ping_times_s[ping]),
                  sonar_in_world[ping]));
    }
    return poses;
  };
  session.surface_tiles =
      surface_tiles(session.world,
                    {session.sonar, session.cell.range_m, seen_by,
                     even_spacing(session.sonar, session.water, session.record.transform)},
                    Workers());
  const std::uint64_t leaves = session.surface_tiles->most_leaves;
  if (leaves <= kMostLeaves) return {};
  return Error{
      ErrorKind::usage,
      fmt::format(
          "scattering.speckle: surface needs {} scatterers in one ping; expected up to {}, by a "
          "shorter range_max_m, a wider beam, a longer pulse or a sonar farther from the surfaces",
          leaves, kMostLeaves)};
}

void set_beam_responses(const Scenario& scenario, Sonar& sonar) {
  if (!scenario.sonar.electronics) return;
  const double gain_db = scenario.sonar.electronics->beam_gain_error_db;
  const double phase_rad = radians(scenario.sonar.electronics->beam_phase_error_deg);
  if (gain_db == 0 && phase_rad == 0) return;
  sonar.front_end->beam_response =
      beam_responses(scenario.seed, sonar.beam_count, gain_db, phase_rad);
}

// Cells of looks that would be longer than this part of the record are refused.
constexpr double kLongestCell = 0.25;

// Of the narrowest sub-band, in samples.
double longest_cell(const Session& session, int looks) {
  const auto borders = sub_band_borders(session.sonar, looks, session.record.transform);
  double longest = 0;
  for (std::size_t k = 1; k < borders.size(); ++k) {
    longest = std::max(longest, 1 / (borders[k] - borders[k - 1]));
  }
  return longest;
}

Status check_looks(const Session& session) {
  const auto& detector = session.sonar.detector;
  if (!detector || detector->looks == 1) return {};
  const double most = kLongestCell * session.record.samples;
  const double cell = longest_cell(session, detector->looks);
  if (cell <= most) return {};
  int possible = detector->looks - 1;
  while (possible > 1 && longest_cell(session, possible) > most) --possible;
  const double step_m = range_step_m(session.sonar, session.water);
  return Error{
      ErrorKind::usage,
      fmt::format("sonar.detector.looks: in {} sub-bands of the pulse a range cell is "
                  "{:.3g} m long, more than a quarter of the record of {:.3g} m; expected "
                  "at most {}, or a higher bandwidth_hz",
                  detector->looks, cell * step_m, session.record.samples * step_m, possible)};
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

Result<Session> prepare(Scenario scenario, std::uint32_t sequence, Result<World> world,
                        bool is_built, RingingLibrary* ringing = nullptr) {
  Session session;
  session.sonar = sonar_of(scenario);
  session.sonar.elevation_line =
      make_shaded_line(session.sonar.elevation_line.shading, session.sonar.elevation_width_rad);
  set_beam_responses(scenario, session.sonar);
  session.water = water_of(scenario.water, session.sonar.frequency_hz);
  session.mount = pose_of(scenario.sonar.mount);

  Result<std::vector<PulseTableRow>> pulse = pulse_table_of(scenario, session.sonar);
  Result<std::optional<SoundProfile>> profile = profile_of(scenario.water);
  Result<Path> path =
      load_path(scenario.trajectory,
                stream_key(scenario.seed, Stream::motion, SequenceDraw(sequence, scenario.redraw)));
  if (std::optional<Error> error = all_errors(pulse, profile, world, path)) return *error;
  session.sonar.pulse.table = std::move(*pulse);
  session.water.profile = std::move(*profile);
  session.record = make_record(session.sonar, session.water, pulse_extent_s(session.sonar));
  if (!pulse_is_heard(session.sonar, session.record.transform)) {
    return Error{ErrorKind::usage,
                 "sonar.pulse.table.file: the amplitudes are zero at every bin of the record; "
                 "expected a table with amplitudes above zero across the band"};
  }
  if (Status can = check_looks(session); !can) return can.error();
  // The resolution cell is needed only with a world; without one, computing it would take most of
  // the time.
  if (is_built) {
    session.cell = resolution_cell(session.sonar, session.water, session.record.transform);
  }
  Result<std::optional<ArrayReceiver>> array =
      array_receiver(scenario, session.sonar, session.water, session.record);
  if (!array) return array.error();
  session.sonar.array = std::move(*array);
  Result<std::vector<double>> times =
      ping_times(scenario.trajectory, *path,
                 {stream_key(scenario.seed, Stream::dropped, sequence),
                  scenario.sonar.recorder ? scenario.sonar.recorder->dropped : 0});
  if (!times) return times.error();

  if (const std::string text = path_warning(*path); !text.empty()) {
    world->warnings.push_back("trajectory.file: " + text);
  }
  remove_objects(scenario, world->left_out);
  session.world = std::move(*world);
  ring_bodies(scenario, session.sonar, session.water, ringing, session.world);
  session.path = std::move(*path);
  session.ping_times_s = std::move(*times);
  session.scenario = std::move(scenario);
  if (Status fits = check_scene_files(session); !fits) return fits.error();
  Result<BouncePlan> bounces =
      make_bounce_plan(session.scenario.multipath, flat_reflectors(session.scenario));
  if (!bounces) return bounces.error();
  session.bounces = std::move(*bounces);
  if (Status in_water = check_in_water(session); !in_water) return in_water.error();
  if (Status fits = cut_surfaces(session); !fits) return fits.error();
  for (const auto check : {check_motion, check_ping_rate, check_groups, check_draws,
                           check_covisibility, check_navigation, check_camera}) {
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
                 shared != nullptr ? &shared->ringing : nullptr);
}

Result<Session> prepare_in_world(Scenario scenario, std::uint32_t sequence, Result<World> world) {
  return prepare(std::move(scenario), sequence, std::move(world), true);
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
