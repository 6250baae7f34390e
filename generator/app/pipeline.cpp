#include "app/pipeline.h"

#include <utility>

#include "core/random.h"
#include "labels/annotations.h"
#include "labels/cartesian.h"
#include "labels/grey.h"
#include "labels/polar.h"
#include "synthesis/draw.h"

namespace ensonify {

Pipeline::Pipeline(const Session& session, const Tracer& tracer, SequenceInfo info,
                   BackendChoice backend)
    : session_(session),
      tracer_(tracer),
      info_(std::move(info)),
      fan_(make_fan(session.sonar)),
      scattering_(make_surface_scattering(session.sonar, session.water, session.world)) {
  const SynthesisSetup setup{session.sonar, session.water, session.record};
  backend_ =
      backend == BackendChoice::reference ? make_reference_backend(setup) : make_cpu_backend(setup);
  if (info_.cartesian) {
    cartesian_map_ = cartesian_map(*info_.cartesian, session.sonar, session.water, session.record);
  }
  class_of_instance_.push_back(0);
  for (const Instance& instance : info_.instances) {
    class_of_instance_.push_back(instance.class_id);
  }
}

ScattererList Pipeline::scatterers_of(const Pose& sonar_in_world, const Workers& workers) const {
  const std::vector<Hit> hits =
      tracer_.trace_fan(fan_, sonar_in_world, session_.sonar.range_max_m, workers);
  std::vector<Scatterer> scatterers = surface_scatterers(fan_, hits, scattering_);
  const std::vector<Scatterer> targets = point_target_scatterers(
      session_.world, tracer_, sonar_in_world, session_.sonar, session_.water);
  scatterers.insert(scatterers.end(), targets.begin(), targets.end());
  return sorted_by_beam_and_delay(std::move(scatterers), session_.sonar.beam_count);
}

RandomKeys Pipeline::keys_of(std::uint32_t ping) const {
  RandomKeys keys;
  keys.speckle = stream_key(info_.seed, Stream::speckle, info_.sequence);
  keys.speckle_ping = info_.speckle == SpeckleMode::per_ray ? 0 : ping;
  keys.noise = stream_key(info_.seed, Stream::noise, info_.sequence);
  keys.noise_ping = ping;
  return keys;
}

PingSeries Pipeline::series_of(const ScattererList& scatterers, std::uint32_t ping,
                               const Pose& pose, const Workers& workers) const {
  const PingTask task{&scatterers, {{0.0, pose}}, keys_of(ping), session_.noise_power_pa2, {}};
  PingSeries series;
  backend_->synthesize({&task, 1}, {&series, 1}, workers);
  return series;
}

LabelledImage Pipeline::image_of(const ScattererList& scatterers, const PingSeries& series,
                                 const Workers& workers) const {
  PolarInput input;
  input.scatterers = &scatterers;
  input.pressure_pa = series.pressure_pa;
  input.clean_power_pa2 = series.clean_power_pa2;
  input.noise_power_pa2 = session_.noise_power_pa2;
  input.bandwidth_hz = session_.sonar.bandwidth_hz;
  input.beams = session_.sonar.beam_count;
  input.samples = session_.record.samples;
  input.class_of_instance = class_of_instance_;
  return polar_image(input, workers);
}

std::array<double, 2> Pipeline::png_db_limits(const Workers& workers) const {
  if (session_.scenario.output.png_db) return *session_.scenario.output.png_db;
  const Pose pose = sonar_pose(session_, 0);
  const ScattererList scatterers = scatterers_of(pose, workers);
  return db_limits_from_clean(
      image_of(scatterers, series_of(scatterers, 0, pose, workers), workers));
}

void Pipeline::start_sequence(SequenceInfo info, const Workers& workers) {
  info_ = std::move(info);
  if (!info_.output.png) return;
  if (!png_db_limits_) png_db_limits_ = png_db_limits(workers);
  info_.png_db_limits = *png_db_limits_;
}

PingResult Pipeline::run(std::uint32_t ping, const Workers& workers) const {
  const OutputSelection& output = info_.output;
  PingResult result;
  result.ping = ping;
  result.time_s = session_.ping_times_s[ping];
  result.sonar_in_world = sonar_pose(session_, ping);
  for (const WorldObject& object : session_.world.objects) {
    result.object_in_world.push_back(object.pose);
  }
  for (const PointTarget& target : session_.world.point_targets) {
    result.object_in_world.push_back({target.position_m, {}});
  }
  result.scatterers = scatterers_of(result.sonar_in_world, workers);
  result.first_return_m = first_return_m(result.scatterers, session_.sonar.beam_count);
  if (output.scatterers) {
    const RandomKeys keys = keys_of(ping);
    for (const Scatterer& s : result.scatterers.items) {
      result.amplitudes.push_back(draw_amplitude(s, keys));
    }
  }
  PingSeries series = series_of(result.scatterers, ping, result.sonar_in_world, workers);

  LabelledImage polar = image_of(result.scatterers, series, workers);
  if (output.png || output.polar) result.polar_annotations = annotations(polar);
  if (output.png) result.polar_grey = grey_image(polar, info_.png_db_limits);
  if (output.cartesian) {
    LabelledImage cartesian = resample(polar, *info_.cartesian, cartesian_map_);
    result.cartesian_annotations = annotations(cartesian);
    if (output.png) result.cartesian_grey = grey_image(cartesian, info_.png_db_limits);
    result.cartesian = std::move(cartesian);
  }
  if (output.polar) result.polar = std::move(polar);
  if (output.timeseries) result.series = std::move(series.pressure_pa);
  return result;
}

}  // namespace ensonify
