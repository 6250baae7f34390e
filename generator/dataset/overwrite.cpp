#include "dataset/overwrite.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <map>
#include <optional>
#include <set>
#include <system_error>

#include "dataset/catalogue.h"
#include "dataset/layout.h"
#include "dataset/render_manifest.h"
#include "dataset/work_folder.h"
#include "formats/files.h"
#include "formats/json.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

// The most names in a message.
constexpr std::size_t kNamesInMessage = 3;

// The files that an unfinished sequence may have written.
struct Plan {
  std::uint64_t first_ping = 0, last_ping = 0;
  std::set<std::string> templates;

  bool holds(std::string_view name) const {
    const auto file = layout::parse_ping_file(name);
    return file && file->ping >= first_ping && file->ping < last_ping &&
           templates.contains(file->name_template);
  }
};

class Listing {
 public:
  void add(const std::string& path) {
    if (is_safe_relative_path(path)) {
      paths_.insert(path);
    } else if (!unsafe_) {
      unsafe_ = path;
    }
  }
  Plan& add_plan(const std::string& folder) { return plans_[folder]; }

  bool holds(const std::string& path) const {
    if (paths_.contains(path)) return true;
    return std::any_of(plans_.begin(), plans_.end(), [&](const auto& plan) {
      return path.starts_with(plan.first) &&
             plan.second.holds(std::string_view(path).substr(plan.first.size()));
    });
  }
  const std::optional<std::string>& unsafe() const { return unsafe_; }

 private:
  std::set<std::string> paths_;
  std::map<std::string, Plan> plans_;  // by folder
  std::optional<std::string> unsafe_;
};

// The manifest's text if it is a regular file, not a link.
std::optional<std::string> manifest_text(const fs::path& dir, const std::string& relative) {
  if (!listed_file_size(dir, relative)) return std::nullopt;
  auto text = read_file(dir / relative);
  return text ? std::optional(std::move(*text)) : std::nullopt;
}

void list_finished_sequence(const fs::path& dir, const std::string& folder, Listing& listing) {
  const std::string manifest = folder + layout::kSequenceJson;
  const auto text = manifest_text(dir, manifest);
  if (!text) return;
  std::vector<std::string> names;
  const auto json =
      parse_manifest(*text, [&](const FileEntry& entry) { names.push_back(entry.path); });
  if (!json || !count_at(*json, "ensonify_sequence")) return;
  listing.add(manifest);
  for (const std::string& name : names) {
    listing.add(is_safe_relative_path(name) ? folder + name : name);
  }
}

void list_planned_sequence(const fs::path& dir, std::uint32_t sequence, Listing& listing) {
  const auto text = manifest_text(dir, layout::plan_path(sequence));
  const auto plan = text ? parse_json(*text) : std::nullopt;
  if (!plan) return;
  const auto first = count_at(*plan, "first_ping");
  const auto last = count_at(*plan, "last_ping");
  const Json* each = member(*plan, "each_ping");
  if (!first || !last || each == nullptr || !each->is_array()) return;
  for (const CatalogueRow& row : catalogue()) {
    if (row.scope == FileScope::sequence) listing.add(layout::in_sequence(sequence, row.file));
  }
  if (const Json* arrays = member(*plan, "arrays"); arrays != nullptr && arrays->is_array()) {
    for (const Json& name : *arrays) {
      if (name.is_string()) listing.add(layout::in_sequence(sequence, name.get<std::string>()));
    }
  }
  Plan& planned = listing.add_plan(layout::sequence_folder(sequence) + "/");
  planned.first_ping = *first;
  planned.last_ping = *last;
  for (const Json& name : *each) {
    if (name.is_string()) planned.templates.insert(name.get<std::string>());
  }
}

void list_sequences(const fs::path& dir, Listing& listing) {
  std::error_code error;
  if (!fs::is_directory(fs::symlink_status(dir / "sequences", error))) return;
  for (fs::directory_iterator entry(dir / "sequences", error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name.size() < 6 || name.size() > 10 ||
        name.find_first_not_of("0123456789") != std::string::npos) {
      continue;
    }
    list_finished_sequence(dir, "sequences/" + name + "/", listing);
    const auto number = std::stoull(name);
    if (number <= UINT32_MAX) {
      list_planned_sequence(dir, static_cast<std::uint32_t>(number), listing);
    }
  }
}

// The images of complete renders.
void list_renders(const fs::path& dir, Listing& listing) {
  for (const std::string& name : render_names(dir)) {
    const std::string folder = render_folder(name) + "/";
    const auto text = manifest_text(dir, folder + layout::kRenderJson);
    if (!text) continue;
    std::vector<std::string> names;
    const auto json =
        parse_manifest(*text, [&](const FileEntry& entry) { names.push_back(entry.path); });
    if (!json || !count_at(*json, "ensonify_render")) continue;
    listing.add(folder + layout::kRenderJson);
    for (const std::string& file : names) {
      listing.add(is_safe_relative_path(file) ? folder + file : file);
    }
  }
}

