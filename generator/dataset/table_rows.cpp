#include "dataset/table_rows.h"

#include <fmt/format.h>

#include <cstring>

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

std::string boxes_rows(std::uint32_t ping, const Pose& sonar_in_world,
                       const std::vector<Pose>& object_in_world,
                       const std::vector<Instance>& instances) {
  const Quat to_sonar = conjugate(sonar_in_world.rotation);
  const Pose world_in_sonar{rotate(to_sonar, -sonar_in_world.position_m), to_sonar};
  std::string rows;
  for (const Instance& instance : instances) {
    if (!instance.box) continue;
    // Volumes come last and have no pose.
    const std::size_t i = instance.id - std::size_t{1};
    const Pose frame = i < object_in_world.size() ? object_in_world[i] : Pose{};
    const Pose in_world = compose(frame, instance.box->pose);
    const Vec3& size = instance.box->size_m;
    rows += fmt::format("{},{},{},{},{},{},{}\n", ping, instance.id, size.x, size.y, size.z,
                        pose_columns(in_world), pose_columns(compose(world_in_sonar, in_world)));
  }
  return rows;
}

std::array<std::string, 6> table_rows(const PingRecord& record,
                                      const std::vector<Instance>& instances) {
  std::string first_return(record.first_return_m.size() * sizeof(float), '\0');
  std::memcpy(first_return.data(), record.first_return_m.data(), first_return.size());
  return {poses_row(record.ping, record.time_s, record.sonar_in_world),
          tum_row(record.time_s, record.sonar_in_world),
          objects_rows(record.ping, record.object_in_world),
          boxes_rows(record.ping, record.sonar_in_world, record.object_in_world, instances),
          std::move(first_return),
          record.annotations};
}

std::string index_row(std::uint32_t sequence, std::uint32_t ping, double time_s,
                      const std::string& split) {
  return fmt::format("{},{},{},{},{}\n", sequence, ping, time_s, split,
                     layout::index_stem(sequence, ping));
}

}  // namespace ensonify
