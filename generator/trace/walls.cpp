#include "trace/walls.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "trace/bounce_ping.h"
#include "trace/echo.h"

namespace ensonify {
namespace {

std::vector<Tap> taps_of(const WallEvents& walls) {
  std::vector<Tap> taps = {{0, 1}};
  for (int i = 0; i < walls.count; ++i) {
    const WallEvent& event = walls.event[i];
    const WallResponse::Angle& angle = event.wall->at(event.sine);
    taps = product(taps, event.reflected ? angle.reflected : angle.transmitted);
  }
  return taps;
}

void name_walls(const WallEvents& walls, Scatterer& echo) {
  for (int i = 0; i < walls.count; ++i) {
    const auto wall = static_cast<std::uint16_t>(walls.event[i].instance);
    if (walls.event[i].reflected || wall == echo.instance) continue;
    const auto free = std::ranges::find_if(
        echo.via, [&](std::uint16_t other) { return other == 0 || other == wall; });
    if (free != echo.via.end()) *free = wall;
  }
}

}  // namespace

void add_with_walls(Scatterer echo, const WallEvents& walls, const Sonar& sonar, const Water& water,
                    std::vector<Scatterer>& scatterers) {
  if (walls.count == 0) {
    scatterers.push_back(echo);
    return;
  }
  if (walls.passed > 0) {
    echo.path |= kThroughWalls;
    name_walls(walls, echo);
  }
  for (const Tap& tap : taps_of(walls)) {
    Scatterer s = echo;
    s.delay_s += tap.delay_s;
    s.mean *= std::complex<float>(tap.gain);
    s.standard_deviation *= static_cast<float>(std::abs(tap.gain));
    // A random amplitude has only a modulus, so the phase of the tap becomes a part of its delay,
    // shorter than half a period of the carrier.
    if (s.standard_deviation > 0) {
      s.delay_s -= std::arg(tap.gain) / (2 * kPi * sonar.frequency_hz);
    }
    s.lag_s = static_cast<float>(s.delay_s - echo.delay_s);
    if (in_range(s.delay_s * water.sound_speed_m_s / 2, sonar)) scatterers.push_back(s);
  }
}

}  // namespace ensonify
