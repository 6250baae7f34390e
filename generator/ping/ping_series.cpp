#include "ping/ping_series.h"

#include <cmath>
#include <utility>

#include "core/random.h"
#include "core/stage_times.h"
#include "core/units.h"
#include "instrument/detector.h"
#include "instrument/front_end.h"
#include "ping/layers.h"
#include "synthesis/adc.h"
#include "synthesis/draw.h"

namespace ensonify {
namespace {

PingMoment moment_of(const ReceivedParts& parts, std::uint32_t ping) {
  return {device_seed(parts.info), parts.info.sequence, ping, parts.session.ping_times_s[ping]};
}

bool has_group_levels(const Sonar& sonar) {
  return sonar.transmit &&
         (!sonar.transmit->level_db.empty() || sonar.transmit->level_error_db > 0);
}

// Multiplies the amplitude of what each beam hears of its group's transmission, raised to `power`.
template <typename T>
void apply_group_levels(const ReceivedParts& parts, std::uint32_t ping, int power,
                        std::span<T> rows) {
  const Sonar& sonar = parts.session.sonar;
  if (!has_group_levels(sonar)) return;
  const std::vector<double> levels_db = group_levels_db(sonar, moment_of(parts, ping));
  const std::size_t samples = rows.size() / static_cast<std::size_t>(sonar.beam_count);
  for (int beam = 0; beam < sonar.beam_count; ++beam) {
    const double level_db = levels_db[static_cast<std::size_t>(group_of(sonar, beam))];
    const auto factor = static_cast<float>(std::pow(10.0, power * level_db / 20));
    for (T& value : rows.subspan(static_cast<std::size_t>(beam) * samples, samples)) {
      value *= factor;
    }
  }
}

// With the levels of the groups in `clean_power_pa2`.
PingSeries synthesized(const ReceivedParts& parts, const PingTask& task, const Workers& workers) {
  const StageTimer timer(workers, Stage::synthesis);
  PingSeries series;
  parts.tables.backend->synthesize({&task, 1}, {&series, 1}, workers);
  apply_group_levels(parts, parts.ping, 2, std::span<float>(series.clean_power_pa2));
  return series;
}

void add_white_noise(const ReceivedParts& parts, const RandomKeys& keys,
                     std::span<std::complex<float>> pressure_pa, const Workers& workers) {
  const auto beams = static_cast<std::size_t>(parts.session.sonar.beam_count);
  const std::size_t samples = pressure_pa.size() / beams;
  workers.for_each(beams, [&](std::size_t beam) {
    for (std::size_t n = 0; n < samples; ++n) {
      pressure_pa[beam * samples + n] += std::complex<float>(draw_noise(
          keys, static_cast<int>(beam), static_cast<int>(n), parts.info.noise_power_pa2));
    }
  });
}

void add_correlated_noise(const ReceivedParts& parts, const RandomKeys& keys,
                          std::span<std::complex<float>> pressure_pa, const Workers& workers) {
  ENSONIFY_ASSERT(parts.tables.beam_noise.has_value());
  parts.tables.beam_noise->add(keys.noise, keys.noise_ping, parts.info.noise_power_pa2,
                               parts.session.record.samples, pressure_pa, workers);
}

// Whether noise that beams share is added to the series of the backend.
bool has_correlated_noise(const ReceivedParts& parts) {
  return parts.info.noise_correlated && parts.info.noise_power_pa2 > 0;
}

// Whether the backend adds the noise. The levels of groups, which follow it, leave noise alone.
bool has_backend_noise(const ReceivedParts& parts) {
  return !has_correlated_noise(parts) && !has_group_levels(parts.session.sonar);
}

// Whether nothing is added to the series of the backend.
bool are_synthesized(const ReceivedParts& parts) {
  return has_backend_noise(parts) && !parts.session.sonar.front_end;
}

// Of a band of the detector, in which all that is random is sampled by itself.
RandomKeys keys_of_band(const ReceivedParts& parts, std::uint32_t ping, int band) {
  RandomKeys keys = keys_of(parts.info, ping);
  if (band == 0) return keys;
  const std::uint64_t of_band = mix64(static_cast<std::uint64_t>(band));
  for (std::uint64_t* key : {&keys.speckle, &keys.noise, &keys.volume})
    *key = mix64(*key ^ of_band);
  return keys;
}

// Of a ping with these echoes. It converts if nothing is added to the series of the backend.
PingTask task_of(const ReceivedParts& parts, std::uint32_t ping, int band = 0) {
  PingTask task{&parts.echoes.scatterers, keys_of_band(parts, ping, band),
                has_backend_noise(parts) ? parts.info.noise_power_pa2 : 0, parts.echoes.volumes};
  task.converts = are_synthesized(parts);
  return task;
}

// The tasks of `count` pings of one scene, of which only the series is wanted.
std::vector<PingTask> draw_tasks(const ReceivedParts& parts, std::size_t count) {
  std::vector<PingTask> tasks;
  for (std::uint32_t i = 0; i < count; ++i) {
    tasks.push_back(task_of(parts, parts.ping + i));
    tasks.back().wants_clean = false;
  }
  return tasks;
}

// Adds to the series of the backend what the backend does not make. Returns
// ReceivedSeries::artifact.
std::vector<std::uint8_t> add_electronics(const ReceivedParts& parts, std::uint32_t ping,
                                          std::span<std::complex<float>> pressure_pa,
                                          const Workers& workers, int band = 0) {
  const auto& [session, info, tables, echoes, first] = parts;
  if (are_synthesized(parts)) return {};
  const StageTimer timer(workers, Stage::synthesis);
  std::vector<std::uint8_t> artifact;
  apply_group_levels(parts, ping, 1, pressure_pa);
  if (has_correlated_noise(parts)) {
    add_correlated_noise(parts, keys_of_band(parts, ping, band), pressure_pa, workers);
  } else if (!has_backend_noise(parts) && info.noise_power_pa2 > 0) {
    add_white_noise(parts, keys_of_band(parts, ping, band), pressure_pa, workers);
  }
  if (session.sonar.front_end) {
    artifact = front_end(session.sonar, session.water, session.record, moment_of(parts, ping),
                         info.output.artifact, pressure_pa, workers);
  }
  if (session.sonar.adc) quantise(*session.sonar.adc, pressure_pa);
  return artifact;
}

// What bands 1, 2 ... of the detector hear.
std::vector<Series> further_bands(const ReceivedParts& parts, const Workers& workers) {
  std::vector<Series> bands;
  for (int band = 1; band < parts.session.sonar.detector->bands; ++band) {
    PingTask task = task_of(parts, parts.ping, band);
    task.wants_clean = false;
    PingSeries series;
    timed(workers, Stage::synthesis, [&] {
      parts.tables.backend->synthesize({&task, 1}, {&series, 1}, workers);
    });
    add_electronics(parts, parts.ping, series.pressure_pa, workers, band);
    bands.push_back(std::move(series.pressure_pa));
  }
  return bands;
}

}  // namespace

std::uint64_t places_key(const SequenceInfo& info) {
  return stream_key(info.seed, Stream::speckle, info.sequence);
}

RandomKeys keys_of(const SequenceInfo& info, std::uint32_t ping) {
  // A speckle seed gives amplitudes that no other seed gives, not even without a speckle seed.
  const auto of_amplitudes = [&](std::uint64_t key) {
    return info.speckle_seed ? mix64(key ^ mix64(~*info.speckle_seed)) : key;
  };
  RandomKeys keys;
  const std::uint64_t seed = info.speckle == SpeckleMode::surface ? info.seed : device_seed(info);
  keys.speckle = of_amplitudes(stream_key(seed, Stream::speckle, info.sequence));
  keys.speckle_ping = info.speckle == SpeckleMode::per_ping ? ping : 0;
  keys.noise = stream_key(device_seed(info), Stream::noise, info.sequence);
  keys.noise_ping = ping;
  keys.volume = of_amplitudes(stream_key(device_seed(info), Stream::volume, info.sequence));
  return keys;
}

ReceivedSeries received_series(const ReceivedParts& parts, bool wants_clean, bool only_level,
                               const Workers& workers) {
  PingTask task = task_of(parts, parts.ping);
  task.wants_clean = wants_clean;
  task.wants_channels = parts.info.output.channels;
  const Session& session = parts.session;
  task.only_level = only_level && task.converts && !session.sonar.detector;
  ReceivedSeries received{synthesized(parts, task, workers), {}};
  received.artifact = add_electronics(parts, parts.ping, received.pressure_pa, workers);
  if (session.sonar.detector) {
    const std::vector<Series> further = further_bands(parts, workers);
    const StageTimer timer(workers, Stage::synthesis);
    const auto& sub_bands = parts.tables.sub_bands;
    received.level_db =
        detected_levels_db({session.sonar, session.record, sub_bands ? &*sub_bands : nullptr,
                            moment_of(parts, parts.ping), further},
                           received.pressure_pa, workers);
  }
  return received;
}

void drawn_series(const ReceivedParts& parts, const Workers& workers,
                  std::span<Series> pressure_pa) {
  const std::vector<PingTask> tasks = draw_tasks(parts, pressure_pa.size());
  std::vector<PingSeries> series(pressure_pa.size());
  for (std::uint32_t i = 0; i < pressure_pa.size(); ++i) {
    series[i].pressure_pa.swap(pressure_pa[i]);
  }
  timed(workers, Stage::synthesis,
        [&] { parts.tables.backend->synthesize(tasks, series, workers); });
  for (std::uint32_t i = 0; i < pressure_pa.size(); ++i) {
    series[i].pressure_pa.swap(pressure_pa[i]);
    add_electronics(parts, parts.ping + i, pressure_pa[i], workers);
  }
}

std::unique_ptr<MomentSums> moment_sums(const ReceivedParts& parts, const Moments& moments,
                                        const PooledPixels& pool) {
  if (!are_synthesized(parts)) return nullptr;
  return parts.tables.backend->moment_sums(moments, pool);
}

std::uint32_t add_draws(const ReceivedParts& parts, std::uint32_t count, const Workers& workers,
                        MomentSums& sums) {
  const StageTimer timer(workers, Stage::synthesis);
  return static_cast<std::uint32_t>(sums.add(draw_tasks(parts, count), workers));
}

// Runs the same tasks with fewer items. Keys, and therefore all random numbers, are those of the
// complete task.
std::vector<LayerSeries> received_layers(const ReceivedParts& parts,
                                         const std::vector<Layer>& layer_of_instance,
                                         const PingSeries& whole, const Workers& workers) {
  const SequenceInfo& info = parts.info;
  std::vector<LayerSeries> layers;
  for (const Layer layer : info.layers) {
    if (layer == Layer::quantisation || layer == Layer::electronics) {
      layers.push_back({layer, remainder(whole.pressure_pa, layers)});
      continue;
    }
    const ScattererList part = scatterers_of(layer, layer_of_instance, parts.echoes.scatterers);
    PingTask task{&part, keys_of(info, parts.ping), 0, {}, false};
    const bool is_noise = layer == Layer::noise;
    if (is_noise && !info.noise_correlated) task.noise_power_pa2 = info.noise_power_pa2;
    if (layer == Layer::volume) task.volumes = parts.echoes.volumes;
    layers.push_back({layer, synthesized(parts, task, workers).pressure_pa});
    if (!is_noise) {
      apply_group_levels(parts, parts.ping, 1,
                         std::span<std::complex<float>>(layers.back().pressure_pa));
    }
    if (is_noise && info.noise_correlated) {
      add_correlated_noise(parts, task.keys, layers.back().pressure_pa, workers);
    }
  }
  // Otherwise the rest is a layer of its own.
  const bool all_linear = !parts.session.sonar.adc && !parts.session.sonar.front_end;
  if (all_linear) settle(whole.pressure_pa, layers);
  return layers;
}

std::vector<float> polar_levels_db(std::span<const std::complex<float>> pressure_pa,
                                   std::size_t beams) {
  const std::size_t samples = pressure_pa.size() / beams;
  std::vector<float> level_db(pressure_pa.size());
  for (std::size_t beam = 0; beam < beams; ++beam) {
    for (std::size_t n = 0; n < samples; ++n) {
      level_db[n * beams + beam] = image_level_db(std::norm(pressure_pa[beam * samples + n]));
    }
  }
  return level_db;
}

}  // namespace ensonify
