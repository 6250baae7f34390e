#include "ping/pictures.h"

#include <utility>

#include "core/stage_times.h"
#include "formats/bytes.h"
#include "instrument/recorder.h"
#include "labels/annotations.h"
#include "labels/cartesian.h"
#include "labels/cartesian_display.h"
#include "labels/shadow.h"
#include "labels/surfaces.h"
#include "trace/echo_points.h"

namespace ensonify {

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

namespace {

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

}  // namespace

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

}  // namespace ensonify
