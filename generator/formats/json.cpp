#include "formats/json.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <utility>

namespace ensonify {
namespace {

template <class... Input>
Json parsed_with(const KeepJson& keep, Input&&... input) {
  bool too_deep = false;
  const auto guarded = [&](int depth, Json::parse_event_t event, Json& parsed) {
    too_deep = too_deep || depth > kMaxJsonDepth;
    return !too_deep && keep(depth, event, parsed);
  };
  Json json = Json::parse(std::forward<Input>(input)..., guarded, false);
  if (too_deep) json = Json(Json::value_t::discarded);
  return json;
}

constexpr auto kReplace = Json::error_handler_t::replace;

std::optional<double> number_in(const Json& json, std::size_t index) {
  if (!json.is_array() || index >= json.size() || !json[index].is_number()) return std::nullopt;
  return json[index].get<double>();
}

}  // namespace

std::string json_text(const Json& json) { return json.dump(2, ' ', false, kReplace) + "\n"; }
std::string json_line(const Json& json) { return json.dump(-1, ' ', false, kReplace); }
std::string quoted_text(std::string_view text) { return json_line(Json(text)); }

Json number_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json json_of(const Vec3& v) { return Json::array({v.x, v.y, v.z}); }

Json json_of(const Pose& pose) {
  const Quat& q = pose.rotation;
  return {{"position_m", json_of(pose.position_m)},
          {"quaternion_wxyz", Json::array({q.w, q.x, q.y, q.z})}};
}

Json json_of(const FileEntry& entry) {
  return {{"path", entry.path}, {"bytes", entry.bytes}, {"sha256", entry.sha256}};
}

Json parse_shallow_with(const KeepJson& keep, std::string_view text) {
  return parsed_with(keep, text.begin(), text.end());
}

Json parse_shallow_with(const KeepJson& keep, std::istream& stream) {
  return parsed_with(keep, stream);
}

Json parse_shallow(std::string_view text) {
  return parse_shallow_with([](int, Json::parse_event_t, Json&) { return true; }, text);
}

std::optional<Json> parse_json(std::string_view text) {
  Json json = parse_shallow(text);
  if (json.is_discarded()) return std::nullopt;
  return json;
}

namespace {

template <class Input>
std::optional<Json> without_entries(const std::function<void(const Json&)>& on_entry,
                                    Input&& input) {
  bool in_files = false;
  const auto keep = [&](int depth, Json::parse_event_t event, Json& parsed) {
    if (event == Json::parse_event_t::key && depth == 1) in_files = parsed == "files";
    if (!in_files || event != Json::parse_event_t::object_end || depth != 2) return true;
    on_entry(parsed);
    return false;
  };
  Json json = parse_shallow_with(keep, input);
  if (json.is_discarded() || !json.is_object()) return std::nullopt;
  return json;
}

}  // namespace

std::optional<Json> parse_manifest_entries(std::string_view text,
                                           const std::function<void(const Json&)>& on_entry) {
  return without_entries(on_entry, text);
}

std::optional<Json> parse_manifest(std::string_view text,
                                   const std::function<void(FileEntry)>& on_file) {
  return parse_manifest_entries(
      text, [&](const Json& entry) { on_file(file_entry_of(entry).value_or(FileEntry{})); });
}

std::optional<Json> parse_manifest_file(const std::filesystem::path& path,
                                        const std::function<void(FileEntry)>& on_file) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  return without_entries(
      [&](const Json& entry) { on_file(file_entry_of(entry).value_or(FileEntry{})); }, file);
}

const Json* member(const Json& json, std::string_view key) {
  if (!json.is_object()) return nullptr;
  const auto found = json.find(std::string(key));
  return found == json.end() ? nullptr : &*found;
}

std::optional<std::string> text_at(const Json& json, std::string_view key) {
  const Json* found = member(json, key);
  if (found == nullptr || !found->is_string()) return std::nullopt;
  return found->get<std::string>();
}

std::optional<std::uint64_t> count_at(const Json& json, std::string_view key) {
  const Json* found = member(json, key);
  if (found == nullptr || !found->is_number_unsigned()) return std::nullopt;
  return found->get<std::uint64_t>();
}

