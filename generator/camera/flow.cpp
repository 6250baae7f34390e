#include "camera/flow.h"

#include <cmath>
#include <optional>

namespace ensonify {
namespace {

float in_steps(double value_px) {
  return static_cast<float>(std::round(value_px / kFlowQuantum_px) * kFlowQuantum_px);
}

}  // namespace

void add_flow(const CameraShot& shot, const NextShot& next, CameraView& view,
              const Workers& workers) {
  const auto columns = static_cast<std::size_t>(view.columns);
  workers.for_each(static_cast<std::size_t>(view.rows), [&](std::size_t row) {
    for (std::size_t pixel = row * columns; pixel < (row + 1) * columns; ++pixel) {
      if (view.instance[pixel] == 0) continue;
      const std::size_t object = view.instance[pixel] - std::size_t{1};
      const Vec3 seen_m = static_cast<double>(view.depth_m[pixel]) * shot.rays[pixel];
      const Vec3 now_m = transform_point(shot.camera_in_world, seen_m);
      const Vec3 then_m = transform_point(next.object_then[object],
                                          inverse_transform_point(next.object_now[object], now_m));
      const std::optional<ImagePoint> place =
          projected(shot.camera.optics, inverse_transform_point(next.camera_in_world, then_m));
      if (!place) continue;
      view.flow_x_px[pixel] = in_steps(place->x - static_cast<double>(pixel - row * columns));
      view.flow_y_px[pixel] = in_steps(place->y - static_cast<double>(row));
    }
  });
}

}  // namespace ensonify
