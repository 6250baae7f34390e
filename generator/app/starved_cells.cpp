#include "app/starved_cells.h"

#include <fmt/format.h>

#include "core/units.h"
#include "trace/by_need.h"

namespace ensonify {

std::optional<std::string> starved_warning(const Session& session, const Tracer& tracer,
                                           const Workers& workers) {
  constexpr double kShare = 0.05;
  if (session.surface_tiles) return std::nullopt;  // has enough by itself
  const Fan fan = make_fan(session.sonar);
  const Pose pose = sonar_pose(session, 0);
  const std::vector<Hit> hits =
      tracer.at(object_poses(session, 0)).trace_fan(fan, pose, session.sonar.range_max_m, workers);
  const double share = starved_share(session.sonar, session.cell, fan, hits, pose, kFewScatterers);
  if (share <= kShare) return std::nullopt;
  const char* advice = session.sonar.rays_per_cell == 0
                           ? "sonar.rays.per_cell: 20 adds rays where they are needed"
                           : "raise sonar.rays.elevation or sonar.rays.per_cell";
  return fmt::format(
      "ping 0: {:.0f} % of the surface in range has fewer than {:.0f} scatterers in a resolution "
      "cell ({:.2g} deg x {:.2g} m): speckle is not developed there, and gaps may show; {}",
      100 * share, kFewScatterers, degrees(session.cell.width_rad), session.cell.range_m, advice);
}

}  // namespace ensonify
