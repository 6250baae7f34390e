#include "camera/view.h"

#include <cmath>

#include "camera/color.h"
#include "core/camera_planes.h"
#include "core/error.h"

namespace ensonify {
namespace {

float rounded(double value, double quantum) {
  return static_cast<float>(std::round(value / quantum) * quantum);
}

CameraView blank_view(const CameraOptics& optics, const OutputSelection& output) {
  CameraView view;
  view.rows = optics.height_px;
  view.columns = optics.width_px;
  const auto pixels = static_cast<std::size_t>(view.rows) * static_cast<std::size_t>(view.columns);
  for (const CameraPlane& plane : kCameraPlanes) {
    // Flow follows from depth and instances.
    const bool is_geometry = plane.wanted == &OutputSelection::camera_geometry;
    if (!is_geometry && !(output.*plane.wanted)) continue;
    with_plane(view, plane, [&](auto& values) {
      using Value = typename std::decay_t<decltype(values)>::value_type;
      values.assign(pixels * static_cast<std::size_t>(plane.channels),
                    blank_value<Value>(plane.blank));
    });
  }
  return view;
}

void set_geometry(const CameraShot& shot, const Hit& hit, std::size_t pixel, CameraView& view) {
  const Vec3 ray = shot.rays[pixel];
  const Vec3 normal = rotate(conjugate(shot.camera_in_world.rotation), hit.normal);
  const double side = dot(normal, ray) > 0 ? -1 : 1;
  view.depth_m[pixel] = rounded(hit.range_m / length(ray), kDepthQuantum_m);
  view.normal_x[pixel] = rounded(side * normal.x, kCameraNormalQuantum);
  view.normal_y[pixel] = rounded(side * normal.y, kCameraNormalQuantum);
  view.normal_z[pixel] = rounded(side * normal.z, kCameraNormalQuantum);
  view.instance[pixel] = static_cast<std::uint16_t>(hit.instance);
  view.semantic[pixel] = shot.class_of_instance[hit.instance];
}

// Where rays meet surfaces. `painted` is empty if no colors are wanted.
struct SeenRow {
  explicit SeenRow(std::size_t rays, bool colors) : hits(rays), painted(colors ? rays : 0) {}

  std::vector<Hit> hits;
  std::vector<VertexColor> painted;
};

void look(const CameraShot& shot, std::span<const Vec3> rays, SeenRow& row) {
  shot.tracer.first_hits(shot.camera_in_world, rays, shot.camera.range_max_m, row.hits,
                         row.painted);
}

Rgb light_of(const CameraShot& shot, const Rgb& veil, const SeenRow& row, std::size_t column,
             Vec3 ray) {
  const Hit& hit = row.hits[column];
  if (hit.instance == 0) return seen_water(shot.camera, veil);
  const Vec3 direction = rotate(shot.camera_in_world.rotation, normalized(ray));
  const Vec3 normal = dot(hit.normal, direction) > 0 ? -hit.normal : hit.normal;
  const Vec3 point_m = shot.camera_in_world.position_m + hit.range_m * direction;
  Rgb color = shot.colors[hit.instance][hit.part];
  for (double& share : color) share *= static_cast<double>(hit.reflectivity);
  if (row.painted[column]) color = *row.painted[column];
  return seen_surface(shot.camera, veil,
                      {color, point_m.z, hit.range_m, normal.z, -dot(normal, direction)});
}

// Adds the mean over the rays of each pixel of a row.
void add_samples(const CameraShot& shot, const Rgb& veil, std::size_t row,
                 std::vector<Rgb>& light) {
  const int samples = shot.camera.samples;
  std::vector<Vec3> rays(light.size());
  SeenRow seen(light.size(), true);
  for (int sample = 0; sample < samples * samples; ++sample) {
    const double u = (sample % samples + 0.5) / samples - 0.5;
    const double v = (sample / samples + 0.5) / samples - 0.5 + static_cast<double>(row);
    for (std::size_t column = 0; column < rays.size(); ++column) {
      rays[column] = pixel_direction(shot.camera.optics, u + static_cast<double>(column), v);
    }
    look(shot, rays, seen);
    for (std::size_t column = 0; column < rays.size(); ++column) {
      const Rgb part = light_of(shot, veil, seen, column, rays[column]);
      for (std::size_t c = 0; c < 3; ++c) light[column][c] += part[c] / (samples * samples);
    }
  }
}

void set_colors(const CameraShot& shot, std::size_t row, const SeenRow& seen, CameraView& view) {
  const Rgb veil = veil_at(shot.camera, shot.camera_in_world.position_m.z);
  std::vector<Rgb> light(seen.hits.size(), Rgb{});
  if (shot.camera.samples > 1) {
    add_samples(shot, veil, row, light);
  } else {
    for (std::size_t column = 0; column < light.size(); ++column) {
      light[column] = light_of(shot, veil, seen, column, shot.rays[row * light.size() + column]);
    }
  }
  for (std::size_t i = 0; i < light.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      view.color[3 * (row * light.size() + i) + c] = srgb(light[i][c]);
    }
  }
}

}  // namespace

std::vector<Vec3> camera_rays(const CameraOptics& optics) {
  std::vector<Vec3> rays;
  rays.reserve(static_cast<std::size_t>(optics.width_px) *
               static_cast<std::size_t>(optics.height_px));
  for (int v = 0; v < optics.height_px; ++v) {
    for (int u = 0; u < optics.width_px; ++u) rays.push_back(pixel_direction(optics, u, v));
  }
  return rays;
}

CameraView camera_view(const CameraShot& shot, const OutputSelection& output,
                       const Workers& workers) {
  CameraView view = blank_view(shot.camera.optics, output);
  const auto columns = static_cast<std::size_t>(view.columns);
  ENSONIFY_ASSERT(shot.rays.size() == columns * static_cast<std::size_t>(view.rows));
  workers.for_each(static_cast<std::size_t>(view.rows), [&](std::size_t row) {
    SeenRow seen(columns, output.camera_color);
    look(shot, shot.rays.subspan(row * columns, columns), seen);
    for (std::size_t column = 0; column < columns; ++column) {
      if (seen.hits[column].instance == 0) continue;
      set_geometry(shot, seen.hits[column], row * columns + column, view);
    }
    if (output.camera_color) set_colors(shot, row, seen, view);
  });
  return view;
}

}  // namespace ensonify
