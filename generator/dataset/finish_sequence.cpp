#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "core/units.h"
#include "dataset/catalogue.h"
#include "dataset/finish.h"
#include "dataset/layout.h"
#include "dataset/manifest_json.h"
#include "dataset/overwrite.h"
#include "dataset/packed.h"
#include "dataset/ping_record.h"
#include "dataset/statistics.h"
#include "dataset/table_rows.h"
#include "formats/npy.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

// Common files and sums of a sequence's pings.
struct Totals {
  std::vector<std::string> each_ping;  // templates
  std::uint64_t bytes = 0;
  DisplayCounts grey_counts;
};

bool is_piece(const FileEntry& entry) {
  const auto file = layout::parse_ping_file(entry.path);
  return file && file->name_template == layout::kPiece;
}

std::vector<std::string> templates_of(const PingRecord& record) {
  std::vector<std::string> templates;
  for (const FileEntry& entry : record.files) {
    if (is_piece(entry)) continue;
    const auto file = layout::parse_ping_file(entry.path);
    templates.push_back(file ? file->name_template : entry.path);
  }
  return templates;
}

// Calls use(record) for all pings in order.
template <class Use>
Status for_each_record(const fs::path& dir, const SequenceInfo& info, const PingFrame& frame,
                       Use use) {
  for (std::uint32_t ping = info.first_ping; ping < info.last_ping; ++ping) {
    const Result<PingRecord> record =
        frame ? record_of(info, frame(ping), {}) : read_ping_record(dir, info.sequence, ping);
    if (!record) return record.error();
    if (const Status used = use(*record); !used) return used;
  }
  return {};
}

Status check_all_there(const fs::path& dir, const SequenceInfo& info) {
  std::uint32_t missing = 0;
  std::optional<std::uint32_t> first;
  for (std::uint32_t ping = info.first_ping; ping < info.last_ping; ++ping) {
    const auto record = read_ping_record(dir, info.sequence, ping);
    if (record && files_are_there(dir, info.sequence, *record)) continue;
    ++missing;
    if (!first) first = ping;
  }
  if (missing == 0) return {};
  return Error{ErrorKind::usage,
               fmt::format("{}: {} of {} pings are not done yet, ping {} among them; generate them "
                           "(all shards) before finishing",
                           (dir / layout::sequence_folder(info.sequence)).string(), missing,
                           info.last_ping - info.first_ping, *first)};
}

class SequenceTables {
 public:
  SequenceTables(const fs::path& dir, const SequenceInfo& info)
      : instances_(info.instances),
        beams_(static_cast<std::size_t>(info.sonar.beam_count)),
        poses_(dir, layout::in_sequence(info.sequence, "poses.csv")),
        tum_(dir, layout::in_sequence(info.sequence, "poses.tum")),
        objects_(dir, layout::in_sequence(info.sequence, "objects.csv")),
        boxes_(dir, layout::in_sequence(info.sequence, "boxes.csv")),
        first_return_(dir, layout::in_sequence(info.sequence, "first_return_m.npy")),
        annotations_(dir, layout::in_sequence(info.sequence, layout::kAnnotations)) {
    poses_.append(kPosesHeader);
    objects_.append(kObjectsHeader);
    boxes_.append(kBoxesHeader);
    first_return_.append(
        npy_header(kNpyFloat32, {info.last_ping - info.first_ping, std::uint64_t{beams_}}));
  }

  Status add(const PingRecord& record) {
    if (record.first_return_m.size() != beams_) {
      return Error{ErrorKind::damage,
                   fmt::format("the record of ping {} has {} first returns for "
                               "{} beams; remove .work and generate again",
                               record.ping, record.first_return_m.size(), beams_)};
    }
    const auto rows = table_rows(record, instances_);
    const auto files = this->files();
    for (std::size_t i = 0; i < rows.size(); ++i) files[i]->append(rows[i]);
    return {};
  }

  Result<std::vector<FileEntry>> commit() {
    std::vector<FileEntry> entries;
    for (StreamedFile* file : files()) {
      if (file == &first_return_ && beams_ == 0) continue;  // not of a sonar
      auto entry = file->commit();
      if (!entry) return entry.error();
      entries.push_back(std::move(*entry));
    }
    return entries;
  }

 private:
  // The files in the order of table_rows.
  std::array<StreamedFile*, 6> files() {
    return {&poses_, &tum_, &objects_, &boxes_, &first_return_, &annotations_};
  }

  const std::vector<Instance>& instances_;
  std::size_t beams_;
  StreamedFile poses_, tum_, objects_, boxes_, first_return_, annotations_;
};

