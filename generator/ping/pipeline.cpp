#include "ping/pipeline.h"

#include <cmath>
#include <utility>

#include "acoustics/refraction.h"
#include "core/stage_times.h"
#include "formats/bytes.h"
#include "instrument/front_end.h"
#include "instrument/recorder.h"
#include "labels/annotations.h"
#include "labels/cartesian.h"
#include "labels/cartesian_display.h"
#include "labels/elevation.h"
#include "labels/polar.h"
#include "labels/shadow.h"
#include "labels/surfaces.h"
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

std::vector<double> levels_of(const PingSetup& setup, std::uint32_t ping) {
  return group_levels_db(setup.session.sonar, {setup.info.seed, setup.info.sequence, ping, 0});
}

PingEchoes echoes_of(const PingSetup& setup, std::uint32_t ping, bool with_hidden,
                     const Workers& workers) {
  const Session& session = setup.session;
  const OutputSelection& output = setup.info.output;
  const Tracer tracer = setup.tracer.at(object_poses(session, ping));
  PingEchoes echoes =
      ping_echoes({session, setup.tables->fan, setup.scattering, tracer, ping,
                   sonar_pose(session, ping), with_hidden, places_key(setup.info), output.front,
                   output.elevation && output.elevation_volumes ? output.elevation_step_rad : 0},
                  workers);
  send_levels(session.sonar, levels_of(setup, ping), echoes);
  return echoes;
}

