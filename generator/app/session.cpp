#include "app/session.h"

#include "acoustics/pulse.h"
#include "acoustics/water.h"
#include "core/random.h"
#include "core/units.h"
#include "labels/cartesian.h"

namespace ensonify {
namespace {

Water water_of(const WaterSpec& spec, double frequency_hz) {
  Water water;
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

}  // namespace

Result<Session> prepare_session(Scenario scenario) {
  Session session;
  session.sonar = sonar_of(scenario);
  session.water = water_of(scenario.water, session.sonar.frequency_hz);
  session.record = make_record(session.sonar, session.water, pulse_extent_s(session.sonar));
  if (scenario.noise_spectrum_level_db) {
    session.noise_power_pa2 =
        session.sonar.bandwidth_hz * mean_square_pa2(*scenario.noise_spectrum_level_db);
  }
  session.mount = pose_of(scenario.sonar.mount);

  Result<World> world = build_world(scenario);
  Result<Path> path = load_path(scenario.trajectory);
  if (!world && !path) {
    return Error{ErrorKind::usage, world.error().message + "\n" + path.error().message};
  }
  if (!world) return world.error();
  if (!path) return path.error();
  Result<std::vector<double>> times = ping_times(scenario.trajectory, *path);
  if (!times) return times.error();

  session.world = std::move(*world);
  session.path = std::move(*path);
  session.ping_times_s = std::move(*times);
  session.scenario = std::move(scenario);
  return session;
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
  info.speckle = scenario.scattering.speckle;
  info.noise_spectrum_level_db = scenario.noise_spectrum_level_db;
  info.instances = session.world.instances;
  info.classes = session.world.classes;
  if (scenario.output.selection.cartesian) {
    info.cartesian = cartesian_grid(session.sonar, scenario.output.cartesian_height_px);
  }
  info.output = scenario.output.selection;
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

}  // namespace ensonify