void list_top_level(const fs::path& dir, Listing& listing) {
  for (const CatalogueRow& row : catalogue()) {
    if (row.scope == FileScope::dataset) listing.add(row.file);
  }
  for (const std::string& manifest : {std::string(layout::kDatasetJson), layout::top_plan_path()}) {
    const auto text = manifest_text(dir, manifest);
    if (text) parse_manifest(*text, [&](const FileEntry& entry) { listing.add(entry.path); });
  }
}

// Manifests are removed after the files they list, so that an interrupted removal can resume;
// dataset.sha256 is removed first, so that the rest never passes as a finished data set.
int removal_rank(const std::string& path) {
  if (path == layout::kDatasetSha256) return 0;
  if (path == layout::kDatasetJson) return 4;
  if (path.starts_with(std::string(layout::kRenders) + "/")) {
    return path.ends_with(layout::kRenderJson) ? 2 : 1;
  }
  if (!path.starts_with("sequences/")) return 3;
  return path.ends_with(layout::kSequenceJson) ? 2 : 1;
}

Error refusal(const fs::path& dir, const std::string& why) {
  return {ErrorKind::usage, fmt::format("{}: {}; nothing was removed", dir.string(), why)};
}

}  // namespace

Status plan_sequence(const fs::path& dir, const SequenceInfo& info,
                     const std::vector<std::string>& templates) {
  const std::string path = layout::plan_path(info.sequence);
  if (listed_file_size(dir, path)) return {};
  Json plan = {{"ensonify_plan", 1},
               {"first_ping", info.first_ping},
               {"last_ping", info.last_ping},
               {"each_ping", templates}};
  for (const CatalogueRow* row : arrays_of(selection_of(info))) {
    plan["arrays"].push_back(row->array);
  }
  const auto written = write_file_atomically(dir, path, json_text(plan));
  return written ? Status() : Status(written.error());
}

Status plan_top_level(const fs::path& dir, const std::vector<std::string>& files) {
  Json entries = Json::array();
  for (const std::string& file : files) entries.push_back(json_of(FileEntry{file, 0, ""}));
  const auto written =
      write_file_atomically(dir, layout::top_plan_path(),
                            json_text({{"ensonify_plan", 1}, {"files", std::move(entries)}}));
  return written ? Status() : Status(written.error());
}

Result<Inventory> take_inventory(const fs::path& dir) {
  Listing listing;
  list_top_level(dir, listing);
  list_sequences(dir, listing);
  list_renders(dir, listing);
  if (listing.unsafe()) {
    return refusal(dir, fmt::format("a manifest lists '{}', which is not a path inside the folder",
                                    *listing.unsafe()));
  }
  const auto found = files_below(dir);
  if (!found) return found.error();

  Inventory inventory;
  std::vector<std::string> in_the_way;
  for (const std::string& path : *found) {
    // remove_work_folder handles records and temporary files in .work.
    if (path.starts_with(std::string(layout::kWorkFolder) + "/")) continue;
    if (listing.holds(path) && listed_file_size(dir, path)) {
      inventory.listed.push_back(path);
      continue;
    }
    inventory.strangers.push_back(path);
    if (layout::is_layout_name(path)) in_the_way.push_back(path);
  }
  if (!in_the_way.empty()) {
    const std::size_t more = in_the_way.size() - std::min(in_the_way.size(), kNamesInMessage);
    in_the_way.resize(in_the_way.size() - more);
    return refusal(dir,
                   fmt::format("no manifest lists {}{}, and a data set could write files of that "
                               "name; move them away",
                               fmt::join(in_the_way, ", "),
                               more > 0 ? fmt::format(" and {} more", more) : ""));
  }
  std::stable_sort(
      inventory.listed.begin(), inventory.listed.end(),
      [](const std::string& a, const std::string& b) { return removal_rank(a) < removal_rank(b); });
  return inventory;
}

Status remove_listed(const fs::path& dir, const Inventory& inventory) {
  bool work_is_gone = false;
  for (const std::string& path : inventory.listed) {
    // Plans stay until the files that they list are removed.
    if (!work_is_gone && removal_rank(path) >= 3) {
      remove_work_folder(dir);
      work_is_gone = true;
    }
    if (path == layout::kWorkJson) continue;
    if (::unlink((dir / path).c_str()) != 0 && errno != ENOENT) {
      return Error{ErrorKind::io, fmt::format("cannot remove {}: {}", (dir / path).string(),
                                              std::generic_category().message(errno))};
    }
  }
  for (const char* folder : {"sequences", "assets", "splits", layout::kRenders})
    remove_empty_folders(dir / folder);
  return {};
}

}  // namespace ensonify
