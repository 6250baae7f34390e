#include "dataset/rig_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string_view>
#include <system_error>

#include "dataset/layout.h"
#include "dataset/schema.h"
#include "dataset/work_folder.h"
#include "formats/files.h"
#include "formats/json.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

Error not_of_rig(const fs::path& dir, const std::string& what) {
  return {ErrorKind::usage, dir.string() + ": " + what};
}

template <class T, class ToJson>
Json or_null(const std::optional<T>& value, ToJson to_json) {
  return value ? Json(to_json(*value)) : Json(nullptr);
}

Json number(double value) { return value; }

std::optional<Pose> pose_at(const Json& json, const char* key) {
  const Json* pose = member(json, key);
  return pose == nullptr ? std::nullopt : pose_of_json(*pose);
}

InstrumentKind kind_of(std::string_view word) {
  for (const auto kind : {InstrumentKind::camera, InstrumentKind::navigation}) {
    if (word == name_of(kind)) return kind;
  }
  return InstrumentKind::sonar;
}

std::vector<std::string> names_of(const RigFile& rig) {
  std::vector<std::string> names;
  for (const RigInstrument& instrument : rig.instruments) names.push_back(instrument.name);
  return names;
}

// Whether the folder holds anything but what a start that was cut off may leave.
bool holds_only_leftovers(const fs::path& dir) {
  std::error_code error;
  for (fs::directory_iterator entry(dir, error), end; !error && entry != end;
       entry.increment(error)) {
    if (entry->path().filename() != layout::kWorkFolder) return false;
  }
  return !error;
}

Status check_folder(const fs::path& dir, const RigFile& rig, bool overwrite) {
  const auto held = read_rig(dir);
  if (!held) return held.error();
  if (!*held) {
    if (holds_only_leftovers(dir)) return {};
    return not_of_rig(
        dir, "is not empty, and has no rig.json; expected a new folder or that of the rig");
  }
  if (to_json(**held) == to_json(rig)) return {};
  const bool same_names = names_of(**held) == names_of(rig);
  if (overwrite && same_names) return {};
  return not_of_rig(dir, same_names
                             ? "holds a rig with other mounts or clocks; name another folder, or "
                               "give --overwrite to remove the old data sets"
                             : fmt::format("holds a rig of other instruments ({}); name another "
                                           "folder, or remove this one",
                                           fmt::join(names_of(**held), ", ")));
}

}  // namespace

std::string to_json(const RigFile& rig) {
  Json json = {{"ensonify_rig", 1}, {"name", rig.name}};
  json["instruments"] = Json::array();
  for (const RigInstrument& instrument : rig.instruments) {
    Json entry = {{"name", instrument.name}, {"kind", name_of(instrument.kind)}};
    entry["mount"] = or_null(instrument.mount, [](const Pose& pose) { return json_of(pose); });
    entry["ping_rate_hz"] = or_null(instrument.ping_rate_hz, number);
    entry["time_offset_s"] = or_null(instrument.time_offset_s, number);
    json["instruments"].push_back(std::move(entry));
  }
  return json_text(json);
}

Result<std::optional<RigFile>> read_rig(const fs::path& dir) {
  if (!listed_file_size(dir, layout::kRigJson)) return std::optional<RigFile>();
  const fs::path file = dir / layout::kRigJson;
  const Result<std::string> text = read_file(file, kMaxManifestBytes);
  if (!text) return text.error();
  const std::optional<Json> json = parse_json(*text);
  if (!json) return damaged(file, "is not JSON");
  if (const std::string fault = SchemaCheck("rig").fault(*json); !fault.empty()) {
    return damaged(file, fault);
  }
  RigFile rig{*text_at(*json, "name"), {}};
  for (const Json& entry : json->at("instruments")) {
    rig.instruments.push_back({*text_at(entry, "name"), kind_of(*text_at(entry, "kind")),
                               pose_at(entry, "mount"), number_at(entry, "ping_rate_hz"),
                               number_at(entry, "time_offset_s")});
  }
  return std::optional(std::move(rig));
}

Result<std::optional<fs::path>> folder_of_kind(const fs::path& dir, InstrumentKind kind) {
  const fs::path own = fs::weakly_canonical(dir), above = own.parent_path();
  const auto rig = read_rig(above);
  if (!rig) return rig.error();
  const auto names = *rig ? names_of(**rig) : std::vector<std::string>();
  if (std::ranges::find(names, own.filename().string()) == names.end())
    return std::optional<fs::path>();
  const auto found = std::ranges::find((*rig)->instruments, kind, &RigInstrument::kind);
  if (found == (*rig)->instruments.end()) return std::optional<fs::path>();
  return std::optional(above / found->name);
}

Status open_rig_folder(const fs::path& dir, const RigFile& rig, bool overwrite) {
  std::error_code error;
  fs::create_directories(dir, error);
  if (error) return write_error(dir, error.value());
  const FolderLock lock(dir);
  if (Status fits = check_folder(dir, rig, overwrite); !fits) return fits;
  const auto written = write_file_atomically(dir, layout::kRigJson, to_json(rig));
  remove_work_folder(dir);
  return written ? Status() : written.error();
}

}  // namespace ensonify
