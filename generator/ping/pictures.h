// Images and labels of a ping from its echoes and series.
//
//   PingSetup  ping_setup   common data of the pings of a sequence
//   polar_input             what labels/ needs of a ping
//   add_recorded            the counts of the recorder
//   add_pictures            images, labels and annotations
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "core/ping.h"
#include "labels/display.h"
#include "labels/polar.h"
#include "ping/instance_measures.h"
#include "ping/moment.h"
#include "ping/ping_series.h"
#include "ping/session.h"
#include "ping/tables.h"
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
  std::shared_ptr<const DisplayTable> display;       // of the 8-bit images; null: none
  std::vector<float> cartesian_gains;                // labels/cartesian_display.h
  MeasuredInstances measured;                        // of a Pipeline with images
  std::vector<std::vector<Rgb>> camera_colors = {};  // ping/camera.h; of a Pipeline with a camera
};

// `session` and `tracer` must outlive the result; `tables` are those of the
// session.
PingSetup ping_setup(const Session& session, const Tracer& tracer, SequenceInfo info,
                     std::shared_ptr<const PipelineTables> tables);

PolarInput polar_input(const PingSetup& setup, const PingEchoes& echoes, const PingSeries& series);

// `level_db` [samples x beams]. Needs SequenceInfo::recorder.
void add_recorded(const PingSetup& setup, std::span<const float> level_db, PingResult& result);

// All that the output selection requests of polar, Cartesian and 8-bit images. Takes the artifacts
// out of `series`. `made`: the polar image if it exists. `result` has the poses of the ping.
void add_pictures(const PingSetup& setup, const PingEchoes& echoes, ReceivedSeries& series,
                  std::optional<LabelledImage> made, const Workers& workers, PingResult& result);

}  // namespace ensonify
