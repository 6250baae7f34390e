#include "core/vec.h"

namespace ensonify {

Quat from_roll_pitch_yaw(double roll_rad, double pitch_rad, double yaw_rad) {
  const Quat roll{std::cos(roll_rad / 2), std::sin(roll_rad / 2), 0, 0};
  const Quat pitch{std::cos(pitch_rad / 2), 0, std::sin(pitch_rad / 2), 0};
  const Quat yaw{std::cos(yaw_rad / 2), 0, 0, std::sin(yaw_rad / 2)};
  return yaw * pitch * roll;
}

Quat slerp(Quat a, Quat b, double u) {
  double cosine = a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z;
  if (cosine < 0) {
    cosine = -cosine;
    b = {-b.w, -b.x, -b.y, -b.z};
  }
  double wa = 1 - u;
  double wb = u;
  // Below this angle sin(angle) loses digits, while the chord equals the arc to 1e-12.
  if (cosine < 1 - 1e-12) {
    const double angle = std::acos(cosine);
    wa = std::sin((1 - u) * angle) / std::sin(angle);
    wb = std::sin(u * angle) / std::sin(angle);
  }
  return normalized(
      Quat{wa * a.w + wb * b.w, wa * a.x + wb * b.x, wa * a.y + wb * b.y, wa * a.z + wb * b.z});
}

}  // namespace ensonify
