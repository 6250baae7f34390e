// The keys of navigation sensors, and what two of them exclude.
#include <fmt/format.h>

#include "core/navigation_keys.h"
#include "scenario/sections.h"

namespace ensonify {
namespace {

template <class Sensor>
void check_ranges(Fields& f, const char* name, const std::optional<Sensor>& sensor) {
  if (!sensor || sensor->range_min_m < sensor->range_max_m) return;
  f.fault(name, fmt::format("range_min_m of {} m is not below range_max_m of {} m; expected a "
                            "nearer one",
                            sensor->range_min_m, sensor->range_max_m));
}

}  // namespace

void fields(Fields& f, Navigation& navigation) {
  const ReadWatch watch(f);
  navigation_keys(f, navigation);
  if (!watch.is_well()) return;
  check_ranges(f, "dvl", navigation.dvl);
  check_ranges(f, "altimeter", navigation.altimeter);
  const auto& [imu, dvl, depth, altimeter, usbl, gps, odometry] = navigation;
  if (imu || dvl || depth || altimeter || usbl || gps || odometry) return;
  f.fault("",
          "there is no sensor; expected one of imu, dvl, depth, altimeter, usbl, gps, odometry");
}

}  // namespace ensonify
