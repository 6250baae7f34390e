#include "navigation/tables.h"

#include <fmt/format.h>

#include <iterator>
#include <string>

#include "navigation/imu.h"

namespace ensonify {

void write_navigation(
    const Navigation& sensors, const NavigationScene& scene,
    const std::function<void(NavigationTable table, std::string_view text)>& append) {
  const auto rows_of = [&](NavigationTable table) -> EmitRow {
    append(table, kNavigationTables[static_cast<std::size_t>(table)].header);
    return [&append, table](std::span<const double> values) {
      std::string line;
      for (const double value : values) {
        // -0 would print its sign.
        fmt::format_to(std::back_inserter(line), "{}{}", line.empty() ? "" : ",", value + 0.0);
      }
      append(table, line + "\n");
    };
  };
  const Course& course = scene.course;
  if (const auto& imu = sensors.imu) {
    const EmitRow samples = rows_of(NavigationTable::imu);
    simulate_imu(*imu, course, samples, rows_of(NavigationTable::imu_truth));
  }
  if (const auto& dvl = sensors.dvl) {
    simulate_dvl(*dvl, course, scene.find_range, rows_of(NavigationTable::dvl));
  }
  if (const auto& depth = sensors.depth) {
    simulate_depth(*depth, scene.density_kg_m3, course, rows_of(NavigationTable::depth));
  }
  if (const auto& altimeter = sensors.altimeter) {
    simulate_altimeter(*altimeter, course, scene.find_range, rows_of(NavigationTable::altimeter));
  }
  if (const auto& usbl = sensors.usbl) {
    simulate_usbl(*usbl, course, rows_of(NavigationTable::usbl));
  }
  if (const auto& gps = sensors.gps) {
    simulate_gps(*gps, course, rows_of(NavigationTable::gps));
  }
  if (const auto& odometry = sensors.odometry) {
    simulate_odometry(*odometry, course, rows_of(NavigationTable::odometry));
  }
}

}  // namespace ensonify
