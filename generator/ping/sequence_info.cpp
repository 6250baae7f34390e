#include "ping/sequence_info.h"

#include <utility>

#include "acoustics/pattern.h"
#include "acoustics/pulse.h"
#include "core/random.h"
#include "core/units.h"
#include "labels/cartesian.h"
#include "ping/camera.h"
#include "ping/layers.h"
#include "ping/scene_files.h"
#include "synthesis/beamforming.h"
#include "trace/bounces.h"

namespace ensonify {
namespace {

// The spectrum level over the band; a matched filter lowers it by its gain.
double noise_power_pa2(double spectrum_level_db, const Sonar& sonar) {
  return sonar.bandwidth_hz * mean_square_pa2(spectrum_level_db) / processing_gain(sonar);
}

void set_elements(const Sonar& sonar, SequenceInfo& info) {
  if (!sonar.array) return;
  const ArrayGeometry array = make_array_geometry(sonar);
  info.element_y_m = array.y_m;
  info.element_weight = array.weight;
}

// Leaves what an instrument has that is not a sonar.
SequenceInfo without_sonar(SequenceInfo info) {
  const SequenceInfo none;
  info.sonar = none.sonar;
  info.record = none.record;
  info.recorder.reset();
  info.noise_snr_db.reset();
  info.noise_spectrum_level_db.reset();
  info.noise_power_pa2 = 0;
  info.multipath.reset();
  info.bounces = 0;
  info.paths.clear();
  return info;
}

}  // namespace

SequenceInfo sequence_info(const Session& session, std::uint32_t sequence, std::uint32_t first_ping,
                           std::uint32_t last_ping) {
  const Scenario& scenario = session.scenario;
  SequenceInfo info;
  info.sequence = sequence;
  info.seed = scenario.seed;
  info.speckle_seed = scenario.speckle_seed;
  info.instrument_seed = instrument_seed(scenario);
  info.split = pick_split(scenario.splits, scenario.seed, sequence);
  info.sonar = session.sonar;
  info.water = session.water;
  info.record = session.record;
  info.synthesis_tolerance = scenario.synthesis_tolerance;
  info.speckle = scenario.scattering.speckle;
  info.motion_within_ping = scenario.motion_within_ping;
  info.receive_aperture_wavelengths =
      make_shaded_line(session.sonar.shading, session.sonar.beam_width_rad).aperture;
  set_elements(session.sonar, info);
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
  if (scenario.navigation) info.navigation = {*scenario.navigation, session.mount};
  if (info.output.any_camera()) info.camera = camera_of(scenario);
  info.first_ping = first_ping;
  info.last_ping = last_ping;
  info.instrument = instrument_kind(scenario);
  if (!scenario.rig.empty()) info.mount = session.mount;
  if (!is_sonar(info)) return without_sonar(std::move(info));
  return info;
}

std::string pick_split(const SplitsSpec& splits, std::uint64_t seed, std::uint32_t sequence) {
  const double total = splits.train + splits.val + splits.test;
  const double draw = total * uniform(stream_key(seed, Stream::split, sequence), 0, 0, 0);
  if (draw < splits.train) return "train";
  return draw < splits.train + splits.val ? "val" : "test";
}

}  // namespace ensonify
