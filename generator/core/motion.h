// Where a point of one ping lies in another. The values of planes and of the tracer.
//
//   PointState  PointMotion
#pragma once

#include <cstdint>
#include <limits>

namespace ensonify {

// Of a point in another ping. outside: not in the fan, or nearer or farther than the record.
enum class PointState : std::uint8_t { none, seen, hidden, outside };

// Places are fractions of sample and beam indices, of the straight line to the point, at
// transmission. NaN without a point.
struct PointMotion {
  double sample = std::numeric_limits<double>::quiet_NaN();
  double beam = std::numeric_limits<double>::quiet_NaN();
  double sample_there = std::numeric_limits<double>::quiet_NaN();
  double beam_there = std::numeric_limits<double>::quiet_NaN();
  PointState state = PointState::none;
  std::uint16_t occluder = 0;  // of hidden points: the first instance on the line
};

}  // namespace ensonify
