#include "acoustics/refraction.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/units.h"

namespace ensonify {
namespace {

constexpr double kForever = std::numeric_limits<double>::infinity();

// Smaller swings around a border are not followed.
constexpr double kLeastSwing_m = 1e-9;

// cos(h) and sin(h)/h. Pieces of rays turn by small angles, for which the series is exact and
// faster.
struct HalfTurn {
  double cosine, sine_ratio;
};
HalfTurn half_turn(double h) {
  const double h2 = h * h;
  if (h2 < 1e-3) {
    return {1 - h2 * (1.0 / 2 - h2 * (1.0 / 24 - h2 * (1.0 / 720 - h2 / 40320))),
            1 - h2 * (1.0 / 6 - h2 * (1.0 / 120 - h2 / 5040))};
  }
  return {std::cos(h), std::sin(h) / h};
}

double asin_ratio(double y) {
  if (std::abs(y) < 1e-4) return 1 + y * y / 6;
  return std::asin(std::clamp(y, -1.0, 1.0)) / y;
}

double asinh_ratio(double y) {
  const double y2 = y * y;
  if (y2 > 1e-3) return std::asinh(y) / y;
  return 1 - y2 * (1.0 / 6 - y2 * (3.0 / 40 - y2 * (15.0 / 336 - y2 * (105.0 / 3456))));
}

int layer_at(const SoundLayers& layers, double z_m) {
  const auto above = std::upper_bound(layers.z_m.begin(), layers.z_m.end(), z_m);
  return static_cast<int>(above - layers.z_m.begin());
}

// The length of the arc that rises by rise_m and ends with sin(phi) = sine at the speed c.
double length_to(const RayArc& arc, double rise_m, double sine, double speed_m_s) {
  const RayPoint& from = arc.start;
  const double cosine = from.cos_phi * speed_m_s / from.speed_m_s;
  // A chord has the mean direction of its ends. If the ray turned, the sines at its ends cancel,
  // and their difference gives the distance instead.
  const bool turned = from.sin_phi * sine < 0;
  const double across = turned ? (from.sin_phi - sine) / arc.curvature_m
                               : rise_m * (from.cos_phi + cosine) / (from.sin_phi + sine);
  const double chord = std::hypot(across, rise_m);
  // Of two arcs on the same chord the longer one never occurs, because |phi| <= 90 degrees.
  return chord * asin_ratio(arc.curvature_m * chord / 2);
}

// Sets the length of the ray in its layer, and the border at which it leaves.
void find_end(const SoundLayers& layers, RayArc& arc) {
  const RayPoint& from = arc.start;
  const double p = from.cos_phi / from.speed_m_s;
  const auto reach = [&](bool upper, double sign) -> std::optional<double> {
    const int border = upper ? arc.layer : arc.layer - 1;
    if (border < 0 || border >= static_cast<int>(layers.z_m.size())) return std::nullopt;
    const double rise = layers.z_m[border] - from.z_m, speed = layers.speed_m_s[border];
    const double square =
        from.sin_phi * from.sin_phi - p * p * (arc.gradient_s * rise) * (speed + from.speed_m_s);
    if (square < 0) return std::nullopt;
    return length_to(arc, rise, sign * std::sqrt(square), speed);
  };
  arc.length_m = kForever;
  if (from.sin_phi == 0 && arc.curvature_m == 0) return;
  const bool up = from.sin_phi > 0 || (from.sin_phi == 0 && arc.curvature_m < 0);
  const double sign = up ? 1 : -1;
  std::optional<double> length = reach(up, sign);
  const bool ahead = length.has_value();
  const bool turns = up ? arc.curvature_m > 0 : arc.curvature_m < 0;
  if (!ahead && turns) length = reach(!up, -sign);
  if (!length) return;
  arc.length_m = *length;
  arc.leaves_up = ahead == up;
}

void enter_layer(const SoundLayers& layers, int layer, RayArc& arc) {
  arc.layer = layer;
  arc.gradient_s = layers.gradient_s[layer];
  arc.curvature_m = arc.gradient_s * arc.start.cos_phi / arc.start.speed_m_s;
  find_end(layers, arc);
}

// The ray along a border that refracts it back from both sides.
RayArc along_border(RayArc arc) {
  arc.start.sin_phi = 0;
  arc.start.cos_phi = 1;
  arc.gradient_s = arc.curvature_m = 0;
  arc.length_m = kForever;
  return arc;
}

bool bends_back(double curvature_m, double sin_phi) {
  return curvature_m * sin_phi > 0 && sin_phi * sin_phi < 2 * std::abs(curvature_m) * kLeastSwing_m;
}

}  // namespace

SoundLayers make_layers(const SoundProfile& profile) {
  const std::size_t rows = profile.depth_m.size();
  ENSONIFY_ASSERT(rows > 0 && profile.speed_m_s.size() == rows);
  SoundLayers layers;
  layers.gradient_s.push_back(0);
  for (std::size_t i = rows; i-- > 0;) {
    layers.z_m.push_back(profile.surface_z_m - profile.depth_m[i]);
    layers.speed_m_s.push_back(profile.speed_m_s[i]);
    layers.fastest_m_s = std::max(layers.fastest_m_s, profile.speed_m_s[i]);
    if (i == 0) break;
    layers.gradient_s.push_back((profile.speed_m_s[i - 1] - profile.speed_m_s[i]) /
                                (profile.depth_m[i] - profile.depth_m[i - 1]));
  }
  layers.gradient_s.push_back(0);
  return layers;
}

double sound_speed_at(const SoundLayers& layers, double z_m) {
  const int layer = layer_at(layers, z_m);
  const int below = std::max(layer - 1, 0);
  return layers.speed_m_s[below] + layers.gradient_s[layer] * (z_m - layers.z_m[below]);
}

bool bends(const Water& water) {
  if (!water.profile) return false;
  const std::vector<double>& speeds = water.profile->speed_m_s;
  return std::any_of(speeds.begin(), speeds.end(),
                     [&](double c) { return c != water.sound_speed_m_s; });
}

RayArc start_ray(const SoundLayers& layers, double z_m, double cos_phi, double sin_phi) {
  RayArc arc;
  arc.start.z_m = z_m;
  arc.start.cos_phi = cos_phi;
  arc.start.sin_phi = sin_phi;
  arc.start.speed_m_s = sound_speed_at(layers, z_m);
  arc.source_speed_m_s = arc.start.speed_m_s;
  arc.opening = 1 / arc.source_speed_m_s;
  int layer = layer_at(layers, z_m);
  // A ray that starts on a border belongs to the layer that it enters.
  if (layer > 0 && z_m == layers.z_m[layer - 1]) {
    const bool down = sin_phi < 0 || (sin_phi == 0 && layers.gradient_s[layer] > 0 && cos_phi > 0);
    if (down) --layer;
    const bool axis = sin_phi == 0 && layers.gradient_s[layer] < 0 && down;
    enter_layer(layers, layer, arc);
    return axis ? along_border(arc) : arc;
  }
  enter_layer(layers, layer, arc);
  return arc;
}

RayPoint point_on(const RayArc& arc, double s_m) {
  const RayPoint& from = arc.start;
  const double half = arc.curvature_m * s_m / 2;
  const auto [ch, ratio] = half_turn(half);
  const double sh = half * ratio;
  // The direction of the chord, then that of the end.
  const double cos_chord = from.cos_phi * ch + from.sin_phi * sh;
  const double sin_chord = from.sin_phi * ch - from.cos_phi * sh;
  const double chord = s_m * ratio;
  RayPoint to;
  to.x_m = from.x_m + chord * cos_chord;
  to.z_m = from.z_m + chord * sin_chord;
  to.cos_phi = cos_chord * ch + sin_chord * sh;
  to.sin_phi = sin_chord * ch - cos_chord * sh;
  to.speed_m_s = from.speed_m_s + arc.gradient_s * (chord * sin_chord);
  const double mean_speed = std::sqrt(from.speed_m_s * to.speed_m_s);
  to.time_s =
      from.time_s + chord / mean_speed * asinh_ratio(arc.gradient_s * chord / (2 * mean_speed));
  to.path_m = from.path_m + s_m;
  // The integral of c ds.
  const double swept =
      chord * (from.speed_m_s * ch + from.sin_phi * arc.gradient_s * (s_m / 2) * ratio);
  to.lateral_m = from.lateral_m + swept / arc.source_speed_m_s;
  to.spread_m = from.spread_m + arc.opening * swept;
  return to;
}

RayArc next_arc(const SoundLayers& layers, const RayArc& arc) {
  ENSONIFY_ASSERT(std::isfinite(arc.length_m));
  RayArc next = arc;
  next.start = point_on(arc, arc.length_m);
  RayPoint& at = next.start;
  const bool up = arc.leaves_up;
  const int border = up ? arc.layer : arc.layer - 1;
  const int layer = up ? arc.layer + 1 : arc.layer - 1;
  at.z_m = layers.z_m[border];
  at.speed_m_s = layers.speed_m_s[border];
  // Snell's law, from the start of the arc.
  at.cos_phi = std::min(arc.start.cos_phi * at.speed_m_s / arc.start.speed_m_s, 1.0);
  const double sine = std::sqrt((1 - at.cos_phi) * (1 + at.cos_phi));
  at.sin_phi = up ? sine : -sine;
  // Neighboring rays cross the kink of c at different points.
  const double kink = layers.gradient_s[layer] - arc.gradient_s;
  const double ratio = at.cos_phi / at.speed_m_s;
  const double steep = std::max(sine, 1e-12);
  next.opening -= kink * ratio * ratio * at.spread_m / (up ? steep : -steep);
  enter_layer(layers, layer, next);
  const double before = arc.curvature_m;
  const bool held =
      bends_back(next.curvature_m, up ? steep : -steep) && (up ? before < 0 : before > 0);
  return held ? along_border(next) : next;
}

std::optional<RayPoint> ray_at_distance(const SoundLayers& layers, RayArc arc, double x_m) {
  if (arc.start.cos_phi <= 0) return std::nullopt;
  while (std::isfinite(arc.length_m)) {
    const RayArc next = next_arc(layers, arc);
    if (next.start.x_m >= x_m) break;
    arc = next;
  }
  const RayPoint& from = arc.start;
  const double across = x_m - from.x_m;
  const double sine = from.sin_phi - arc.curvature_m * across;
  const double square =
      from.cos_phi * from.cos_phi + arc.curvature_m * across * (from.sin_phi + sine);
  if (square <= 0) return std::nullopt;
  const double rise = across * (from.sin_phi + sine) / (from.cos_phi + std::sqrt(square));
  const double chord = std::hypot(across, rise);
  return point_on(arc, chord * asin_ratio(arc.curvature_m * chord / 2));
}

double two_way_spreading_m2(const RayPoint& point, double source_speed_m_s, double frequency_hz) {
  const double r = point.lateral_m;
  const double waves = 2 * kPi * frequency_hz / source_speed_m_s * r;
  const double least = r * std::min(1.0, std::cbrt(1 / waves));
  return source_speed_m_s / point.speed_m_s * r * std::max(std::abs(point.spread_m), least);
}

namespace {

// One search for a direction that passes through the target.
struct Aim {
  const SoundLayers& layers;
  double z_m, x_m, end_z_m;

