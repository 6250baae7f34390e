// The tables of a sequence's navigation sensors, as text.
//
//   NavigationScene  write_navigation
#pragma once

#include <functional>
#include <string_view>

#include "core/navigation_tables.h"
#include "navigation/sensors.h"

namespace ensonify {

struct NavigationScene {
  Course course;
  FindRange find_range;
  double density_kg_m3 = 0;  // of the water
};

// Appends every table of the sensors, from its header on, piece by piece.
void write_navigation(
    const Navigation& sensors, const NavigationScene& scene,
    const std::function<void(NavigationTable table, std::string_view text)>& append);

}  // namespace ensonify
