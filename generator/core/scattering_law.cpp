#include "core/scattering_law.h"

#include <algorithm>

#include "core/error.h"

namespace ensonify {

double tabulated_db(const BackscatterTable& table, double grazing_rad) {
  const std::vector<double>& grazing = table.grazing_rad;
  ENSONIFY_ASSERT(grazing.size() >= 2 && grazing.size() == table.strength_db.size());
  const auto above = std::upper_bound(grazing.begin() + 1, grazing.end() - 1, grazing_rad);
  const std::size_t high = above - grazing.begin(), low = high - 1;
  // Rounding may leave the last row slightly below 90 degrees.
  const double part =
      std::clamp((grazing_rad - grazing[low]) / (grazing[high] - grazing[low]), 0.0, 1.0);
  return table.strength_db[low] + part * (table.strength_db[high] - table.strength_db[low]);
}

}  // namespace ensonify
