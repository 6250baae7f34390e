// JSON of the data set: keys in the order in which they are put in, numbers in a form that reads
// back to the same double, not-a-number as null. Private to dataset/.
//
//   json_text  json_line       pretty with a newline at the end; on one line
//   parse_json                 none where it is not JSON, or nested deeper than ours
//   (shallow_json.h) parse_manifest  parse_manifest_entries   the same, its long list of files
//   handed out one by one parse_manifest_file        ... of a file that need not be held text_at
//   count_at  ...     a member of the wanted kind, or none
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "core/vec.h"
#include "dataset/files.h"

namespace ensonify {

using Json = nlohmann::ordered_json;

std::string json_text(const Json& json);
std::string json_line(const Json& json);

// Null where the number is not finite: JSON has no other word for it.
Json number_or_null(double value);

Json json_of(const Vec3& v);     // [x, y, z]
Json json_of(const Pose& pose);  // {position_m: [x, y, z], quaternion_wxyz: [w, x, y, z]}
Json json_of(const FileEntry& entry);

std::optional<Json> parse_json(std::string_view text);

// Reads a manifest without keeping its top-level array `files`, which is what makes it long. An
// entry that lacks a member comes with an empty path.
std::optional<Json> parse_manifest(std::string_view text,
                                   const std::function<void(FileEntry)>& on_file);

// The same with the entries as they stand.
std::optional<Json> parse_manifest_entries(std::string_view text,
                                           const std::function<void(const Json&)>& on_entry);

// Of a file, read piece by piece: sequences of very many pings have manifests to match. None where
// it cannot be read.
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

}  // namespace ensonify
