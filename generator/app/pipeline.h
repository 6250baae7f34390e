// One ping from the world to everything that will be written of it.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "app/numerics.h"
#include "app/ping_echoes.h"
#include "app/session.h"
#include "app/tables.h"
#include "core/parallel.h"
#include "core/ping.h"
#include "core/simd.h"
#include "labels/polar.h"
#include "synthesis/backend.h"
#include "trace/scatter.h"
#include "trace/tracer.h"

namespace ensonify {

class Pipeline {
 public:
  // `session` and `tracer` must outlive the pipeline; `info` is of the sequence to run.
  Pipeline(const Session& session, const Tracer& tracer, SequenceInfo info,
           const Numerics& numerics);

  // Everything that the sequence's output selection asks for. May be called from several threads at
  // once, for different pings. Where all pings are draws of one scene (output.statistics), what
  // they hear is traced once.
  PingResult run(std::uint32_t ping, const Workers& workers) const;

  // From here on pings are those of this sequence. What follows from the clean image of ping 0,
  // which holds no draw (but places on surfaces) and so is worked out once, is filled in: the noise
  // power of noise.snr_db, black and white of the grey pictures where the scenario does not give
  // them. With `runs_ping_zero` what was worked out for it is kept until ping 0 is run.
  // Error (usage): noise.snr_db, and ping 0 hears nothing.
  Status start_sequence(SequenceInfo info, const Workers& workers, bool runs_ping_zero = false);

  const SequenceInfo& info() const { return info_; }

 private:
  struct FromPingZero {
    std::array<double, 2> db_limits{};
    double mean_clean_pa2 = 0;  // over the pixels that hear an echo; 0: none does
  };

  // As far as ping 0 is the same when it is looked at and when it is run.
  struct PingZero {
    PingEchoes echoes;
    std::optional<PingSeries> series;
    std::optional<LabelledImage> polar;
  };

  std::unique_ptr<PingZero> ping_zero_of(std::uint32_t ping, const Workers& workers) const;
  PingEchoes echoes_of(std::uint32_t ping, const Workers& workers) const;
  std::vector<float> first_return_of(const PingEchoes& echoes) const;
  FromPingZero look_at_ping_zero(bool keeps, const Workers& workers) const;
  RandomKeys keys_of(std::uint32_t ping) const;
  PingSeries series_of(const PingEchoes& echoes, std::uint32_t ping, bool wants_clean,
                       bool only_level, const Workers& workers) const;
  std::vector<LayerSeries> layers_of_ping(const PingEchoes& echoes, std::uint32_t ping,
                                          const PingSeries& whole, const Workers& workers) const;
  GreyImage grey_of(const LabelledImage& polar) const;
  bool has_pictures() const;
  bool only_level() const;
  void add_pictures(PingResult& result, const PingEchoes& echoes, const PingSeries& series,
                    std::optional<LabelledImage> made, const Workers& workers) const;
  PolarInput polar_input(const PingEchoes& echoes, const PingSeries& series) const;

  const Session& session_;
  const Tracer& tracer_;
  SequenceInfo info_;
  std::shared_ptr<const PipelineTables> tables_;
  SurfaceScattering scattering_;
  std::vector<std::uint8_t> class_of_instance_;
  std::vector<double> grey_gain_db_;  // [samples] of the grey pictures; empty: none
  std::vector<Layer> layer_of_instance_;
  std::optional<FromPingZero> ping_zero_;
  // What all pings hear, where they are draws of one scene.
  std::optional<PingEchoes> shared_echoes_;
  std::vector<float> shared_first_return_m_;
  // Ping 0 as it was looked at, for when it is run.
  mutable std::mutex stash_mutex_;
  mutable std::unique_ptr<PingZero> stash_;
};

}  // namespace ensonify
