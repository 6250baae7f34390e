#include "dataset/read_facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <fstream>
#include <tuple>

#include "dataset/json.h"
#include "dataset/layout.h"
#include "dataset/npy_file.h"
#include "dataset/tables.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kBoxNumbers = 19;  // in a row of boxes.csv

// An object that is not there is an empty one: what lacks it lacks its members.
const Json& part(const Json& json, std::string_view key) {
  static const Json kNothing = Json::object();
  const Json* found = member(json, key);
  return found != nullptr && found->is_object() ? *found : kNothing;
}

double number_or_0(const Json& json, std::string_view key) {
  return number_at(json, key).value_or(0);
}

std::vector<std::pair<std::string, double>> numbers_of(const Json& head) {
  const Json& sonar = part(head, "sonar");
  const Json& beams = part(sonar, "beams");
  const std::tuple<const char*, const Json&, const char*> wanted[] = {
      {"frequency_hz", sonar, "frequency_hz"},
      {"bandwidth_hz", sonar, "bandwidth_hz"},
      {"source_level_db", sonar, "source_level_db"},
      {"range_min_m", sonar, "range_min_m"},
      {"range_max_m", sonar, "range_max_m"},
      {"beam_spacing_rad", beams, "spacing_rad"},
      {"beam_width_rad", beams, "width_rad"},
      {"elevation_width_rad", part(sonar, "elevation"), "width_rad"},
      {"sample_interval_s", part(head, "record"), "sample_interval_s"},
      {"sound_speed_m_s", part(head, "water"), "sound_speed_m_s"},
      {"absorption_db_m", part(head, "water"), "absorption_db_m"},
      {"noise_spectrum_level_db", part(head, "noise"), "spectrum_level_db"},
      {"noise_power_pa2", part(head, "noise"), "power_pa2"}};
  std::vector<std::pair<std::string, double>> numbers;
  for (const auto& [name, json, key] : wanted) {
    if (const auto value = number_at(json, key)) numbers.emplace_back(name, *value);
  }
  return numbers;
}

std::optional<Vec3> size_of(const Json& instance) {
  const Json* size = member(part(instance, "box"), "size_m");
  if (size == nullptr || !size->is_array() || size->size() != 3) return std::nullopt;
  for (const Json& side : *size) {
    if (!side.is_number()) return std::nullopt;
  }
  return Vec3{(*size)[0], (*size)[1], (*size)[2]};
}

bool throws_back_coherently(const Json& surface) {
  const Json* coherent = member(surface, "coherent");
  return coherent == nullptr || !coherent->is_null();
}

std::vector<InstanceFacts> instance_facts(const Json& head) {
  std::vector<InstanceFacts> facts;
  const Json* list = member(head, "instances");
  if (list == nullptr || !list->is_array()) return facts;
  for (const Json& item : *list) {
    InstanceFacts instance{text_at(item, "kind").value_or(""), size_of(item), false};
    const Json* parts = member(item, "parts");
    instance.rough =
        instance.kind == "surface" && !throws_back_coherently(item) &&
        (parts == nullptr || std::none_of(parts->begin(), parts->end(), throws_back_coherently));
    facts.push_back(std::move(instance));
  }
  return facts;
}

std::vector<std::pair<std::string, std::string>> draws_of(const Json& head) {
  std::vector<std::pair<std::string, std::string>> draws;
  for (const auto& draw : part(head, "draws").items()) {
    const Json& value = draw.value();
    draws.emplace_back(draw.key(), value.is_string() ? value.get<std::string>() : value.dump());
  }
  return draws;
}

// Limits of plain levels: with a gain they are none of these.
std::optional<std::pair<double, double>> grey_of(const Json& head) {
  const Json& png = part(head, "png");
  const Json* db = member(png, "db");
  if (text_at(png, "scale") != "db" || member(png, "formula") != nullptr) return std::nullopt;
  if (db == nullptr || !db->is_array() || db->size() != 2 || !(*db)[0].is_number() ||
      !(*db)[1].is_number()) {
    return std::nullopt;
  }
  return std::pair<double, double>{(*db)[0], (*db)[1]};
}

