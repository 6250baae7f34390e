#include "ping/pipeline.h"

#include <cmath>
#include <utility>

#include "acoustics/refraction.h"
#include "camera/flow.h"
#include "camera/view.h"
#include "core/stage_times.h"
#include "instrument/front_end.h"
#include "labels/elevation.h"
#include "labels/polar.h"
#include "ping/camera.h"
#include "ping/group_echoes.h"
#include "ping/layers.h"
#include "ping/ping_series.h"
#include "synthesis/draw.h"
#include "trace/echo_points.h"

namespace ensonify {
namespace {

bool only_level(const OutputSelection& output) {
  return has_pictures(output) && !output.any_timeseries() && !output.layers;
}

PingEchoes echoes_of(const PingSetup& setup, std::uint32_t ping, bool with_hidden,
                     const Workers& workers) {
  const Session& session = setup.session;
  const OutputSelection& output = setup.info.output;
  const Tracer tracer = setup.tracer.at(object_poses(session, ping));
  return ping_echoes({session, setup.tables->fan, setup.scattering, tracer, ping,
                      sonar_pose(session, ping), with_hidden, places_key(setup.info), output.front,
                      output.elevation && output.elevation_volumes ? output.elevation_step_rad : 0},
                     workers);
}

// They transmit from one pose unless the sonar moves in the ping.
std::vector<FiredGroup> fired_groups(const PingSetup& setup, std::uint32_t ping) {
  const Session& session = setup.session;
  std::vector<FiredGroup> groups;
  if (!session.sonar.transmit) return groups;
  const std::vector<double> levels_db =
      group_levels_db(session.sonar, {device_seed(setup.info), setup.info.sequence, ping, 0});
  const bool in_turn = transmit_in_turn(session);
  for (int group = 0; group < group_count(session.sonar); ++group) {
    const double time_s = session.ping_times_s[ping] + fired_after_s(session.sonar, group);
    groups.push_back({time_s, levels_db.empty() ? 0 : levels_db[static_cast<std::size_t>(group)],
                      in_turn ? sonar_pose_at(session, time_s) : sonar_pose(session, ping)});
  }
  return groups;
}

std::vector<float> first_return_of(const Session& session, const PingEchoes& echoes) {
  const bool by_delay = bends(session.water) || moves(session);
  return first_return_m(echoes.scatterers, session.sonar.beam_count,
                        by_delay ? session.water.sound_speed_m_s : 0);
}

ReceivedParts received_parts(const PingSetup& setup, const PingEchoes& echoes, std::uint32_t ping) {
  return {setup.session, setup.info, *setup.tables, echoes, ping};
}

// The mean over pixels with an echo; 0 if there are none.
double mean_clean_pa2(const PingSetup& setup, const PingEchoes& echoes, const PingSeries& series) {
  const Session& session = setup.session;
  const std::vector<std::uint8_t> hears =
      hears_echo(echoes.scatterers, echoes.volumes, session.sonar.bandwidth_hz,
                 session.sonar.beam_count, session.record.samples);
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < hears.size(); ++i) {
    if (hears[i] == 0) continue;
    sum += series.clean_power_pa2[i];
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

Result<double> noise_power_of_snr(const SequenceInfo& info, double clean_pa2) {
  if (clean_pa2 > 0) return clean_pa2 / std::pow(10.0, *info.noise_snr_db / 10.0);
  return Error{ErrorKind::usage,
               "noise.snr_db: ping 0 has no echo as a reference for the noise; expected an echo in "
               "ping 0, or noise.spectrum_level_db"};
}

FrontView front_of(const PingSetup& setup, FrontView view) {
  for (std::size_t i = 0; i < view.instance.size(); ++i) {
    view.semantic[i] = setup.class_of_instance[view.instance[i]];
  }
  return view;
}

CameraView camera_of_ping(const PingSetup& setup, std::uint32_t ping, const Workers& workers) {
  const StageTimer timer(workers, Stage::labels);
  const Camera& camera = *setup.info.camera;
  const Session& session = setup.session;
  const std::vector<Pose> objects = object_poses(session, ping);
  const Tracer tracer = setup.tracer.at(objects);
  CameraShot shot{camera,
                  setup.tables->camera_rays,
                  tracer,
                  camera_pose(session, camera, ping),
                  setup.class_of_instance,
                  setup.camera_colors};
  const OutputSelection& output = setup.info.output;
  CameraView view = camera_view(shot, output, workers);
  const bool has_next = ping + 1 < session.ping_times_s.size();
  if (output.camera_flow && has_next) {
    add_flow(shot,
             {camera_pose(session, camera, ping + 1), objects, object_poses(session, ping + 1)},
             view, workers);
  }
  return view;
}

std::vector<ElevationEcho> elevation_of(const PingSetup& setup, const PingEchoes& echoes,
                                        const Workers& workers) {
  const StageTimer timer(workers, Stage::labels);
  const Sonar& sonar = setup.session.sonar;
  return elevation_echoes({echoes.scatterers, echoes.volume_elevation, sonar,
                           source_pressure_pa_m(sonar), setup.info.output.elevation_step_rad},
                          workers);
}

}  // namespace

Result<Calibrated> calibrate(const PingSetup& setup, const CalibrationWish& wish,
                             const Workers& workers) {
  const SequenceInfo& info = setup.info;
  const OutputSelection& output = info.output;
  Calibrated made{info.noise_power_pa2, {}, {}};
  if (!wish.echo_levels && !info.noise_snr_db) return made;
  PingEchoes echoes = echoes_of(setup, 0, wish.keeps_ping_zero && wants_hidden(output), workers);
  // With snr_db the noise is not known yet, so this is not the final time series of the ping.
  const bool keeps_series = wish.keeps_ping_zero && !info.noise_snr_db && has_pictures(output);
  ReceivedSeries series = received_series(received_parts(setup, echoes, 0), true,
                                          keeps_series ? only_level(output) : true, workers);
  if (info.noise_snr_db) {
    const Result<double> noise_pa2 =
        noise_power_of_snr(info, mean_clean_pa2(setup, echoes, series));
    if (!noise_pa2) return noise_pa2.error();
    made.noise_power_pa2 = *noise_pa2;
  }
  if (wish.echo_levels) {
    LabelledImage polar = polar_image(polar_input(setup, echoes, series), workers);
    made.echoes = echo_levels(*setup.display, polar, made.noise_power_pa2);
    if (keeps_series) made.ping_zero.polar = std::move(polar);
  }
  if (keeps_series) made.ping_zero.series = std::move(series);
  if (wish.keeps_ping_zero) made.ping_zero.echoes = std::move(echoes);
  return made;
}

Pipeline::Pipeline(PingSetup setup, std::shared_ptr<const SceneEchoes> scene)
    : setup_(std::move(setup)),
      scene_(std::move(scene)),
      layer_of_instance_(layer_table(setup_.info)) {
  if (has_pictures(setup_.info.output)) setup_.measured = measured_instances(setup_.session.world);
  if (setup_.info.camera) {
    setup_.camera_colors = camera_colors(setup_.session.scenario, setup_.info.instances);
  }
}

PingResult Pipeline::frame(std::uint32_t ping) const {
  const Session& session = setup_.session;
  PingResult result;
  result.ping = ping;
  result.time_s = session.ping_times_s[ping];
  result.sonar_in_world = sonar_pose(session, ping);
  result.object_in_world = object_poses(session, ping);
  for (const PointTarget& target : session.world.point_targets) {
    result.object_in_world.push_back({target.position_m, {}});
  }
  if (is_sonar(setup_.info)) result.groups = fired_groups(setup_, ping);
  if (scene_) result.first_return_m = scene_->first_return_m;
  return result;
}

PingResult Pipeline::run(std::uint32_t ping, const Workers& workers, PingStart start) const {
  const Session& session = setup_.session;
  const OutputSelection& output = setup_.info.output;
  PingResult result = frame(ping);
  if (setup_.info.camera) result.camera = camera_of_ping(setup_, ping, workers);
  if (!is_sonar(setup_.info)) return result;
  if (!scene_ && !start.echoes) {
    start.echoes = echoes_of(setup_, ping, wants_hidden(output), workers);
  }
  const PingEchoes& echoes = scene_ ? scene_->echoes : *start.echoes;
  if (!scene_) result.first_return_m = first_return_of(session, echoes);
  if (output.scatterers) {
    const RandomKeys keys = keys_of(setup_.info, ping);
    for (const Scatterer& s : echoes.scatterers.items) {
      result.amplitudes.push_back(draw_amplitude(s, keys));
    }
  }
  if (output.front) {
    result.front = front_of(setup_, scene_ ? *echoes.front : *std::move(start.echoes->front));
  }
  if (output.elevation) result.elevation = elevation_of(setup_, echoes, workers);
  const bool pictures = has_pictures(output);
  const ReceivedParts parts = received_parts(setup_, echoes, ping);
  ReceivedSeries series = start.series
                              ? std::move(*start.series)
                              : received_series(parts, pictures, only_level(output), workers);
  if (output.layers) {
    result.layers = received_layers(parts, layer_of_instance_, series, workers);
  }
  if (pictures) {
    add_pictures(setup_, echoes, series, std::move(start.polar), workers, result);
  } else {
    result.detected_db = std::move(series.level_db);
    if (setup_.info.recorder) {
      if (session.sonar.detector) {
        add_recorded(setup_, result.detected_db, result);
      } else {
        add_recorded(setup_, polar_levels_db(series.pressure_pa, session.sonar.beam_count), result);
      }
    }
  }
  if (!scene_) {
    result.scatterers = std::move(start.echoes->scatterers);
  } else if (output.scatterers || output.points) {
    result.scatterers = echoes.scatterers;
  }
  if (output.any_timeseries() || output.statistics) result.series = std::move(series.pressure_pa);
  result.channels = std::move(series.channels_pa);
  return result;
}

void Pipeline::draws(std::uint32_t first, const Workers& workers, std::span<Series> series) const {
  drawn_series(draw_parts(first), workers, series);
}

ReceivedParts Pipeline::draw_parts(std::uint32_t first) const {
  ENSONIFY_ASSERT(scene_ != nullptr);
  return received_parts(setup_, scene_->echoes, first);
}

std::vector<double> Pipeline::expected_pa2() const {
  ENSONIFY_ASSERT(scene_ != nullptr);
  const SampleArray<float>& clean = scene_->clean_power_pa2;
  std::vector<double> expected(clean.begin(), clean.end());
  for (double& value : expected) value += setup_.info.noise_power_pa2;
  return expected;
}

Result<ReadyPipeline> make_pipeline(const Session& session, const Tracer& tracer, SequenceInfo info,
                                    const Numerics& numerics, const Workers& workers,
                                    SharedParts& shared, bool keeps_ping_zero) {
  if (!shared.tables) {
    const StageTimer timer(workers, Stage::tables);
    shared.tables = pipeline_tables(session, numerics);
  }
  PingSetup setup = ping_setup(session, tracer, std::move(info), shared.tables);
  if (setup.info.output.statistics && !shared.scene) {
    PingEchoes echoes =
        echoes_of(setup, setup.info.first_ping, wants_hidden(setup.info.output), workers);
    std::vector<float> first_return_m = first_return_of(session, echoes);
    SampleArray<float> clean_power_pa2 =
        received_series(received_parts(setup, echoes, setup.info.first_ping), true, true, workers)
            .clean_power_pa2;
    shared.scene = std::make_shared<const SceneEchoes>(
        SceneEchoes{std::move(echoes), std::move(first_return_m), std::move(clean_power_pa2)});
  }
  PingStart ping_zero;
  std::optional<double> noise_power_pa2 = shared.noise_power_pa2;
  if (!noise_power_pa2) {
    Result<Calibrated> made = calibrate(setup, {false, keeps_ping_zero && !shared.scene}, workers);
    if (!made) return made.error();
    noise_power_pa2 = made->noise_power_pa2;
    ping_zero = std::move(made->ping_zero);
    if (setup.info.speckle != SpeckleMode::surface) shared.noise_power_pa2 = noise_power_pa2;
  }
  setup.info.noise_power_pa2 = *noise_power_pa2;
  if (setup.info.sequence == 0 && keeps_ping_zero && !shared.scene && shared.ping_zero) {
    ping_zero = std::exchange(*shared.ping_zero, {});
  }
  return ReadyPipeline{Pipeline(std::move(setup), shared.scene), std::move(ping_zero)};
}

}  // namespace ensonify
