// The manifests of a data set as JSON, written and read by the same list of members. Private to
// dataset/.
//
//   sequence_head  read_sequence_head         sequence.json, all but the list of files
//   sequence_schema                           its JSON Schema, without most titles and meanings
//   read_sequence_manifest                    ... of a data set's folder
//   dataset_json  read_dataset_head           dataset.json
//   dataset_schema                            its JSON Schema, likewise
//   work_json                                 work.json
//   files_opening  file_line  files_closing   the list, one line an entry, written piecewise
//   sequence_is_whole                         found on disk, with every file it lists
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "dataset/manifest.h"
#include "formats/files.h"
#include "formats/json.h"

namespace ensonify {

// `each_ping`: templates of a ping's files (layout.h); `bytes`: of all files together.
Json sequence_head(const SequenceInfo& info, const std::vector<std::string>& each_ping,
                   std::uint64_t bytes);
// What sequence_head writes in its variants, and the list of files.
Json sequence_schema();
// None if it is not a sequence.json.
std::optional<SequenceManifest> read_sequence_head(const Json& head);
std::optional<SequenceManifest> read_sequence_manifest(const std::filesystem::path& dir,
                                                       std::uint32_t sequence);

Json dataset_json(const DatasetManifest& manifest, const std::vector<FileEntry>& files);
Json dataset_schema();
// None if it is not a dataset.json.
std::optional<DatasetManifest> read_dataset_head(const Json& head);

Json work_json(const WorkIdentity& identity);

// The head as text, left open behind `"files": [`.
std::string files_opening(const Json& head);
std::string file_line(const FileEntry& entry, bool first);
std::string files_closing();

// Whether the sequence has a sequence.json and every listed file exists with its size.
bool sequence_is_whole(const std::filesystem::path& dir, std::uint32_t sequence);

}  // namespace ensonify