Result<std::vector<FileEntry>> write_axes(const fs::path& dir, const SequenceInfo& info) {
  if (!is_sonar(info)) return std::vector<FileEntry>();
  std::vector<double> ranges;
  for (int n = 0; n < info.record.samples; ++n) {
    ranges.push_back(sample_range_m(info.sonar, info.water, n));
  }
  std::vector<std::pair<const char*, std::vector<double>>> arrays = {
      {"azimuth_rad.npy", beam_azimuths_rad(info.sonar)}, {"range_m.npy", std::move(ranges)}};
  if (info.output.front) {
    arrays.emplace_back(layout::kFrontElevations, ray_elevations_rad(info.sonar));
    arrays.emplace_back(layout::kFrontAzimuths, ray_azimuths_rad(info.sonar));
  }
  std::vector<FileEntry> entries;
  for (const auto& [name, values] : arrays) {
    auto entry = write_file_atomically(dir, layout::in_sequence(info.sequence, name),
                                       encode_npy(values, {values.size()}));
    if (!entry) return entry.error();
    entries.push_back(std::move(*entry));
  }
  return entries;
}

// `lines`: those of the pings' files in sequence.json.
Result<Totals> write_tables(const fs::path& dir, const SequenceInfo& info, const PingFrame& frame,
                            std::vector<FileEntry>& entries, StreamedFile& lines) {
  Totals totals;
  SequenceTables tables(dir, info);
  const Status read = for_each_record(dir, info, frame, [&](const PingRecord& record) -> Status {
    const auto templates = templates_of(record);
    if (record.ping == info.first_ping) totals.each_ping = templates;
    if (templates != totals.each_ping) {
      return Error{ErrorKind::bug,
                   fmt::format("sequence {}: the files of ping {} differ from those of ping {}",
                               info.sequence, record.ping, info.first_ping)};
    }
    totals.grey_counts += record.grey_counts;
    for (const FileEntry& entry : record.files) {
      if (is_piece(entry)) continue;
      totals.bytes += entry.bytes;
      lines.append(file_line(entry, false));
    }
    return tables.add(record);
  });
  if (!read) return read.error();
  const auto committed = tables.commit();
  if (!committed) return committed.error();
  entries.insert(entries.end(), committed->begin(), committed->end());
  for (const FileEntry& entry : entries) totals.bytes += entry.bytes;
  return totals;
}

Status write_sequence_json(const fs::path& dir, const SequenceInfo& info, const Totals& totals,
                           std::vector<FileEntry> entries, StreamedFile& lines_of_pings) {
  StreamedFile file(dir, layout::in_sequence(info.sequence, layout::kSequenceJson));
  SequenceInfo counted = info;
  counted.png_counts = totals.grey_counts;
  file.append(files_opening(sequence_head(counted, totals.each_ping, totals.bytes)));
  bool first = true;
  for (FileEntry& entry : entries) {
    entry.path.erase(0, layout::sequence_folder(info.sequence).size() + 1);
    file.append(file_line(entry, std::exchange(first, false)));
  }
  file.append_all_of(lines_of_pings);
  file.append(files_closing());
  const auto committed = file.commit();
  return committed ? Status() : Status(committed.error());
}

Result<FileEntry> write_cartesian_map(const fs::path& dir, const SequenceInfo& info,
                                      std::span<const std::int32_t> map) {
  const GridSizes sizes = sizes_of(info);
  const std::string name = layout::in_sequence(info.sequence, layout::kCartesianMap);
  return write_file_atomically(dir, name,
                               encode_npy(map, {sizes.cartesian_height, sizes.cartesian_width}));
}

// The meshes of the world.
Status write_meshes(const fs::path& dir, const SequenceInfo& info, const SequenceParts& parts,
                    std::vector<FileEntry>& entries) {
  if (!info.output.world) return {};
  const auto stream = [&](const char* name, const WriteFile& write) -> Status {
    StreamedFile file(dir, layout::in_sequence(info.sequence, name));
    if (write) write([&](std::string_view bytes) { file.append(bytes); });
    auto entry = file.commit();
    if (!entry) return entry.error();
    entries.push_back(std::move(*entry));
    return {};
  };
  const Status written = stream(layout::kWorldPly, parts.world_ply);
  return written ? stream(layout::kWorldGlb, parts.world_glb) : written;
}

Status write_sensors(const fs::path& dir, const SequenceInfo& info, const WriteTables& write,
                     std::vector<FileEntry>& entries) {
  if (!info.navigation) return {};
  std::array<std::optional<StreamedFile>, std::size(kNavigationTables)> files;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (!has_table(info.navigation->sensors, static_cast<NavigationTable>(i))) continue;
    files[i].emplace(dir, layout::in_sequence(info.sequence, kNavigationTables[i].name));
  }
  if (write) {
    write([&](NavigationTable table, std::string_view text) {
      files[static_cast<std::size_t>(table)]->append(text);
    });
  }
  for (auto& file : files) {
    if (!file) continue;
    auto entry = file->commit();
    if (!entry) return entry.error();
    entries.push_back(std::move(*entry));
  }
  return {};
}