std::optional<double> number_at(const Json& json, std::string_view key) {
  const Json* found = member(json, key);
  if (found == nullptr || !found->is_number()) return std::nullopt;
  return found->get<double>();
}

std::optional<FileEntry> file_entry_of(const Json& json) {
  const auto path = text_at(json, "path");
  const auto bytes = count_at(json, "bytes");
  const auto sha256 = text_at(json, "sha256");
  if (!path || !bytes || !sha256) return std::nullopt;
  return FileEntry{*path, *bytes, *sha256};
}

std::optional<Pose> pose_of_json(const Json& json) {
  const Json* position = member(json, "position_m");
  const Json* rotation = member(json, "quaternion_wxyz");
  if (position == nullptr || rotation == nullptr) return std::nullopt;
  double values[7];
  for (std::size_t i = 0; i < 7; ++i) {
    const auto value = i < 3 ? number_in(*position, i) : number_in(*rotation, i - 3);
    if (!value) return std::nullopt;
    values[i] = *value;
  }
  return Pose{{values[0], values[1], values[2]}, {values[3], values[4], values[5], values[6]}};
}

namespace {

constexpr std::string_view kBlanks = " \t\r\n";

void skip_blanks(std::string_view& text) {
  text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
}

bool take(std::string_view& text, char c) {
  skip_blanks(text);
  if (!text.starts_with(c)) return false;
  text.remove_prefix(1);
  return true;
}

// One past the closing quote of a string that begins the text; 0 where there is none.
std::size_t string_end(std::string_view text) {
  for (std::size_t i = 1; (i = text.find('"', i)) != text.npos; ++i) {
    // An even number of backslashes escape each other and not the quote.
    const std::size_t before = text.find_last_not_of('\\', i - 1);
    if ((i - 1 - before) % 2 == 0) return i + 1;
  }
  return 0;
}

// One past the bracket that closes the first one; 0 where none does.
std::size_t bracket_end(std::string_view text) {
  int depth = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') {
      const std::size_t length = string_end(text.substr(i));
      if (length == 0) return 0;
      i += length - 1;
    } else if (c == '{' || c == '[') {
      ++depth;
    } else if ((c == '}' || c == ']') && --depth == 0) {
      return i + 1;
    }
  }
  return 0;
}

// The value that begins the text, which then begins behind it; empty where there is none.
std::string_view take_value(std::string_view& text) {
  skip_blanks(text);
  if (text.empty()) return {};
  std::size_t length = 0;
  if (text[0] == '"') {
    length = string_end(text);
  } else if (text[0] == '{' || text[0] == '[') {
    length = bracket_end(text);
  } else {
    length = std::min(text.find_first_of(" \t\r\n,:{}[]\""), text.size());
  }
  const std::string_view value = text.substr(0, length);
  text.remove_prefix(length);
  return value;
}

// item() for each of those between `open` and `close`, which ends the text.
template <class Item>
bool for_each_item(std::string_view text, char open, char close, Item&& item) {
  if (!take(text, open)) return false;
  if (!take(text, close)) {
    do {
      if (!item(text)) return false;
    } while (take(text, ','));
    if (!take(text, close)) return false;
  }
  skip_blanks(text);
  return text.empty();
}

}  // namespace

std::string_view JsonMembers::at(std::string_view key) const {
  for (const auto& [name, value] : all) {
    if (name == key) return value;
  }
  return {};
}

std::optional<JsonMembers> json_members(std::string_view object) {
  JsonMembers members;
  const bool whole = for_each_item(object, '{', '}', [&](std::string_view& text) {
    const std::string_view key = take_value(text);
    if (key.size() < 2 || key[0] != '"' || !take(text, ':')) return false;
    const std::string_view value = take_value(text);
    members.all.emplace_back(key.substr(1, key.size() - 2), value);
    return !value.empty();
  });
  if (!whole) return std::nullopt;
  return members;
}

std::optional<std::vector<std::string_view>> json_elements(std::string_view array) {
  std::vector<std::string_view> elements;
  const bool whole = for_each_item(array, '[', ']', [&](std::string_view& text) {
    elements.push_back(take_value(text));
    return !elements.back().empty();
  });
  if (!whole) return std::nullopt;
  return elements;
}

}  // namespace ensonify
