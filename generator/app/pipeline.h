// One ping from the world to everything that will be written of it.
//
//   PingSetup  ping_setup    what the pings of a sequence have in common
//   PingStart                a ping that is worked out in part
//   CalibrationWish  Calibrated  calibrate   what ping 0 settles
//   SceneEchoes  SharedParts what the sequences of one world have in common
//   Pipeline  make_pipeline  the pings of a sequence
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "app/instance_measures.h"
#include "app/ping_echoes.h"
#include "app/session.h"
#include "app/tables.h"
#include "core/error.h"
#include "core/parallel.h"
#include "core/ping.h"
#include "core/runtime.h"
#include "labels/display.h"
#include "labels/polar.h"
#include "synthesis/backend.h"
#include "trace/scatter.h"
#include "trace/tracer.h"

namespace ensonify {

struct PingSetup {
  const Session& session;
  const Tracer& tracer;
  SequenceInfo info;
  std::shared_ptr<const PipelineTables> tables;
  SurfaceScattering scattering;
  std::vector<std::uint8_t> class_of_instance;
  std::shared_ptr<const DisplayTable> display;  // of the 8-bit images; null: there are none
  std::vector<float> cartesian_gains;           // labels/cartesian_display.h
  MeasuredInstances measured;                   // where there are images
};

// `session` and `tracer` must outlive the result; `tables` are those of the
// session.
PingSetup ping_setup(const Session& session, const Tracer& tracer, SequenceInfo info,
                     std::shared_ptr<const PipelineTables> tables);

// Parts that are there are not worked out again when the ping is made.
struct PingStart {
  std::optional<PingEchoes> echoes;
  std::optional<PingSeries> series;
  std::optional<LabelledImage> polar;
};

// What is to be worked out of ping 0.
struct CalibrationWish {
  bool echo_levels = false;      // for the limits of the display
  bool keeps_ping_zero = false;  // for its run
};

struct Calibrated {
  double noise_power_pa2 = 0;  // of SequenceInfo, also of noise.snr_db
  EchoLevels echoes;           // echo_levels (labels/display.h) of the ping
  PingStart ping_zero;         // empty unless it is to be kept and had to be looked at
};

// `setup.info` is not calibrated yet. All follows from the clean image of ping 0, which holds no
// draw but the places of scatterers on surfaces (speckle: surface). Error (usage): noise.snr_db,
// and ping 0 hears nothing.
Result<Calibrated> calibrate(const PingSetup& setup, const CalibrationWish& wish,
                             const Workers& workers);

// What all pings hear where they are draws of one scene (output.statistics).
struct SceneEchoes {
  PingEchoes echoes;
  std::vector<float> first_return_m;
};

// The first pipeline of a world fills in what is absent, and later ones take it
// from here.
struct SharedParts {
  std::shared_ptr<const PipelineTables> tables;
  std::shared_ptr<const SceneEchoes> scene;  // only with output.statistics
  std::optional<double> noise_power_pa2;     // not with speckle: surface
  std::shared_ptr<PingStart> ping_zero;      // of sequence 0; null or empty: not worked out
};

class Pipeline {
 public:
  // `setup.info` is calibrated; `scene` is null unless pings are draws of one
  // scene.
  Pipeline(PingSetup setup, std::shared_ptr<const SceneEchoes> scene);

  // Everything that the sequence's output selection asks for. May be called
  // from several threads at once, for different pings.
  PingResult run(std::uint32_t ping, const Workers& workers, PingStart start = {}) const;

  const SequenceInfo& info() const { return setup_.info; }
  const std::vector<std::int32_t>& cartesian_map() const { return setup_.tables->cartesian_map; }

 private:
  PingSetup setup_;
  std::shared_ptr<const SceneEchoes> scene_;
  std::vector<Layer> layer_of_instance_;
};

struct ReadyPipeline {
  Pipeline pipeline;
  PingStart ping_zero;  // for its run
};

// The pipeline of the sequence that `info` describes, which is not calibrated
// yet, but has the limits of its display. `session` and `tracer` must outlive it. With
// `keeps_ping_zero` what calibration works out of ping 0 is kept. Errors: those of calibrate.
// Throws DeviceFailure.
Result<ReadyPipeline> make_pipeline(const Session& session, const Tracer& tracer, SequenceInfo info,
                                    const Numerics& numerics, const Workers& workers,
                                    SharedParts& shared, bool keeps_ping_zero = false);

}  // namespace ensonify
