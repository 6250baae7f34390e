// Tar shards SPLIT-000000.tar with KEY.png, KEY.instance.png, KEY.semantic.png, KEY.npy and
// KEY.json for every ping, with KEYs such as 000000_000003. A ping is never split between shards.
#include <fmt/format.h>

#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "dataset/layout.h"
#include "dataset/mask.h"
#include "export/file_module.h"
#include "export/job.h"
#include "formats/files.h"
#include "formats/npy.h"
#include "formats/output_place.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t kDefaultShardMb = 500;
constexpr std::uint64_t kBlock = 512;  // of a tar file

struct Member {
  std::string suffix;
  std::string bytes;
};

// One shard at a time; starts a new one if the next ping would make it too long.
class Shards {
 public:
  Shards(const FileModule& module, fs::path folder, std::string split, std::uint64_t most_bytes)
      : module_(module),
        folder_(std::move(folder)),
        split_(std::move(split)),
        most_bytes_(most_bytes) {}

  Status add(const std::string& key, const std::vector<Member>& members) {
    std::uint64_t bytes = 0;
    for (const Member& m : members) {
      bytes += kBlock + (m.bytes.size() + kBlock - 1) / kBlock * kBlock;
    }
    if (tar_ && bytes_ > 0 && bytes_ + bytes > most_bytes_) {
      if (const Status closed = close(); !closed) return closed;
    }
    if (!tar_) {
      path_ = folder_ / fmt::format("{}-{:06}.tar", split_, shard_++);
      bytes_ = 0;
      tar_.reset(module_.tar(path_));
    }
    bytes_ += bytes;
    for (const Member& m : members) {
      if (!tar_->add(key + "." + m.suffix, m.bytes)) return failed();
    }
    return {};
  }
  Status close() {
    if (tar_ && !tar_->close()) return failed();
    tar_.reset();
    return {};
  }

 private:
  Error failed() const {
    if (tar_->error_number() > 0) return write_error(path_, tar_->error_number());
    return {ErrorKind::io, fmt::format("cannot write {}: {}", path_.string(), tar_->error_text())};
  }

  const FileModule& module_;
  fs::path folder_, path_;
  std::string split_;
  std::uint64_t most_bytes_, bytes_ = 0;
  int shard_ = 0;
  std::unique_ptr<TarFile> tar_;
};

Json pose_json(const Pose& pose) {
  const Vec3& p = pose.position_m;
  const Quat& q = pose.rotation;
  return {{"position_m", {p.x, p.y, p.z}}, {"quaternion_wxyz", {q.w, q.x, q.y, q.z}}};
}

Json objects_json(const ExportJob& job, const StoredSequence& sequence,
                  const StoredPicture& picture) {
  Json objects = Json::array();
  for (const StoredAnnotation& annotation : picture.annotations) {
    const Mask mask = mask_of(annotation.runs, static_cast<std::int64_t>(picture.height));
    const StoredInstance& instance = sequence.instances[annotation.instance - 1];
    objects.push_back({{"instance", instance.id},
                       {"name", instance.name},
                       {"class_id", instance.class_id},
                       {"class", job.dataset.classes[instance.class_id - 1U]},
                       {"bbox", {mask.left, mask.top, mask.width, mask.height}},
                       {"area", mask.area}});
  }
  return objects;
}

Result<std::string> json_of_ping(const ExportJob& job, const StoredSequence& sequence,
                                 const StoredPing& ping) {
  const auto picture = picture_of_view(job, sequence, ping, job.view());
  if (!picture) return picture.error();
  Json json = {{"sequence", sequence.row.sequence},
               {"ping", ping.ping},
               {"time_s", ping.time_s},
               {"split", sequence.row.split},
               {"view", picture->view},
               {"width", picture->width},
               {"height", picture->height},
               {"sonar_in_world", pose_json(ping.sonar_in_world)},
               {"objects", objects_json(job, sequence, *picture)}};
  json.update(run_members(job));
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Result<std::vector<Member>> members_of(const ExportJob& job, const StoredSequence& sequence,
                                       const StoredPing& ping) {
  std::vector<Member> members;
  std::vector<std::pair<std::string, const CatalogueRow*>> files = {
      {job.render && job.render->jpeg_quality > 0 ? "jpg" : "png", &grey_of(job)}};
  for (const ImagePlane& plane : kImagePlanes) {
    const CatalogueRow& row = mask_of_view(job, plane.name);
    if (row.codec == FileCodec::png) files.emplace_back(std::string(plane.name) + ".png", &row);
  }
  files.emplace_back("npy", find_file(FileScope::ping, layout::kTimeseries));
  for (const auto& [suffix, row] : files) {
    if (!is_rendered(job, *row) && !sequence.has(*row)) continue;
    const auto path = path_of(job, sequence, ping, *row);
    if (!path) return path.error();
    if (row->codec == FileCodec::npy) {
      auto array = read_npy(*path, row->type, grid_shape(*row, sequence.sizes()));
      if (!array) return array.error();
      members.push_back({suffix, std::move(array->file)});
      continue;
    }
    auto bytes = read_file(*path);
    if (!bytes) return bytes.error();
    members.push_back({suffix, std::move(*bytes)});
  }
  auto json = json_of_ping(job, sequence, ping);
  if (!json) return json.error();
  members.push_back({"json", std::move(*json)});
  return members;
}

}  // namespace

Status write_webdataset(const ExportJob& job, const fs::path& target) {
  const std::uint64_t most = job.options.shard_size_mb.value_or(kDefaultShardMb) * 1'000'000;
  const Result<const FileModule*> module = file_module();
  if (!module) return module.error();
  std::map<std::string, Shards> shards;
  for (const char* split : {"train", "val", "test"}) {
    shards.emplace(split, Shards(**module, target, split, most));
  }
  const Status written = for_each_sequence(job, [&](const StoredSequence& sequence) -> Status {
    if (const Status there = need(job, sequence, grey_of(job)); !there) return there;
    return for_each_exported_ping(job, sequence, [&](const StoredPing& ping) -> Status {
      const auto members = members_of(job, sequence, ping);
      if (!members) return members.error();
      return shards.at(sequence.row.split).add(item_name(job, sequence, ping), *members);
    });
  });
  if (!written) return written;
  for (auto& [split, split_shards] : shards) {
    if (const Status closed = split_shards.close(); !closed) return closed;
  }
  return {};
}

}  // namespace ensonify
