#include <fmt/format.h>

#include <array>
#include <fstream>
#include <span>

#include "dataset/layout.h"
#include "dataset/read_dataset.h"
#include "dataset/tables.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

Pose pose_from(std::span<const double> v) { return {{v[0], v[1], v[2]}, {v[3], v[4], v[5], v[6]}}; }

// A table of nine numbers a row, one row ahead.
class Table {
 public:
  explicit Table(fs::path path) : path_(std::move(path)), file_(path_, std::ios::binary) {}

  Status begin(std::string_view header) {
    std::string line;
    if (!std::getline(file_, line) || line + "\n" != header) {
      return damaged(path_, "does not begin with its header");
    }
    return advance();
  }
  Status advance() {
    std::string line;
    there_ = static_cast<bool>(std::getline(file_, line));
    if (there_ && !read_numbers(line, values_)) return damaged(path_, "has a wrong row: " + line);
    return {};
  }
  // Whether there is a row, and of this ping.
  bool is_of(std::uint32_t ping) const { return there_ && values_[0] == ping; }
  bool there() const { return there_; }
  std::span<const double> values() const { return values_; }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
  std::ifstream file_;
  bool there_ = false;
  std::array<double, 9> values_{};
};

Status read_objects(Table& objects, std::size_t instances, StoredPing& ping) {
  while (objects.is_of(ping.ping)) {
    const auto values = objects.values();
    if (!(values[1] >= 1) || !(values[1] <= static_cast<double>(instances))) {
      return damaged(objects.path(), fmt::format("tells of an instance {}", values[1]));
    }
    ping.objects.push_back({static_cast<std::uint32_t>(values[1]), pose_from(values.subspan(2))});
    if (const Status read = objects.advance(); !read) return read;
  }
  return {};
}

Status visit_pings(const StoredSequence& sequence, Table& poses, Table& objects,
                   const fs::path& annotations,
                   const std::function<Status(const StoredPing&)>& use) {
  std::ifstream lines(annotations, std::ios::binary);
  for (std::uint32_t p = sequence.row.first_ping; p < sequence.row.last_ping; ++p) {
    if (!poses.is_of(p)) return damaged(poses.path(), fmt::format("has no row of ping {}", p));
    StoredPing ping;
    ping.ping = p;
    ping.time_s = poses.values()[1];
    ping.sonar_in_world = pose_from(poses.values().subspan(2));
    if (const Status read = poses.advance(); !read) return read;
    if (const Status read = read_objects(objects, sequence.instances.size(), ping); !read) {
      return read;
    }
    if (!std::getline(lines, ping.annotation_line)) {
      return damaged(annotations, fmt::format("has no line of ping {}", p));
    }
    if (const Status used = use(ping); !used) return used;
  }
  if (poses.there()) return damaged(poses.path(), "has more rows than the sequence has pings");
  if (objects.there()) return damaged(objects.path(), "has rows of no ping of the sequence");
  return {};
}

}  // namespace

Status for_each_ping(const StoredDataset& dataset, const StoredSequence& sequence,
                     const std::function<Status(const StoredPing&)>& use) {
  const auto file = [&](const char* name) {
    return stored_file(dataset, sequence.row.sequence, name);
  };
  const auto poses_path = file("poses.csv");
  if (!poses_path) return poses_path.error();
  const auto objects_path = file("objects.csv");
  if (!objects_path) return objects_path.error();
  const auto annotations = file(layout::kAnnotations);
  if (!annotations) return annotations.error();
  Table poses(*poses_path), objects(*objects_path);
  if (const Status begun = poses.begin(kPosesHeader); !begun) return begun;
  if (const Status begun = objects.begin(kObjectsHeader); !begun) return begun;
  return visit_pings(sequence, poses, objects, *annotations, use);
}

}  // namespace ensonify
