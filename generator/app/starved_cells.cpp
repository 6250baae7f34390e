#include "app/starved_cells.h"

#include <fmt/format.h>

#include "core/units.h"
#include "trace/by_need.h"

namespace ensonify {
namespace {

constexpr double kShare = 0.05;

std::string starved_text(const Session& session, double share, const std::string& begin,
                         const std::string& advice) {
  return fmt::format(
      "ping 0: {}{:.0f} % of the surface in range has fewer than {:.0f} scatterers in a resolution "
      "cell ({:.2g} deg x {:.2g} m): speckle is not developed there, and gaps may show; {}",
      begin, 100 * share, kFewScatterers, degrees(session.cell.width_rad), session.cell.range_m,
      advice);
}

}  // namespace

std::vector<std::string> starved_warnings(const Session& session, const Tracer& tracer,
                                          const Workers& workers) {
  const Fan fan = make_fan(session.sonar);
  const Pose pose = sonar_pose(session, 0);
  const std::vector<Hit> hits =
      tracer.at(object_poses(session, 0)).trace_fan(fan, pose, session.sonar.range_max_m, workers);
  const auto share_of = [&](const Sonar& sonar) {
    return starved_share(sonar, session.cell, fan, hits, pose, kFewScatterers);
  };
  std::vector<std::string> warnings;
  const bool by_need = session.sonar.rays_per_cell > 0;
  // Scatterers fixed on surfaces are enough by themselves.
  const double share = session.surface_tiles ? 0 : share_of(session.sonar);
  if (share > kShare) {
    warnings.push_back(
        starved_text(session, share, "",
                     by_need ? "raise sonar.rays.elevation or sonar.rays.per_cell"
                             : "sonar.rays.per_cell: 20 adds rays where they are needed"));
  }
  if (session.bounces.paths.empty() || (!by_need && !session.surface_tiles)) return warnings;
  Sonar of_fan = session.sonar;
  of_fan.rays_per_cell = 0;
  const double bounced = share_of(of_fan);
  if (bounced > kShare) {
    warnings.push_back(starved_text(session, bounced,
                                    "echoes over mirrors come of the rays of the fan alone, with "
                                    "which ",
                                    "raise sonar.rays.elevation"));
  }
  return warnings;
}

}  // namespace ensonify