// They transmit from one pose unless the sonar moves in the ping.
std::vector<FiredGroup> fired_groups(const PingSetup& setup, std::uint32_t ping) {
  const Session& session = setup.session;
  std::vector<FiredGroup> groups;
  if (!session.sonar.transmit) return groups;
  const std::vector<double> levels_db = levels_of(setup, ping);
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

PolarInput polar_input(const PingSetup& setup, const PingEchoes& echoes, const PingSeries& series) {
  PolarInput input;
  input.scatterers = &echoes.scatterers;
  input.volumes = echoes.volumes;
  input.pressure_pa = series.pressure_pa;
  input.level_db = series.level_db;
  input.clean_power_pa2 = series.clean_power_pa2;
  input.noise_power_pa2 = setup.info.noise_power_pa2;
  input.bandwidth_hz = setup.session.sonar.bandwidth_hz;
  input.beams = setup.session.sonar.beam_count;
  input.samples = setup.session.record.samples;
  input.class_of_instance = setup.class_of_instance;
  input.multipath = setup.info.output.multipath;
  input.second = setup.info.output.surfaces;
  return input;
}

// The images are made from the stored levels, so that `render` can repeat them.
void add_grey(const PingSetup& setup, const LabelledImage& polar, const Workers& workers,
              PingResult& result) {
  const StageTimer timer(workers, Stage::grey);
  std::vector<float> stored = polar.level_db;
  round_to_halves(stored);
  const DisplayTable& display = *setup.display;
  DisplayedImage image = displayed(display, polar.rows, polar.columns, stored, polar.elevation_rad);
  const PipelineTables& tables = *setup.tables;
  if (setup.info.output.cartesian) {
    result.cartesian_grey =
        tables.footprints ? displayed_cartesian(display, *tables.footprints, setup.cartesian_gains,
                                                image.further_gain_db, stored)
                          : resample(image.grey, *setup.info.cartesian, tables.cartesian_map);
  }
  result.polar_grey = std::move(image.grey);
  result.grey_counts = image.counts;
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

// `result` has the poses of the ping.
void add_surfaces_of(const PingSetup& setup, const PolarInput& input, const PingResult& result,
                     const Workers& workers, LabelledImage& polar) {
  const StageTimer timer(workers, Stage::labels);
  const Tracer tracer =
      setup.tracer.at(std::span(result.object_in_world).first(setup.session.world.objects.size()));
  const Sonar& sonar = setup.session.sonar;
  add_surfaces(
      {input, setup.session.water.sound_speed_m_s, sonar.elevation_fan_rad / sonar.rays_elevation,
       [&](std::span<const std::uint32_t> scatterers, std::span<Vec3> normals) {
         surface_normals(tracer, result.sonar_in_world, *input.scatterers, scatterers, normals);
       }},
      workers, polar);
}

FrontView front_of(const PingSetup& setup, FrontView view) {
  for (std::size_t i = 0; i < view.instance.size(); ++i) {
    view.semantic[i] = setup.class_of_instance[view.instance[i]];
  }
  return view;
}

std::vector<ElevationEcho> elevation_of(const PingSetup& setup, const PingEchoes& echoes,
                                        const Workers& workers) {
  const StageTimer timer(workers, Stage::labels);
  const Sonar& sonar = setup.session.sonar;
  return elevation_echoes(
      {echoes.scatterers, echoes.volume_elevation, sonar.bandwidth_hz, sonar.frequency_hz,
       source_pressure_pa_m(sonar), setup.info.output.elevation_step_rad},
      workers);
}

// The planes stay blank if the sequence has no such ping. `result` has the poses of the ping.
void add_motion_of(const PingSetup& setup, const PolarInput& input, const PingResult& result,
                   const Workers& workers, LabelledImage& polar) {
  const StageTimer timer(workers, Stage::labels);
  const Session& session = setup.session;
  const std::int64_t other = std::int64_t{result.ping} + setup.info.output.motion_pings;
  if (other < 0 || other >= std::int64_t(session.ping_times_s.size())) {
    add_motion({input, [](auto, std::span<PointMotion>) {}}, workers, polar);
    return;
  }
  const auto there = static_cast<std::uint32_t>(other);
  const std::vector<Pose> objects_there = object_poses(session, there);
  const Tracer tracer = setup.tracer.at(objects_there);
  const std::size_t objects = session.world.objects.size();
  const PointMover mover{session.world,
                         result.sonar_in_world,
                         std::span(result.object_in_world).first(objects),
                         objects_there,
                         {tracer, session.sonar, sonar_pose(session, there)},
                         range_step_m(setup.info.sonar, setup.info.water)};
  add_motion({input,
              [&](std::span<const std::uint32_t> which, std::span<PointMotion> motions) {
                point_motions(mover, *input.scatterers, which, motions);
              }},
             workers, polar);
}

void add_measures(std::span<const InstanceMeasures> measures, std::vector<Annotation>& list) {
  for (Annotation& annotation : list) annotation.measures = measures[annotation.instance];
}

// The annotations of the polar image are computed even if it is not written, since measures use
// them.
std::vector<Annotation> polar_annotations_of(const PingSetup& setup, const PolarInput& input,
                                             const LabelledImage& polar, const PingResult& result,
                                             std::vector<InstanceMeasures>& measures) {
  const ImageRuns runs = instance_runs(polar);
  std::vector<Annotation> list = annotations(runs);
  measures = instance_measures(
      {setup.session, setup.measured,
       std::span(result.object_in_world).first(setup.session.world.objects.size()),
       result.sonar_in_world, runs, input.clean_power_pa2, list});
  add_measures(measures, list);
  return list;
}

void add_recorded(const PingSetup& setup, std::span<const float> level_db, PingResult& result) {
  const SequenceInfo& info = setup.info;
  result.recorded =
      record_ping(*info.recorder, level_db, info.sonar.beam_count,
                  sample_range_m(info.sonar, info.water, 1), info.water.absorption_db_m);
}

void add_pictures(const PingSetup& setup, const PingEchoes& echoes, ReceivedSeries& series,
                  std::optional<LabelledImage> made, const Workers& workers, PingResult& result) {
  const SequenceInfo& info = setup.info;
  const OutputSelection& output = info.output;
  const PipelineTables& tables = *setup.tables;
  const PolarInput input = polar_input(setup, echoes, series);
  LabelledImage polar =
      made ? std::move(*made)
           : timed(workers, Stage::labels, [&] { return polar_image(input, workers); });
  polar.artifact = std::move(series.artifact);
  if (info.recorder) add_recorded(setup, polar.level_db, result);
  HiddenLabels hidden;
  if (output.shadow || output.amodal) {
    const StageTimer timer(workers, Stage::shadow);
    hidden = hidden_labels(
        {input, echoes.hidden, tables.hidden_power.per_energy, tables.hidden_power.pulse}, polar,
        workers);
  }
  if (output.shadow) polar.shadow = std::move(hidden.shadow);
  const std::vector<double>& occlusion = echoes.hidden.occlusion;
  if (output.surfaces) add_surfaces_of(setup, input, result, workers, polar);
  if (output.motion) add_motion_of(setup, input, result, workers, polar);
  if (output.clean_single) polar.clean_single_db = polar.clean_db;
  std::vector<InstanceMeasures> measures;
  timed(workers, Stage::annotations, [&] {
    auto list = polar_annotations_of(setup, input, polar, result, measures);
    if (!output.png && !output.polar) return;
    result.polar_annotations = std::move(list);
    if (output.amodal) {
      result.polar_hidden = add_amodal(hidden.amodal, occlusion, result.polar_annotations);
    }
  });
  if (output.png) add_grey(setup, polar, workers, result);
  if (output.cartesian) {
    LabelledImage cartesian = timed(workers, Stage::cartesian, [&] {
      return resample(polar, *info.cartesian, tables.cartesian_map,
                      output.cartesian_exr ? ResampledPlanes::all : ResampledPlanes::ids,
                      output.amodal ? &hidden.amodal : nullptr);
    });
    timed(workers, Stage::annotations, [&] {
      result.cartesian_annotations = annotations(instance_runs(cartesian));
      add_measures(measures, result.cartesian_annotations);
      if (!output.amodal) return;
      result.cartesian_hidden = add_amodal(hidden.amodal, occlusion, result.cartesian_annotations);
    });
    result.cartesian = std::move(cartesian);
  }
  if (output.polar) result.polar = std::move(polar);
}

}  // namespace

PingSetup ping_setup(const Session& session, const Tracer& tracer, SequenceInfo info,
                     std::shared_ptr<const PipelineTables> tables) {
  std::vector<std::uint8_t> class_of_instance = {0};
  for (const Instance& instance : info.instances) class_of_instance.push_back(instance.class_id);
  std::shared_ptr<const DisplayTable> display;
  std::vector<float> gains;
  if (info.output.png) {
    display = std::make_shared<const DisplayTable>(
        display_table(info.png, info.water.absorption_db_m, range_step_m(info.sonar, info.water),
                      info.record.samples));
    if (tables->footprints) gains = cartesian_gains(*display, *tables->footprints);
  }
  return {session,
          tracer,
          std::move(info),
          std::move(tables),
          make_surface_scattering(session.sonar, session.water, session.world),
          std::move(class_of_instance),
          std::move(display),
          std::move(gains),
          {}};
}

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
  result.groups = fired_groups(setup_, ping);
  if (scene_) result.first_return_m = scene_->first_return_m;
  return result;
}

PingResult Pipeline::run(std::uint32_t ping, const Workers& workers, PingStart start) const {
  const Session& session = setup_.session;
  const OutputSelection& output = setup_.info.output;
  PingResult result = frame(ping);
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