  struct Shot {
    double phi_rad = 0;
    double miss_m = 0;  // how far above the target it passes
    Eigenray ray;
  };

  Shot shoot(double phi_rad) const {
    const double cosine = std::cos(phi_rad), sine = std::sin(phi_rad);
    const auto end = ray_at_distance(layers, start_ray(layers, z_m, cosine, sine), x_m);
    if (!end) return {phi_rad, sine > 0 ? kForever : -kForever, {}};
    return {phi_rad, end->z_m - end_z_m, {cosine, sine, *end}};
  }

  // Removes the remaining miss, which lies along the ray where it is steep.
  Eigenray at_target(const Shot& shot) const {
    Eigenray ray = shot.ray;
    RayPoint& end = ray.end;
    const double along = (x_m - end.x_m) * end.cos_phi + (end_z_m - end.z_m) * end.sin_phi;
    end.x_m = x_m;
    end.z_m = end_z_m;
    end.path_m += along;
    end.time_s += along / end.speed_m_s;
    return ray;
  }

  bool hits(const Shot& shot) const {
    if (!std::isfinite(shot.miss_m)) return false;
    const double way = 1 + x_m + std::abs(end_z_m - z_m);
    return std::abs(shot.miss_m) * shot.ray.end.cos_phi <= 1e-12 * way;
  }

