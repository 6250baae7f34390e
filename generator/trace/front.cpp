#include "trace/front.h"

#include <algorithm>
#include <cmath>

#include "acoustics/scattering.h"
#include "core/error.h"
#include "core/front_planes.h"
#include "trace/echo.h"

namespace ensonify {
namespace {

// One worker writes this many columns, because their pixels share cache lines.
constexpr std::size_t kColumnsTogether = 16;

float stored(double value, double quantum) {
  return static_cast<float>(std::round(value / quantum) * quantum);
}

FrontView blank_view(const Fan& fan) {
  FrontView view;
  view.rows = fan.rays_elevation;
  view.columns = static_cast<int>(fan.azimuth_rad.size());
  for (const FrontPlane& plane : kFrontPlanes) {
    with_plane(view, plane, [&](auto& values) {
      using Value = typename std::decay_t<decltype(values)>::value_type;
      values.assign(fan.size(), blank_value<Value>(plane.blank));
    });
  }
  return view;
}

void set_pixel(const Hit& hit, Vec3 direction, double backscatter, const Pose& sonar_in_world,
               std::size_t pixel, FrontView& view) {
  const Vec3 normal = rotate(conjugate(sonar_in_world.rotation), hit.normal);
  const double side = dot(normal, direction) > 0 ? -1 : 1;
  view.range_m[pixel] = stored(hit.range_m, kFrontRangeQuantum_m);
  view.normal_x[pixel] = stored(side * normal.x, kFrontNormalQuantum);
  view.normal_y[pixel] = stored(side * normal.y, kFrontNormalQuantum);
  view.normal_z[pixel] = stored(side * normal.z, kFrontNormalQuantum);
  view.backscatter_db[pixel] =
      stored(std::max<double>(kNoEnergyDb, 10 * std::log10(backscatter)), kFrontLevelQuantum_db);
  view.instance[pixel] = static_cast<std::uint16_t>(hit.instance);
}

}  // namespace

FrontView front_view(const Fan& fan, std::span<const Hit> hits, std::span<const RayPath> paths,
                     const SurfaceScattering& scattering, const Pose& sonar_in_world,
                     const Workers& workers) {
  ENSONIFY_ASSERT(hits.size() == fan.size() && (paths.empty() || paths.size() == fan.size()));
  FrontView view = blank_view(fan);
  const std::size_t columns = fan.azimuth_rad.size(), rows = fan.elevation_rad.size();
  const auto write_column = [&](std::size_t column) {
    for (std::size_t row = 0; row < rows; ++row) {
      const std::size_t ray = column * rows + row;
      const Hit& hit = hits[ray];
      if (!is_usable(hit, scattering.sonar)) continue;
      const double backscatter =
          surface_backscatter(material_at(scattering, hit), hit.reflectivity, hit.cos_incidence);
      const Vec3 direction =
          paths.empty() ? unit_vector(fan.azimuth_rad[column], fan.elevation_rad[row])
                        : paths[ray].position_m;
      set_pixel(hit, direction, backscatter, sonar_in_world, row * columns + column, view);
    }
  };
  workers.for_each((columns + kColumnsTogether - 1) / kColumnsTogether, [&](std::size_t block) {
    const std::size_t first = block * kColumnsTogether;
    for (std::size_t column = first; column < std::min(first + kColumnsTogether, columns);
         ++column) {
      write_column(column);
    }
  });
  return view;
}

}  // namespace ensonify
