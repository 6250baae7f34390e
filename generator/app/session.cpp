#include "app/session.h"

#include <malloc.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "acoustics/pattern.h"
#include "acoustics/pulse.h"
#include "acoustics/water.h"
#include "app/array_receiver.h"
#include "app/covisibility.h"
#include "app/ensemble.h"
#include "app/layers.h"
#include "app/ping_echoes.h"
#include "app/ringing.h"
#include "app/scene_files.h"
#include "core/random.h"
#include "core/units.h"
#include "instrument/front_end.h"
#include "labels/cartesian.h"
#include "scenario/tables.h"
#include "synthesis/beamforming.h"
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

// The spectrum level over the band; a matched filter lowers it by its gain.
double noise_power_pa2(double spectrum_level_db, const Sonar& sonar) {
  return sonar.bandwidth_hz * mean_square_pa2(spectrum_level_db) / processing_gain(sonar);
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
      surface_tiles(session.world, {session.sonar, session.cell.range_m, seen_by}, Workers());
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

void remove_objects(Scenario& scenario, const std::vector<std::string>& names) {
  std::erase_if(scenario.objects, [&](const ObjectSpec& spec) {
    return std::find(names.begin(), names.end(), spec.name) != names.end();
  });
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
  // The resolution cell is needed only with a world; without one, computing it would take most of
  // the time.
  if (is_built) {
    session.cell = resolution_cell(session.sonar, session.water, session.record.transform);
  }
  Result<std::optional<ArrayReceiver>> array =
      array_receiver(scenario, session.sonar, session.water, session.record);
  if (!array) return array.error();
  session.sonar.array = std::move(*array);
  Result<std::vector<double>> times = ping_times(
      scenario.trajectory, *path,
      {stream_key(scenario.seed, Stream::dropped, sequence),
       scenario.sonar.recorder ? scenario.sonar.recorder->dropped : 0});
  if (!times) return times.error();

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
  if (Status can = check_motion(session); !can) return can.error();
  if (Status are = check_draws(session); !are) return are.error();
  if (Status few = check_covisibility(session); !few) return few.error();
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

SequenceInfo sequence_info(const Session& session, std::uint32_t sequence, std::uint32_t first_ping,
                           std::uint32_t last_ping) {
  const Scenario& scenario = session.scenario;
  SequenceInfo info;
  info.sequence = sequence;
  info.seed = scenario.seed;
  info.split = pick_split(scenario.splits, scenario.seed, sequence);
  info.sonar = session.sonar;
  info.water = session.water;
  info.record = session.record;
  info.synthesis_tolerance = scenario.synthesis_tolerance;
  info.speckle = scenario.scattering.speckle;
  info.motion_within_ping = scenario.motion_within_ping;
  info.receive_aperture_wavelengths =
      make_shaded_line(session.sonar.shading, session.sonar.beam_width_rad).aperture;
  if (session.sonar.array) {
    const ArrayGeometry array = make_array_geometry(session.sonar);
    info.element_y_m = array.y_m;
    info.element_weight = array.weight;
  }
  info.processing_gain = processing_gain(session.sonar);
  info.pulse_extent_s = pulse_extent_s(session.sonar);
  if (scenario.sonar.recorder && scenario.output.selection.pings) {
    info.recorder = scenario.sonar.recorder->recorder;
  }
  info.noise_correlated = scenario.noise_correlated;
  info.noise_snr_db = scenario.noise_snr_db;
  info.noise_spectrum_level_db = scenario.noise_spectrum_level_db;
  if (scenario.noise_spectrum_level_db) {
    info.noise_power_pa2 = noise_power_pa2(*scenario.noise_spectrum_level_db, session.sonar);
  }
  info.multipath = scenario.multipath;
  info.bounces = scenario.bounces;
  info.paths = scenario.multipath ? session.bounces.paths
                                  : bounce_paths(scenario.bounces, has_walls(scenario));
  info.draws = scenario.draws;
  info.placement = session.placement;
  info.instances = session.world.instances;
  info.classes = session.world.classes;
  if (scenario.output.selection.cartesian) {
    info.cartesian = cartesian_grid(session.sonar, scenario.output.cartesian_height_px);
  }
  info.output = scenario.output.selection;
  info.png = scenario.output.png;
  info.png.limits_db = scenario.output.png_db.value_or(info.png.limits_db);
  if (info.output.layers) {
    info.target_instances = target_instances(scenario);
    info.layers = layers_of(info);
  }
  info.sdf = scenario.output.sdf;
  if (scenario.output.height_map) info.height_map = height_map_grid(session);
  info.first_ping = first_ping;
  info.last_ping = last_ping;
  return info;
}

std::string pick_split(const SplitsSpec& splits, std::uint64_t seed, std::uint32_t sequence) {
  const double total = splits.train + splits.val + splits.test;
  const double draw = total * uniform(stream_key(seed, Stream::split, sequence), 0, 0, 0);
  if (draw < splits.train) return "train";
  return draw < splits.train + splits.val ? "val" : "test";
}

Pose sonar_pose(const Session& session, std::uint32_t ping) {
  return compose(pose_at(session.path, session.ping_times_s[ping]), session.mount);
}

std::vector<Pose> object_poses(const Session& session, std::uint32_t ping) {
  std::vector<Pose> poses;
  for (const WorldObject& object : session.world.objects) {
    poses.push_back(object_pose(object, session.ping_times_s[ping]));
  }
  return poses;
}

namespace {

constexpr double kShare = 0.05;

std::string undersampled_text(const Session& session, double share, const std::string& begin,
                              const std::string& advice) {
  return fmt::format(
      "ping 0: {}{:.0f} % of the surface in range has fewer than {:.0f} scatterers in a resolution "
      "cell ({:.2g} deg x {:.2g} m), so speckle is not fully developed there and gaps may be "
      "visible; {}",
      begin, 100 * share, kFewScatterers, degrees(session.cell.width_rad), session.cell.range_m,
      advice);
}

}  // namespace

std::vector<std::string> undersampled_warnings(const Session& session, const Tracer& tracer,
                                               const Workers& workers) {
  const Fan fan = make_fan(session.sonar);
  const Pose pose = sonar_pose(session, 0);
  const std::vector<Hit> hits = trace_fan(tracer.at(object_poses(session, 0)), fan, pose,
                                          session.sonar, session.water, workers)
                                    .hits;
  const auto share_of = [&](const Sonar& sonar) {
    return undersampled_share(sonar, session.cell, fan, hits, pose, kFewScatterers);
  };
  std::vector<std::string> warnings;
  const bool by_need = session.sonar.rays_per_cell > 0;
  // Scatterers fixed on surfaces are dense enough by themselves.
  const double share = session.surface_tiles ? 0 : share_of(session.sonar);
  if (share > kShare) {
    warnings.push_back(
        undersampled_text(session, share, "",
                          by_need ? "raise sonar.rays.elevation or sonar.rays.min_per_cell"
                                  : "sonar.rays.min_per_cell: 20 adds rays where they are needed"));
  }
  if (session.bounces.paths.empty() || (!by_need && !session.surface_tiles)) return warnings;
  Sonar of_fan = session.sonar;
  of_fan.rays_per_cell = 0;
  const double bounced = share_of(of_fan);
  if (bounced > kShare) {
    warnings.push_back(undersampled_text(
        session, bounced, "specular and multipath echoes use only the rays of the fan, with which ",
        "raise sonar.rays.elevation"));
  }
  return warnings;
}

}  // namespace ensonify
