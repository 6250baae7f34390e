#include "acoustics/pattern.h"

namespace ensonify {

ReceivePattern make_receive_pattern(const BeamShading& shading, double width_rad) {
  return {shading, 0.884 / width_rad, 0, 0};
}

double receive_pattern(const ReceivePattern& pattern, double angle_rad) {
  return sinc(pattern.aperture * std::sin(angle_rad));
}

}  // namespace ensonify