  // Searches between a ray that passes below the target and one that passes above. Returns none if
  // no ray between them hits it.
  std::optional<Shot> between(double low, double high, double first) const {
    double phi = first;
    constexpr int kMost = 200;
    for (int i = 0; i < kMost; ++i) {
      const Shot shot = shoot(phi);
      if (hits(shot)) return shot;
      (shot.miss_m > 0 ? high : low) = phi;
      const double middle = low + (high - low) / 2;
      if (middle <= low || middle >= high) return last_of(shot);
      // The ray above it by dphi passes spread/cos(phi) dphi higher.
      phi -= shot.miss_m * shot.ray.end.cos_phi / shot.ray.end.spread_m;
      if (!(phi > low && phi < high) || i >= 40) phi = middle;
    }
    return std::nullopt;
  }

  // The nearest ray, if no double lies between two directions; none if it still misses.
  std::optional<Shot> last_of(const Shot& shot) const {
    if (!std::isfinite(shot.miss_m)) return std::nullopt;
    const double step = 1e-15 * std::abs(shot.ray.end.spread_m);
    const double near = std::abs(shot.miss_m) * shot.ray.end.cos_phi;
    return near <= std::max(4 * step, 1e-9) ? std::optional(shot) : std::nullopt;
  }
};

constexpr double kSteepest_rad = kPi / 2 - 1e-9;

// The fastest of all rays, found where the miss changes its sign between directions.
std::optional<Aim::Shot> fastest_of_all(const Aim& aim) {
  constexpr int kSteps = 360;
  std::optional<Aim::Shot> best;
  Aim::Shot before = aim.shoot(-kSteepest_rad);
  for (int i = 1; i <= kSteps; ++i) {
    const Aim::Shot shot = aim.shoot(kSteepest_rad * (2.0 * i / kSteps - 1));
    if ((before.miss_m > 0) != (shot.miss_m > 0)) {
      const bool rises = shot.miss_m > 0;
      const double low = rises ? before.phi_rad : shot.phi_rad;
      const double high = rises ? shot.phi_rad : before.phi_rad;
      const auto found = aim.between(low, high, low + (high - low) / 2);
      if (found && (!best || found->ray.end.time_s < best->ray.end.time_s)) best = found;
    }
    before = shot;
  }
  return best;
}

Eigenray vertical_ray(const SoundLayers& layers, double z_m, double end_z_m) {
  Eigenray ray{0, end_z_m < z_m ? -1.0 : 1.0, {}};
  RayArc arc = start_ray(layers, z_m, 0, ray.sin_phi);
  const double way = std::abs(end_z_m - z_m);
  while (arc.start.path_m + arc.length_m < way) arc = next_arc(layers, arc);
  ray.end = point_on(arc, way - arc.start.path_m);
  return ray;
}

}  // namespace

std::optional<Eigenray> find_eigenray(const SoundLayers& layers, double z_m, double x_m,
                                      double end_z_m) {
  if (x_m <= 1e-9 * std::abs(end_z_m - z_m)) return vertical_ray(layers, z_m, end_z_m);
  const Aim aim{layers, z_m, x_m, end_z_m};
  const double straight = std::clamp(std::atan2(end_z_m - z_m, x_m), -kSteepest_rad, kSteepest_rad);
  const auto found = aim.between(-kPi / 2, kPi / 2, straight);
  if (found && found->ray.end.spread_m > 0) return aim.at_target(*found);
  auto best = fastest_of_all(aim);
  if (!best || (found && found->ray.end.time_s <= best->ray.end.time_s)) best = found;
  return best ? std::optional(aim.at_target(*best)) : std::nullopt;
}

}  // namespace ensonify
