// SEQUENCE/PING.ply: the scatterers of a ping as a point cloud in the world, binary little-endian.
#include <fmt/format.h>

#include <cstring>

#include "dataset/echo_arrays.h"
#include "dataset/layout.h"
#include "export/job.h"
#include "export/ping_values.h"
#include "formats/files.h"
#include "formats/npy.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

constexpr char kPlyHeader[] =
    "ply\n"
    "format binary_little_endian 1.0\n"
    "comment ensonify, sequence {} ping {}; meters, world: x east, y north, z up\n"
    "comment intensity: |amplitude gain|^2, the squared pressure of the echo for a source of 1 Pa "
    "m\n"
    "element vertex {}\n"
    "property double x\n"
    "property double y\n"
    "property double z\n"
    "property float intensity\n"
    "property uint instance\n"
    "property uchar class\n"
    "end_header\n";

const CatalogueRow& scatterers_row() { return *find_file(FileScope::ping, layout::kScatterers); }

Status write_cloud(const ExportJob& job, const fs::path& target, const StoredSequence& sequence,
                   const StoredPing& ping) {
  const auto path = path_of(job, sequence, ping, scatterers_row());
  if (!path) return path.error();
  const auto array = read_npy(*path, kNpyScatterer, {0});
  if (!array) return array.error();
  StreamedFile file(target / fmt::format("{:06}/{:06}.ply", sequence.row.sequence, ping.ping));
  file.append(fmt::format(kPlyHeader, sequence.row.sequence, ping.ping, array->shape[0]));
  std::string_view rest = array->data();
  for (; !rest.empty(); rest.remove_prefix(kScattererBytes)) {
    const auto [place, squared, instance] = scatterer_at(rest);
    if (instance > sequence.instances.size()) {
      return damaged(*path, fmt::format("refers to an unknown instance {}", instance));
    }
    char vertex[33];
    const auto intensity = static_cast<float>(squared);
    std::memcpy(vertex, &place, 24);
    std::memcpy(vertex + 24, &intensity, 4);
    std::memcpy(vertex + 28, &instance, 4);
    const std::uint8_t class_id = instance == 0 ? 0 : sequence.instances[instance - 1].class_id;
    std::memcpy(vertex + 32, &class_id, 1);
    file.append({vertex, sizeof vertex});
  }
  return file.close();
}

}  // namespace

Status write_ply(const ExportJob& job, const fs::path& target) {
  return for_each_sequence(job, [&](const StoredSequence& sequence) -> Status {
    if (const Status there = need(job, sequence, scatterers_row()); !there) return there;
    return for_each_exported_ping(job, sequence, [&](const StoredPing& ping) {
      return write_cloud(job, target, sequence, ping);
    });
  });
}

}  // namespace ensonify
