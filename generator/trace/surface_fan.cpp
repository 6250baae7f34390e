// What a sonar hears of surfaces: how small the leaves must be, and which parts lie in its fan.
#include <algorithm>
#include <cmath>

#include "trace/surface_points.h"

namespace ensonify {
namespace {

// Of the smallest -3 dB cell of beam and pulse.
struct SmallestCell {
  double width_m = 0, high_m = 0;
};

SmallestCell smallest_cell(const SurfaceViews& views, double range_m) {
  const Sonar& sonar = views.sonar;
  const double high = range_m * std::min(sonar.elevation_width_rad, sonar.elevation_fan_rad);
  double width = sonar.beam_width_rad;
  for (const double narrow : sonar.width_rad) width = std::min(width, narrow);
  return {range_m * width, std::min(views.resolution_m, high)};
}

}  // namespace

double leaf_area_m2(const SurfaceViews& views, double range_m) {
  const auto [width, high] = smallest_cell(views, range_m);
  return width * high /
         std::max(kScatterersPerCell, static_cast<double>(views.sonar.rays_per_cell.value_or(0)));
}

double even_leaf_area_m2(const SurfaceViews& views, double range_m) {
  const auto [width, high] = smallest_cell(views, range_m);
  const double spacing = views.even.at(width) * high / views.resolution_m;
  const double area = std::max(spacing * spacing, width * high / kEvenScatterersPerCell);
  const int asked = views.sonar.rays_per_cell.value_or(0);
  return asked > 0 ? std::min(area, width * high / asked) : area;
}

namespace {

// The part of a ball around `p` that lies in the angles of the fan, whatever its range.
FanPart part_in_angles(const Sonar& sonar, Vec3 p, double range, double reach) {
  if (range <= reach) return FanPart::some;
  // Allows for rounding.
  constexpr double kSlack = 1e-9;
  const double sine = std::min(1.0, reach / range), apart = std::asin(sine) + kSlack;
  const double elevation = std::abs(std::asin(std::clamp(p.z / range, -1.0, 1.0)));
  if (elevation > sonar.elevation_fan_rad / 2 + apart) return FanPart::none;
  const double cosine = std::cos(elevation);
  if (cosine <= sine) return FanPart::some;
  const double aside = std::asin(sine / cosine) + kSlack, azimuth = std::abs(std::atan2(p.y, p.x));
  if (azimuth > furthest_azimuth_rad(sonar) + aside) return FanPart::none;
  const bool is_inside = elevation + apart < sonar.elevation_fan_rad / 2 &&
                         azimuth + aside < furthest_azimuth_rad(sonar);
  return is_inside ? FanPart::all : FanPart::some;
}

}  // namespace

FanPart part_in_fan(const Sonar& sonar, const Ball& ball) {
  const double range = length(ball.centre_m), reach = ball.radius_m;
  if (range - reach > sonar.range_max_m || range + reach < sonar.range_min_m) return FanPart::none;
  const FanPart part = part_in_angles(sonar, ball.centre_m, range, reach);
  const bool is_near = range + reach<sonar.range_max_m, is_far = range - reach> sonar.range_min_m;
  return part == FanPart::all && !(is_near && is_far) ? FanPart::some : part;
}

std::optional<double> nearest_in_fan(const Sonar& sonar, const Ball& ball) {
  if (part_in_fan(sonar, ball) == FanPart::none) return std::nullopt;
  return std::max(length(ball.centre_m) - ball.radius_m, sonar.range_min_m);
}

}  // namespace ensonify
