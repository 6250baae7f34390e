#include "dataset/tables.h"

#include <fmt/format.h>

#include "dataset/layout.h"

namespace ensonify {
namespace {

std::string pose_columns(const Pose& pose) {
  const Vec3& p = pose.position_m;
  const Quat& q = pose.rotation;
  return fmt::format("{},{},{},{},{},{},{}", p.x, p.y, p.z, q.w, q.x, q.y, q.z);
}

}  // namespace

std::string poses_row(std::uint32_t ping, double time_s, const Pose& sonar_in_world) {
  return fmt::format("{},{},{}\n", ping, time_s, pose_columns(sonar_in_world));
}

std::string tum_row(double time_s, const Pose& sonar_in_world) {
  const Vec3& p = sonar_in_world.position_m;
  const Quat& q = sonar_in_world.rotation;
  return fmt::format("{} {} {} {} {} {} {} {}\n", time_s, p.x, p.y, p.z, q.x, q.y, q.z, q.w);
}

std::string objects_rows(std::uint32_t ping, const std::vector<Pose>& object_in_world) {
  std::string rows;
  for (std::size_t i = 0; i < object_in_world.size(); ++i) {
    rows += fmt::format("{},{},{}\n", ping, i + 1, pose_columns(object_in_world[i]));
  }
  return rows;
}

std::string index_row(std::uint32_t sequence, std::uint32_t ping, double time_s,
                      const std::string& split) {
  return fmt::format("{},{},{},{},{}\n", sequence, ping, time_s, split,
                     layout::index_stem(sequence, ping));
}

}  // namespace ensonify
