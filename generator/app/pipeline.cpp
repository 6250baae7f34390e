#include "app/pipeline.h"

#include <cmath>
#include <utility>

#include "acoustics/refraction.h"
#include "app/layers.h"
#include "app/motion.h"
#include "core/random.h"
#include "labels/annotations.h"
#include "labels/cartesian.h"
#include "labels/grey.h"
#include "labels/polar.h"
#include "labels/shadow.h"
#include "synthesis/draw.h"

namespace ensonify {

Pipeline::Pipeline(const Session& session, const Tracer& tracer, SequenceInfo info,
                   const Numerics& numerics)
    : session_(session),
      tracer_(tracer),
      info_(std::move(info)),
      tables_(pipeline_tables(session, numerics)),
      scattering_(make_surface_scattering(session.sonar, session.water, session.world)) {
  class_of_instance_.push_back(0);
  for (const Instance& instance : info_.instances) {
    class_of_instance_.push_back(instance.class_id);
  }
}

RandomKeys Pipeline::keys_of(std::uint32_t ping) const {
  RandomKeys keys;
  keys.speckle = stream_key(info_.seed, Stream::speckle, info_.sequence);
  keys.speckle_ping = info_.speckle == SpeckleMode::per_ping ? ping : 0;
  keys.noise = stream_key(info_.seed, Stream::noise, info_.sequence);
  keys.noise_ping = ping;
  keys.volume = stream_key(info_.seed, Stream::volume, info_.sequence);
  return keys;
}

PingSeries Pipeline::series_of(const PingEchoes& echoes, std::uint32_t ping, bool wants_clean,
                               bool only_level, const Workers& workers) const {
  PingTask task{&echoes.scatterers, keys_of(ping), info_.noise_power_pa2, echoes.volumes};
  task.wants_clean = wants_clean;
  task.wants_channels = info_.output.channels;
  task.converts = true;
  task.only_level = only_level;
  PingSeries series;
  tables_->backend->synthesize({&task, 1}, {&series, 1}, workers);
  return series;
}

// The same tasks with less in them: keys, and so all draws, are those of the whole.
std::vector<LayerSeries> Pipeline::layers_of_ping(const PingEchoes& echoes, std::uint32_t ping,
                                                  const PingSeries& whole,
                                                  const Workers& workers) const {
  std::vector<LayerSeries> layers;
  for (const Layer layer : info_.layers) {
    if (layer == Layer::quantisation) {
      layers.push_back({layer, remainder(whole.pressure_pa, layers)});
      continue;
    }
    const ScattererList part = scatterers_of(layer, layer_of_instance_, echoes.scatterers);
    PingTask task{&part, keys_of(ping), 0, {}, false};
    if (layer == Layer::noise) task.noise_power_pa2 = info_.noise_power_pa2;
    if (layer == Layer::volume) task.volumes = echoes.volumes;
    PingSeries series;
    tables_->backend->synthesize({&task, 1}, {&series, 1}, workers);
    layers.push_back({layer, std::move(series.pressure_pa)});
  }
  // Behind a converter its own layer holds what is left.
  if (!session_.sonar.adc) settle(whole.pressure_pa, layers);
  return layers;
}

PolarInput Pipeline::polar_input(const PingEchoes& echoes, const PingSeries& series) const {
  PolarInput input;
  input.scatterers = &echoes.scatterers;
  input.volumes = echoes.volumes;
  input.pressure_pa = series.pressure_pa;
  input.level_db = series.level_db;
  input.clean_power_pa2 = series.clean_power_pa2;
  input.noise_power_pa2 = info_.noise_power_pa2;
  input.bandwidth_hz = session_.sonar.bandwidth_hz;
  input.beams = session_.sonar.beam_count;
  input.samples = session_.record.samples;
  input.class_of_instance = class_of_instance_;
  input.multipath = info_.output.multipath;
  return input;
}

PingEchoes Pipeline::echoes_of(std::uint32_t ping, const Workers& workers) const {
  const OutputSelection& output = info_.output;
  const bool wants_hidden = has_pictures() && (output.shadow || output.amodal);
  const Tracer tracer = tracer_.at(object_poses(session_, ping));
  return ping_echoes({session_, tables_->fan, scattering_, tracer, ping, sonar_pose(session_, ping),
                      wants_hidden, keys_of(ping).speckle},
                     workers);
}

std::vector<float> Pipeline::first_return_of(const PingEchoes& echoes) const {
  const bool by_delay = bends(session_.water) || moves(session_);
  return first_return_m(echoes.scatterers, session_.sonar.beam_count,
                        by_delay ? session_.water.sound_speed_m_s : 0);
}

bool Pipeline::has_pictures() const {
  return info_.output.polar || info_.output.cartesian || info_.output.png;
}

bool Pipeline::only_level() const {
  return has_pictures() && !info_.output.any_timeseries() && !info_.output.layers;
}

Pipeline::FromPingZero Pipeline::look_at_ping_zero(bool keeps, const Workers& workers) const {
  auto zero = std::make_unique<PingZero>();
  if (keeps) {
    zero->echoes = echoes_of(0, workers);
  } else {
    const Tracer tracer = tracer_.at(object_poses(session_, 0));
    zero->echoes = ping_echoes({session_, tables_->fan, scattering_, tracer, 0,
                                sonar_pose(session_, 0), false, keys_of(0).speckle},
                               workers);
  }
  // The noise of an snr_db is not known yet, and layers need the series without it.
  const bool same = keeps && !info_.noise_snr_db && has_pictures();
  zero->series = series_of(zero->echoes, 0, true, same ? only_level() : true, workers);
  const std::vector<std::uint8_t> hears =
      hears_echo(zero->echoes.scatterers, zero->echoes.volumes, session_.sonar.bandwidth_hz,
                 session_.sonar.beam_count, session_.record.samples);
  FromPingZero result;
  std::size_t count = 0;
  for (std::size_t i = 0; i < hears.size(); ++i) {
    if (hears[i] == 0) continue;
    result.mean_clean_pa2 += zero->series->clean_power_pa2[i];
    ++count;
  }
  if (count > 0) result.mean_clean_pa2 /= static_cast<double>(count);
  zero->polar = polar_image(polar_input(zero->echoes, *zero->series), workers);
  const LabelledImage& image = *zero->polar;
  result.db_limits =
      grey_gain_db_.empty()
          ? db_limits_from_clean(image.clean_db, image.elevation_rad)
          : db_limits_from_clean(with_gain(image.clean_db, grey_gain_db_), image.elevation_rad);
  if (!keeps) return result;
  if (!same) {
    zero->series.reset();
    zero->polar.reset();
  }
  const std::lock_guard lock(stash_mutex_);
  stash_ = std::move(zero);
  return result;
}

// Ping 0 gives what was kept of it away.
std::unique_ptr<Pipeline::PingZero> Pipeline::ping_zero_of(std::uint32_t ping,
                                                           const Workers& workers) const {
  std::unique_ptr<PingZero> kept;
  if (ping == 0) {
    const std::lock_guard lock(stash_mutex_);
    kept = std::move(stash_);
  }
  if (kept) return kept;
  kept = std::make_unique<PingZero>();
  kept->echoes = echoes_of(ping, workers);
  return kept;
}

Status Pipeline::start_sequence(SequenceInfo info, const Workers& workers, bool runs_ping_zero) {
  info_ = std::move(info);
  stash_.reset();
  // Where scatterers lie on surfaces is drawn for each sequence.
  if (info_.speckle == SpeckleMode::surface) ping_zero_.reset();
  layer_of_instance_ = layer_table(info_);
  if (info_.output.statistics && !shared_echoes_) {
    shared_echoes_ = echoes_of(info_.first_ping, workers);
    shared_first_return_m_ = first_return_of(*shared_echoes_);
  }
  grey_gain_db_.clear();
  if (info_.output.png &&
      (info_.png.spreading != 0 || info_.png.absorption || info_.png.gain_db != 0)) {
    grey_gain_db_ =
        shown_gain_db(info_.png, info_.water.absorption_db_m,
                      sample_range_m(info_.sonar, info_.water, 1), info_.record.samples);
  }
  const std::optional<std::array<double, 2>>& given = session_.scenario.output.png_db;
  const bool needs_limits = info_.output.png && !given;
  if ((needs_limits || info_.noise_snr_db) && !ping_zero_) {
    ping_zero_ = look_at_ping_zero(runs_ping_zero && !shared_echoes_, workers);
  }
  if (info_.output.png) info_.png_db_limits = given ? *given : ping_zero_->db_limits;
  if (!info_.noise_snr_db) return {};
  if (!(ping_zero_->mean_clean_pa2 > 0)) {
    return Error{
        ErrorKind::usage,
        "noise.snr_db: ping 0 hears no echo that noise could be measured against; accepted "
        "is a first ping that meets something, or noise.spectrum_level_db"};
  }
  info_.noise_power_pa2 = ping_zero_->mean_clean_pa2 / std::pow(10.0, *info_.noise_snr_db / 10.0);
  return {};
}

GreyImage Pipeline::grey_of(const LabelledImage& polar) const {
  const auto grey = [&](std::span<const float> shown_db) {
    return grey_image(polar.rows, polar.columns, shown_db, info_.png.scale, info_.png_db_limits);
  };
  return grey_gain_db_.empty() ? grey(polar.level_db)
                               : grey(with_gain(polar.level_db, grey_gain_db_));
}

void Pipeline::add_pictures(PingResult& result, const PingEchoes& echoes, const PingSeries& series,
                            std::optional<LabelledImage> made, const Workers& workers) const {
  const OutputSelection& output = info_.output;
  const PolarInput input = polar_input(echoes, series);
  LabelledImage polar = made ? std::move(*made) : polar_image(input, workers);
  HiddenLabels hidden;
  if (output.shadow || output.amodal) {
    hidden = hidden_labels(
        {input, echoes.hidden, tables_->hidden_power.per_energy, tables_->hidden_power.pulse},
        polar, workers);
  }
  if (output.shadow) polar.shadow = std::move(hidden.shadow);
  const std::vector<double>& occlusion = echoes.hidden.occlusion;
  if (output.png || output.polar) {
    result.polar_annotations = annotations(polar);
    if (output.amodal) {
      result.polar_hidden = add_amodal(hidden.amodal, occlusion, result.polar_annotations);
    }
  }
  if (output.png) result.polar_grey = grey_of(polar);
  if (output.cartesian) {
    LabelledImage cartesian = resample(polar, *info_.cartesian, tables_->cartesian_map);
    result.cartesian_annotations = annotations(cartesian);
    if (output.amodal) {
      result.cartesian_hidden =
          add_amodal(resample(hidden.amodal, *info_.cartesian, tables_->cartesian_map), occlusion,
                     result.cartesian_annotations);
    }
    if (output.png) {
      result.cartesian_grey =
          resample(*result.polar_grey, *info_.cartesian, tables_->cartesian_map);
    }
    result.cartesian = std::move(cartesian);
  }
  if (output.polar) result.polar = std::move(polar);
}

PingResult Pipeline::run(std::uint32_t ping, const Workers& workers) const {
  const OutputSelection& output = info_.output;
  PingResult result;
  result.ping = ping;
  result.time_s = session_.ping_times_s[ping];
  result.sonar_in_world = sonar_pose(session_, ping);
  result.object_in_world = object_poses(session_, ping);
  for (const PointTarget& target : session_.world.point_targets) {
    result.object_in_world.push_back({target.position_m, {}});
  }
  const bool pictures = has_pictures();
  const auto made = shared_echoes_ ? nullptr : ping_zero_of(ping, workers);
  PingEchoes* own = made ? &made->echoes : nullptr;
  const PingEchoes& echoes = own != nullptr ? *own : *shared_echoes_;
  result.first_return_m = own != nullptr ? first_return_of(*own) : shared_first_return_m_;
  if (output.scatterers) {
    const RandomKeys keys = keys_of(ping);
    for (const Scatterer& s : echoes.scatterers.items) {
      result.amplitudes.push_back(draw_amplitude(s, keys));
    }
  }
  PingSeries series = made && made->series
                          ? std::move(*made->series)
                          : series_of(echoes, ping, pictures, only_level(), workers);
  if (output.layers) {
    result.layers = layers_of_ping(echoes, ping, series, workers);
  }
  if (pictures)
    add_pictures(result, echoes, series, made ? std::move(made->polar) : std::nullopt, workers);
  if (own != nullptr) {
    result.scatterers = std::move(own->scatterers);
  } else if (output.scatterers || output.points) {
    result.scatterers = echoes.scatterers;
  }
  if (output.any_timeseries() || output.statistics) result.series = std::move(series.pressure_pa);
  result.channels = std::move(series.channels_pa);
  return result;
}

}  // namespace ensonify
