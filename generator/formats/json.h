// JSON of the data set: keys in insertion order, numbers that read back to the same double, NaN as
// null.
//
//   json_text  json_line  quoted_text   pretty with a newline at the end; on one line; a text
//   parse_json             none if it is not JSON or nested too deeply
//   parse_shallow          discarded where parse_json gives none
//   parse_shallow_with     the same with a parser callback of nlohmann::json, of a text or a stream
//   parse_manifest         the same, with a callback for each entry of `files`
//   parse_manifest_entries  parse_manifest_file   entries as they stand; a file that need not be held
//   member  text_at  count_at  number_at   a member of the wanted kind, or none
//   json_members  json_elements   long lines of our own files, split in place: nothing is copied, and
//                          numbers and strings are not parsed
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/vec.h"
#include "formats/files.h"

namespace ensonify {

using Json = nlohmann::ordered_json;

std::string json_text(const Json& json);
std::string json_line(const Json& json);
// Between double quotes, as JSON and YAML both read it.
std::string quoted_text(std::string_view text);

// Null if the number is not finite, which JSON cannot express otherwise.
Json number_or_null(double value);

Json json_of(const Vec3& v);     // [x, y, z]
Json json_of(const Pose& pose);  // {position_m: [x, y, z], quaternion_wxyz: [w, x, y, z]}
Json json_of(const FileEntry& entry);

// Limit for the nesting of JSON. The library's parser has none, but copying and dumping are
// recursive, and 100 kB of brackets would overflow the stack.
inline constexpr int kMaxJsonDepth = 64;

// They are compiled once: the library's parser is a template of its input, and dear to the
// compiler.
using KeepJson = std::function<bool(int depth, Json::parse_event_t event, Json& parsed)>;
Json parse_shallow(std::string_view text);
Json parse_shallow_with(const KeepJson& keep, std::string_view text);
Json parse_shallow_with(const KeepJson& keep, std::istream& stream);

std::optional<Json> parse_json(std::string_view text);

// Reads a manifest without keeping its long top-level array `files`. An entry that lacks a member
// has an empty path.
std::optional<Json> parse_manifest(std::string_view text,
                                   const std::function<void(FileEntry)>& on_file);

// The same with the entries as they stand.
std::optional<Json> parse_manifest_entries(std::string_view text,
                                           const std::function<void(const Json&)>& on_entry);

// Reads the file piece by piece, since sequences with many pings have large manifests. None if it
// cannot be read.
std::optional<Json> parse_manifest_file(const std::filesystem::path& path,
                                        const std::function<void(FileEntry)>& on_file);

// Never throw, whatever the value is.
const Json* member(const Json& json, std::string_view key);
std::optional<std::string> text_at(const Json& json, std::string_view key);
std::optional<std::uint64_t> count_at(const Json& json, std::string_view key);
std::optional<double> number_at(const Json& json, std::string_view key);

// {path, bytes, sha256}; none if a member is missing or of another kind.
std::optional<FileEntry> file_entry_of(const Json& json);

// {position_m, quaternion_wxyz}.
std::optional<Pose> pose_of_json(const Json& json);

struct JsonMembers {
  std::vector<std::pair<std::string_view, std::string_view>> all;

  // Empty if there is no member with that key.
  std::string_view at(std::string_view key) const;
};

// Keys without their quotes, as they are written. None if the text is not exactly one object with
// balanced brackets and quotes.
std::optional<JsonMembers> json_members(std::string_view object);

// The same of an array.
std::optional<std::vector<std::string_view>> json_elements(std::string_view array);

}  // namespace ensonify
