#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <span>

#include "dataset/layout.h"
#include "dataset/manifest_members.h"
#include "dataset/read_dataset.h"
#include "dataset/table_rows.h"
#include "formats/bytes.h"
#include "formats/csv.h"
#include "formats/files.h"
#include "formats/json.h"
#include "formats/npy.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

Pose pose_from(std::span<const double> v) { return {{v[0], v[1], v[2]}, {v[3], v[4], v[5], v[6]}}; }

// A table with nine numbers per row, read one row ahead.
class Table {
 public:
  explicit Table(fs::path path) : path_(std::move(path)), file_(path_, std::ios::binary) {}

  Status begin(std::string_view header) {
    std::string line;
    if (!std::getline(file_, line) || line + "\n" != header) {
      return damaged(path_, "does not begin with the expected header");
    }
    return advance();
  }
  Status advance() {
    std::string line;
    there_ = static_cast<bool>(std::getline(file_, line));
    if (there_ && !read_numbers(line, values_))
      return damaged(path_, "has an invalid row: " + line);
    return {};
  }
  // Whether the current row exists and is of this ping.
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
      return damaged(objects.path(), fmt::format("refers to an unknown instance {}", values[1]));
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
    if (!poses.is_of(p)) return damaged(poses.path(), fmt::format("has no row for ping {}", p));
    StoredPing ping;
    ping.ping = p;
    ping.time_s = poses.values()[1];
    ping.sonar_in_world = pose_from(poses.values().subspan(2));
    if (const Status read = poses.advance(); !read) return read;
    if (const Status read = read_objects(objects, sequence.instances.size(), ping); !read) {
      return read;
    }
    if (!std::getline(lines, ping.annotation_line)) {
      return damaged(annotations, fmt::format("has no line for ping {}", p));
    }
    if (const Status used = use(ping); !used) return used;
  }
  if (poses.there()) return damaged(poses.path(), "has more rows than the sequence has pings");
  if (objects.there())
    return damaged(objects.path(), "has rows for pings that the sequence does not have");
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

namespace {

constexpr std::size_t kBoxNumbers = 19;  // in a row of boxes.csv

std::vector<std::pair<std::string, double>> numbers_of(const SequenceInfo& info) {
  const Sonar& sonar = info.sonar;
  if (info.recording) {
    return {{"frequency_hz", sonar.frequency_hz},
            {"range_min_m", sonar.range_min_m},
            {"range_max_m", sonar.range_max_m},
            {"beam_spacing_rad", sonar.beam_spacing_rad},
            {"sample_interval_s", info.record.sample_interval_s},
            {"sound_speed_m_s", info.water.sound_speed_m_s}};
  }
  if (!is_sonar(info)) return {{"sound_speed_m_s", info.water.sound_speed_m_s}};
  std::vector<std::pair<std::string, double>> numbers = {
      {"frequency_hz", sonar.frequency_hz},
      {"bandwidth_hz", sonar.bandwidth_hz},
      {"source_level_db", sonar.source_level_db},
      {"range_min_m", sonar.range_min_m},
      {"range_max_m", sonar.range_max_m},
      {"beam_spacing_rad", sonar.beam_spacing_rad},
      {"beam_width_rad", sonar.beam_width_rad},
      {"elevation_width_rad", sonar.elevation_width_rad},
      {"sample_interval_s", info.record.sample_interval_s},
      {"sound_speed_m_s", info.water.sound_speed_m_s},
      {"absorption_db_m", info.water.absorption_db_m}};
  if (const auto& level_db = info.noise_spectrum_level_db) {
    numbers.emplace_back("noise_spectrum_level_db", *level_db);
  }
  if (info.noise_power_pa2 > 0) numbers.emplace_back("noise_power_pa2", info.noise_power_pa2);
  return numbers;
}

std::vector<InstanceFacts> instance_facts(const SequenceInfo& info) {
  constexpr const char* kKinds[] = {"surface", "point_target", "volume"};
  const auto is_coherent = [](const auto& surface) {
    return surface.scattering.coherent != CoherentModel::none;
  };
  std::vector<InstanceFacts> facts;
  for (const Instance& instance : info.instances) {
    InstanceFacts fact{kKinds[static_cast<int>(instance.kind)], {}, false};
    if (instance.box) fact.size_m = instance.box->size_m;
    fact.rough = instance.kind == InstanceKind::surface && !is_coherent(instance) &&
                 std::none_of(instance.parts.begin(), instance.parts.end(), is_coherent);
    facts.push_back(std::move(fact));
  }
  return facts;
}

// The number before the first comma; none if the row has no such number.
std::optional<std::uint32_t> ping_of_row(const std::string& line) {
  std::uint32_t ping = 0;
  const auto [after, error] = std::from_chars(line.data(), line.data() + line.size(), ping);
  if (error != std::errc() || after == line.data() + line.size()) return std::nullopt;
  return ping;
}

}  // namespace

