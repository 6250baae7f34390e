#include "core/camera.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace ensonify {
namespace {

// The distortion and its derivatives.
struct Distortion {
  ImagePoint at;
  double x_x = 1, x_y = 0, y_x = 0, y_y = 1;  // d at.x / dx, d at.x / dy ...

  double determinant() const { return x_x * y_y - x_y * y_x; }
};

Distortion distortion_at(const CameraOptics& o, ImagePoint p) {
  const double r2 = p.x * p.x + p.y * p.y;
  const double s = 1 + r2 * (o.k1 + r2 * (o.k2 + r2 * o.k3));
  const double slope = o.k1 + r2 * (2 * o.k2 + 3 * r2 * o.k3);  // ds / d(r^2)
  Distortion d;
  d.at.x = s * p.x + 2 * o.p1 * p.x * p.y + o.p2 * (r2 + 2 * p.x * p.x);
  d.at.y = s * p.y + o.p1 * (r2 + 2 * p.y * p.y) + 2 * o.p2 * p.x * p.y;
  d.x_x = s + 2 * slope * p.x * p.x + 2 * o.p1 * p.y + 6 * o.p2 * p.x;
  d.x_y = 2 * slope * p.x * p.y + 2 * o.p1 * p.x + 2 * o.p2 * p.y;
  d.y_x = d.x_y;
  d.y_y = s + 2 * slope * p.y * p.y + 6 * o.p1 * p.y + 2 * o.p2 * p.x;
  return d;
}

// Below this share of an undistorted image's area, a fold is near.
constexpr double kLeastArea = 0.01;
constexpr double kResidual = 1e-13;
constexpr int kSteps = 8, kMostIterations = 30;

// Newton's method from a point nearby; false if it does not arrive.
bool solve(const CameraOptics& optics, ImagePoint target, ImagePoint& p) {
  for (int i = 0; i < kMostIterations; ++i) {
    const Distortion d = distortion_at(optics, p);
    const double area = d.determinant();
    if (!(area > kLeastArea)) return false;
    const double x = target.x - d.at.x, y = target.y - d.at.y;
    if (std::max(std::abs(x), std::abs(y)) <= kResidual * (1 + std::hypot(target.x, target.y))) {
      return true;
    }
    p.x += (d.y_y * x - d.x_y * y) / area;
    p.y += (d.x_x * y - d.y_x * x) / area;
  }
  return false;
}

ImagePoint on_plane(const CameraOptics& o, double u_px, double v_px) {
  return {(u_px - o.center_x_px) / o.focal_x_px, (v_px - o.center_y_px) / o.focal_y_px};
}

}  // namespace

ImagePoint distorted(const CameraOptics& optics, ImagePoint p) {
  return distortion_at(optics, p).at;
}

std::optional<ImagePoint> undistorted(const CameraOptics& optics, ImagePoint p) {
  if (!optics.is_distorted()) return p;
  ImagePoint found;
  for (int step = 1; step <= kSteps; ++step) {
    const double share = static_cast<double>(step) / kSteps;
    if (!solve(optics, {share * p.x, share * p.y}, found)) return std::nullopt;
  }
  return found;
}

std::optional<ImagePoint> projected(const CameraOptics& optics, Vec3 point_m) {
  if (!(point_m.z > 0)) return std::nullopt;
  const ImagePoint p{point_m.x / point_m.z, point_m.y / point_m.z};
  // From the axis to the point, the distortion may not fold the image.
  for (int step = 1; step <= kSteps && optics.is_distorted(); ++step) {
    const double share = static_cast<double>(step) / kSteps;
    const ImagePoint before{share * p.x, share * p.y};
    if (!(distortion_at(optics, before).determinant() > kLeastArea)) return std::nullopt;
  }
  const ImagePoint d = distorted(optics, p);
  return ImagePoint{optics.focal_x_px * d.x + optics.center_x_px,
                    optics.focal_y_px * d.y + optics.center_y_px};
}

Vec3 pixel_direction(const CameraOptics& optics, double u_px, double v_px) {
  const auto p = undistorted(optics, on_plane(optics, u_px, v_px));
  ENSONIFY_ASSERT(p.has_value());
  return {p->x, p->y, 1};
}

std::optional<std::array<int, 2>> unseen_pixel(const CameraOptics& optics) {
  if (!optics.is_distorted()) return std::nullopt;
  const auto is_unseen = [&](int u, int v) {
    // The outer edges of the pixel, which rays within it may reach.
    const double x = u + (u > optics.center_x_px ? 0.5 : -0.5);
    const double y = v + (v > optics.center_y_px ? 0.5 : -0.5);
    return !undistorted(optics, on_plane(optics, x, y));
  };
  const int right = optics.width_px - 1, bottom = optics.height_px - 1;
  for (int u = 0; u <= right; ++u) {
    for (const int v : {0, bottom}) {
      if (is_unseen(u, v)) return std::array{u, v};
    }
  }
  for (int v = 0; v <= bottom; ++v) {
    for (const int u : {0, right}) {
      if (is_unseen(u, v)) return std::array{u, v};
    }
  }
  return std::nullopt;
}

}  // namespace ensonify
