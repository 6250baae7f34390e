// One folder per sequence: sonar.txt, and objects/ID_NAME.txt for each object with a pose.
#include <fmt/format.h>

#include <cerrno>
#include <fstream>
#include <map>
#include <system_error>

#include "export/job.h"
#include "formats/files.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

// Trajectories of many objects grow at the same time: they are buffered up to this total size.
constexpr std::size_t kHeldBytes = std::size_t{1} << 22;

std::string tum_line(double time_s, const Pose& pose) {
  const Vec3& p = pose.position_m;
  const Quat& q = pose.rotation;
  return fmt::format("{} {} {} {} {} {} {} {}\n", time_s, p.x, p.y, p.z, q.x, q.y, q.z, q.w);
}

std::string file_name(const StoredInstance& instance) {
  return fmt::format("{:05}_{}.txt", instance.id, plain_name(instance.name, 94));
}

// The folder of the export is temporary, so that a file need not appear whole.
Status append_to(const fs::path& path, const std::string& text) {
  std::error_code failed;
  fs::create_directories(path.parent_path(), failed);
  if (failed) return write_error(path, failed.value());
  errno = 0;
  std::ofstream file(path, std::ios::binary | std::ios::app);
  file << text;
  file.close();
  return file ? Status() : Status(write_error(path, errno));
}

class Trajectories {
 public:
  Trajectories(fs::path folder, const StoredSequence& sequence)
      : folder_(std::move(folder)), sequence_(sequence) {}

  // Instance 0 is the sonar.
  Status add(std::uint32_t instance, const std::string& line) {
    texts_[instance] += line;
    held_ += line.size();
    return held_ < kHeldBytes ? Status() : flush();
  }
  Status flush() {
    for (const auto& [instance, text] : texts_) {
      const fs::path name =
          instance == 0 ? fs::path("sonar.txt")
                        : fs::path("objects") / file_name(sequence_.instances[instance - 1]);
      if (const Status written = append_to(folder_ / name, text); !written) return written;
    }
    texts_.clear();
    held_ = 0;
    return {};
  }

 private:
  fs::path folder_;
  const StoredSequence& sequence_;
  std::map<std::uint32_t, std::string> texts_;
  std::size_t held_ = 0;
};

}  // namespace

Status write_tum(const ExportJob& job, const fs::path& target) {
  return for_each_sequence(job, [&](const StoredSequence& sequence) -> Status {
    Trajectories trajectories(target / fmt::format("{:06}", sequence.row.sequence), sequence);
    const Status read = for_each_exported_ping(job, sequence, [&](const StoredPing& ping) {
      Status added = trajectories.add(0, tum_line(ping.time_s, ping.sonar_in_world));
      for (const StoredObjectPose& object : ping.objects) {
        if (!added) break;
        added = trajectories.add(object.instance, tum_line(ping.time_s, object.in_world));
      }
      return added;
    });
    return read ? trajectories.flush() : read;
  });
}

}  // namespace ensonify
