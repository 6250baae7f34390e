// One ping, from the world to the content of all its files.
//
//   PingStart                a partly computed ping
//   CalibrationWish  Calibrated  calibrate   values that ping 0 determines
//   SceneEchoes  SharedParts common data of the sequences of one world
//   Pipeline  make_pipeline  the pings of a sequence
#pragma once

#include <complex>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "core/ping.h"
#include "core/runtime.h"
#include "labels/display.h"
#include "labels/polar.h"
#include "ping/pictures.h"
#include "ping/ping_echoes.h"
#include "ping/ping_series.h"
#include "ping/session.h"
#include "ping/tables.h"
#include "synthesis/backend.h"
#include "trace/tracer.h"

namespace ensonify {

// Existing parts are not computed again when the ping is made.
struct PingStart {
  std::optional<PingEchoes> echoes;
  std::optional<ReceivedSeries> series;
  std::optional<LabelledImage> polar;
};

// Parts of ping 0 that are requested.
struct CalibrationWish {
  bool echo_levels = false;      // for the display limits
  bool keeps_ping_zero = false;  // for making the ping later
};

struct Calibrated {
  double noise_power_pa2 = 0;  // of SequenceInfo, also for noise.snr_db
  EchoLevels echoes;           // echo_levels (labels/display.h) of the ping
  PingStart ping_zero;         // empty unless requested and computed
};

// `setup.info` is not calibrated yet. Everything follows from the expected image of ping 0, whose
// only random values are the places of scatterers on surfaces (speckle: surface). Error (usage):
// noise.snr_db, but ping 0 has no echo.
Result<Calibrated> calibrate(const PingSetup& setup, const CalibrationWish& wish,
                             const Workers& workers);

// Common echoes of all pings that are realizations of one scene (output.statistics).
struct SceneEchoes {
  PingEchoes echoes;
  std::vector<float> first_return_m;
  SampleArray<float> clean_power_pa2;  // [beams x samples]
};

// The first pipeline of a world fills in absent parts, and later ones use them.
struct SharedParts {
  std::shared_ptr<const PipelineTables> tables;
  std::shared_ptr<const SceneEchoes> scene;  // only with output.statistics
  std::optional<double> noise_power_pa2;     // not with speckle: surface
  std::shared_ptr<PingStart> ping_zero;      // of sequence 0; null or empty: not computed
};

class Pipeline {
 public:
  // `setup.info` is calibrated; `scene` is null unless the pings are realizations of one scene.
  Pipeline(PingSetup setup, std::shared_ptr<const SceneEchoes> scene);

  // Computes everything that the sequence's output selection requests. May be called from several
  // threads at once, for different pings.
  PingResult run(std::uint32_t ping, const Workers& workers, PingStart start = {}) const;

  // Of realizations of one scene:
  // The time series of pings first, first + 1 ... as run() makes them, and the number that is best
  // made at once. May be called from several threads at once.
  void draws(std::uint32_t first, const Workers& workers, std::span<Series> series) const;
  int draws_at_once() const { return setup_.tables->backend->draws_at_once(); }
  // What they are made from, for moment_sums and add_draws of ping/ping_series.h.
  ReceivedParts draw_parts(std::uint32_t first) const;
  // Their expected intensity, [beams x samples], with noise.
  std::vector<double> expected_pa2() const;
  // What run() returns where pings have no files (OutputSelection::pings), without computing more.
  PingResult frame(std::uint32_t ping) const;

  const SequenceInfo& info() const { return setup_.info; }
  const Tracer& tracer() const { return setup_.tracer; }  // of the objects at rest
  const std::vector<std::int32_t>& cartesian_map() const { return setup_.tables->cartesian_map; }

 private:
  PingSetup setup_;
  std::shared_ptr<const SceneEchoes> scene_;
  std::vector<Layer> layer_of_instance_;
};

struct ReadyPipeline {
  Pipeline pipeline;
  PingStart ping_zero;  // for making the ping later
};

// The pipeline of the sequence that `info` describes, which is not calibrated yet but has its
// display limits. `session` and `tracer` must outlive it. With `keeps_ping_zero`, parts of ping 0
// that calibration computes are kept. Errors: those of calibrate. Throws DeviceFailure.
Result<ReadyPipeline> make_pipeline(const Session& session, const Tracer& tracer, SequenceInfo info,
                                    const Numerics& numerics, const Workers& workers,
                                    SharedParts& shared, bool keeps_ping_zero = false);

}  // namespace ensonify
