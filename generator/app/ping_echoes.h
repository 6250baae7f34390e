// From the world at one moment to all that a ping hears.
//
//   Moment  PingEchoes  ping_echoes
#pragma once

#include <cstdint>
#include <vector>

#include "app/session.h"
#include "core/hidden.h"
#include "core/parallel.h"
#include "core/scatterers.h"
#include "core/volume_echo.h"
#include "trace/scatter.h"
#include "trace/tracer.h"

namespace ensonify {

// When a ping goes out: everything is where it is then.
struct Moment {
  const Session& session;
  const Fan& fan;
  const SurfaceScattering& scattering;
  const Tracer& tracer;
  std::uint32_t ping = 0;
  Pose sonar_in_world;
  bool wants_hidden = false;      // what would be heard were the nearest surfaces transparent
  std::uint64_t speckle_key = 0;  // RandomKeys::speckle: where scatterers lie on surfaces
};

struct PingEchoes {
  ScattererList scatterers;
  std::vector<VolumeEcho> volumes;
  HiddenEchoes hidden;  // where asked for
};

PingEchoes ping_echoes(const Moment& moment, const Workers& workers);

}  // namespace ensonify