// By name, encoded.
std::vector<std::pair<const char*, std::string>> arrays_of_parts(const SequenceInfo& info,
                                                                 const SequenceParts& parts) {
  std::vector<std::pair<const char*, std::string>> arrays;
  const GridSizes sizes = sizes_of(info);
  if (info.output.covisibility) {
    arrays.emplace_back(layout::kCovisibility,
                        encode_npy(parts.covisibility, {sizes.pings, sizes.pings}));
  }
  if (info.output.elevation && !info.sonar.array) {
    arrays.emplace_back(layout::kBeamPower,
                        encode_npy(parts.beam_power, {sizes.beams, sizes.beams}));
    arrays.emplace_back(layout::kPulsePower, encode_npy(parts.pulse_power, {sizes.frequencies}));
  }
  if (info.height_map) {
    arrays.emplace_back(layout::kHeightMap,
                        encode_npy(parts.height_map, {sizes.height_rows, sizes.height_columns}));
  }
  return arrays;
}

Status write_sequence(const fs::path& dir, const SequenceInfo& info, const SequenceParts& parts) {
  if (!parts.frame) {
    if (const Status there = check_all_there(dir, info); !there) return there;
  }
  // A sequence without pings has no plan yet.
  if (const Status planned = plan_sequence(dir, info, {}); !planned) return planned;
  auto entries = write_axes(dir, info);
  if (!entries) return entries.error();
  if (info.output.packed) {
    const auto arrays = write_arrays(dir, info);
    if (!arrays) return arrays.error();
    entries->insert(entries->end(), arrays->begin(), arrays->end());
  }
  if (info.sdf) {
    auto entry =
        write_file_atomically(dir, layout::in_sequence(info.sequence, layout::kSdf), parts.sdf_vdb);
    if (!entry) return entry.error();
    entries->push_back(std::move(*entry));
  }
  if (info.output.cartesian) {
    auto entry = write_cartesian_map(dir, info, parts.cartesian_map);
    if (!entry) return entry.error();
    entries->push_back(std::move(*entry));
  }
  for (const auto& [name, bytes] : arrays_of_parts(info, parts)) {
    auto entry = write_file_atomically(dir, layout::in_sequence(info.sequence, name), bytes);
    if (!entry) return entry.error();
    entries->push_back(std::move(*entry));
  }
  if (const Status meshes = write_meshes(dir, info, parts, *entries); !meshes) return meshes;
  if (const Status sensors = write_sensors(dir, info, parts.navigation, *entries); !sensors) {
    return sensors;
  }
  if (info.output.statistics) {
    const auto arrays = parts.moments != nullptr
                            ? write_statistics(dir, info, *parts.moments, *parts.pool)
                            : write_statistics(dir, info, {}, {});
    if (!arrays) return arrays.error();
    entries->insert(entries->end(), arrays->begin(), arrays->end());
  }
  StreamedFile lines(dir, layout::in_sequence(info.sequence, "sequence.json.files"), false);
  const auto totals = write_tables(dir, info, parts.frame, *entries, lines);
  if (!totals) return totals.error();
  return write_sequence_json(dir, info, *totals, std::move(*entries), lines);
}

}  // namespace

bool sequence_is_finished(const fs::path& dir, std::uint32_t sequence) {
  try {
    return sequence_is_whole(dir, sequence);
  } catch (const std::exception&) {
    return false;
  }
}

std::optional<std::uint64_t> finished_pings(const fs::path& dir, std::uint32_t sequence) {
  if (!sequence_is_finished(dir, sequence)) return std::nullopt;
  const auto manifest = read_sequence_manifest(dir, sequence);
  if (!manifest) return std::nullopt;
  return std::uint64_t{manifest->info.last_ping} - manifest->info.first_ping;
}

Status finish_sequence(const fs::path& dir, const SequenceInfo& info, const SequenceParts& parts) {
  return without_exceptions(fmt::format("finishing sequence {}", info.sequence), [&]() -> Status {
    Status written;
    if (!sequence_is_finished(dir, info.sequence)) written = write_sequence(dir, info, parts);
    // Another process with the same work may have finished it and removed the records meanwhile.
    if (!written && !sequence_is_finished(dir, info.sequence)) return written;
    remove_pieces(dir, info.sequence);
    remove_moments(dir, info.sequence);
    return {};
  });
}

}  // namespace ensonify