Result<DatasetFacts> read_facts(const StoredDataset& dataset) {
  const WorkIdentity& identity = dataset.manifest.identity;
  if (!listed_file_size(dataset.dir, "scenario.yaml")) {
    return damaged(dataset.dir / "scenario.yaml", "is missing, or is not a file of this folder");
  }
  auto scenario = read_file(dataset.dir / "scenario.yaml");
  if (!scenario) return scenario.error();
  return DatasetFacts{
      fmt::format("ensonify {} ({})", identity.program_version, identity.program_commit),
      identity.seed, dataset.manifest.bytes, identity.scenario_sha256, std::move(*scenario)};
}

Result<SequenceFacts> read_sequence_facts(const StoredDataset& dataset,
                                          const StoredSequence& sequence) {
  const SequenceInfo& info = sequence.manifest.info;
  SequenceFacts facts;
  facts.noise_power_pa2 = info.noise_power_pa2;
  facts.fresh_speckle = info.speckle == SpeckleMode::per_ping;
  // Limits of levels without gain; displays with gain have none of these.
  if (info.output.png && is_plain(info.png)) {
    facts.grey_db = {info.png.limits_db[0], info.png.limits_db[1]};
  }
  facts.numbers = numbers_of(info);
  for (const DrawnValue& draw : info.draws) facts.draws.emplace_back(draw.path, draw.value);
  facts.instances = instance_facts(info);
  facts.realisations = sequence.manifest.realisations;
  if (!(sequence.range_step_m > 0)) {
    return damaged(dataset.dir / layout::in_sequence(info.sequence, layout::kSequenceJson),
                   "has no range step");
  }
  const auto azimuths = stored_file(dataset, sequence.row.sequence, "azimuth_rad.npy");
  if (!azimuths) return azimuths.error();
  const auto array = read_npy(*azimuths, kNpyFloat64, {sequence.beams});
  if (!array) return array.error();
  facts.azimuth_rad = values_in<double>(array->data());
  return facts;
}

Result<std::vector<StoredBox>> boxes_of(const StoredDataset& dataset,
                                        const StoredSequence& sequence,
                                        std::span<const std::uint32_t> pings) {
  const auto path = stored_file(dataset, sequence.row.sequence, "boxes.csv");
  if (!path) return path.error();
  std::ifstream file(*path, std::ios::binary);
  std::string line;
  if (!std::getline(file, line) || line + "\n" != kBoxesHeader) {
    return damaged(*path, "does not begin with the expected header");
  }
  std::vector<StoredBox> boxes;
  std::array<double, kBoxNumbers> v{};
  while (!pings.empty() && std::getline(file, line)) {
    const auto ping = ping_of_row(line);
    if (!ping) return damaged(*path, "has an invalid row: " + line);
    if (*ping > pings.back()) break;  // rows follow the pings
    if (!std::binary_search(pings.begin(), pings.end(), *ping)) continue;
    if (!read_numbers(line, v) || !(v[1] >= 1) ||
        !(v[1] <= static_cast<double>(sequence.instances.size()))) {
      return damaged(*path, "has an invalid row: " + line);
    }
    boxes.push_back({*ping,
                     static_cast<std::uint16_t>(v[1]),
                     {v[2], v[3], v[4]},
                     {{v[5], v[6], v[7]}, {v[8], v[9], v[10], v[11]}}});
  }
  return boxes;
}

Result<std::vector<double>> read_statistics(const StoredDataset& dataset,
                                            const StoredSequence& sequence,
                                            const std::string& name) {
  const auto path = stored_file(dataset, sequence.row.sequence, "statistics/" + name + ".npy");
  if (!path) return path.error();
  const auto array = read_npy(*path, kNpyFloat64, {sequence.samples, sequence.beams});
  if (!array) return array.error();
  return values_in<double>(array->data());
}

}  // namespace ensonify