std::vector<double> doubles_in(std::string_view bytes) {
  std::vector<double> values(bytes.size() / sizeof(double));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(double));
  return values;
}

// The number before the first comma; none where there is none.
std::optional<std::uint32_t> ping_of_row(const std::string& line) {
  std::uint32_t ping = 0;
  const auto [after, error] = std::from_chars(line.data(), line.data() + line.size(), ping);
  if (error != std::errc() || after == line.data() + line.size()) return std::nullopt;
  return ping;
}

}  // namespace

Result<DatasetFacts> read_facts(const StoredDataset& dataset) {
  const fs::path path = dataset.dir / layout::kDatasetJson;
  const auto text = read_file(path);
  if (!text) return text.error();
  const auto json = parse_manifest(*text, [](const FileEntry&) {});
  if (!json) return damaged(path, "is not JSON");
  const Json& program = part(*json, "program");
  const auto version = text_at(program, "version");
  const auto sha256 = text_at(*json, "scenario_sha256");
  const auto seed = count_at(*json, "seed"), bytes = count_at(*json, "bytes");
  if (!version || !sha256 || !seed || !bytes) {
    return damaged(path, "lacks its program, scenario, seed or size");
  }
  if (!listed_file_size(dataset.dir, "scenario.yaml")) {
    return damaged(dataset.dir / "scenario.yaml", "is missing, or is no file of this folder");
  }
  auto scenario = read_file(dataset.dir / "scenario.yaml");
  if (!scenario) return scenario.error();
  return DatasetFacts{
      fmt::format("ensonify {} ({})", *version, text_at(program, "commit").value_or("unknown")),
      *seed, *bytes, *sha256, std::move(*scenario)};
}

Result<SequenceFacts> read_sequence_facts(const StoredDataset& dataset,
                                          const StoredSequence& sequence) {
  const auto path = stored_file(dataset, sequence.row.sequence, layout::kSequenceJson);
  if (!path) return path.error();
  const auto text = read_file(*path);
  if (!text) return text.error();
  const auto head = parse_manifest(*text, [](const FileEntry&) {});
  if (!head) return damaged(*path, "is not JSON");
  SequenceFacts facts;
  facts.noise_power_pa2 = number_or_0(part(*head, "noise"), "power_pa2");
  facts.fresh_speckle = text_at(part(*head, "scattering"), "speckle") == "per_ping";
  facts.grey_db = grey_of(*head);
  facts.numbers = numbers_of(*head);
  facts.draws = draws_of(*head);
  facts.instances = instance_facts(*head);
  facts.realisations = count_at(part(*head, "statistics"), "realisations").value_or(0);
  if (!(sequence.range_step_m > 0) || facts.instances.size() != sequence.instances.size()) {
    return damaged(*path, "lacks its range step or instances");
  }
  const auto azimuths = stored_file(dataset, sequence.row.sequence, "azimuth_rad.npy");
  if (!azimuths) return azimuths.error();
  const auto array = read_npy(*azimuths, kNpyFloat64, {sequence.beams});
  if (!array) return array.error();
  facts.azimuth_rad = doubles_in(array->data());
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
    return damaged(*path, "does not begin with its header");
  }
  std::vector<StoredBox> boxes;
  std::array<double, kBoxNumbers> v{};
  while (!pings.empty() && std::getline(file, line)) {
    const auto ping = ping_of_row(line);
    if (!ping) return damaged(*path, "has a wrong row: " + line);
    if (*ping > pings.back()) break;  // rows follow the pings
    if (!std::binary_search(pings.begin(), pings.end(), *ping)) continue;
    if (!read_numbers(line, v) || !(v[1] >= 1) ||
        !(v[1] <= static_cast<double>(sequence.instances.size()))) {
      return damaged(*path, "has a wrong row: " + line);
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
  return doubles_in(array->data());
}

}  // namespace ensonify
