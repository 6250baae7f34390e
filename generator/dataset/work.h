// The identity of a run and its output folder.
//
//   to_json                what must be equal to resume a folder
//   open_work  is_sealed   new, continued, complete, or refused
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "core/error.h"
#include "dataset/manifest.h"
#include "dataset/work_folder.h"

namespace ensonify {

// The bytes of work.json: the same for equal identities, different for different ones.
std::string to_json(const WorkIdentity& identity);

enum class FolderState {
  started,    // new or emptied; work.json is written
  continued,  // the same work, not done, or done for fewer sequences
  complete,   // the same work, done: dataset.json and dataset.sha256 agree
};

// Makes `dir` ready for the work, which has `sequences` sequences.
//
// A new or empty folder is started; one with the same work is continued or complete (then a
// leftover .work is removed). Any other is refused (usage) with what differs, and so is the same
// work with more sequences than requested. Before a folder is continued, a sequence.json that lists
// missing files is removed, so that its sequence is made again.
//
// With `overwrite` those refused are emptied and started if ensonify made them (a valid work.json
// or dataset.json), and so is one that is complete. Only files that a manifest lists are removed;
// links and '..' are not followed. Other files stay; if one of them has a name that we need, the
// folder is refused before anything is removed. Incomplete work of the same run is continued even
// then, so that shards that all give `overwrite` do not undo each other.
//
// Error (io): the folder cannot be made, read or written.
//
// A folder in which another process works is not emptied; the caller keeps `use` while it works
// here. A link in place of one of our folders is refused, since its target is not ours.
//
// With `keep_sealed`, any finished data set counts as complete and stays.
Result<FolderState> open_work(const std::filesystem::path& dir, const WorkIdentity& identity,
                              std::uint32_t sequences, bool overwrite, bool keep_sealed = false,
                              FolderUse* use = nullptr);

// Whether `dir` holds a finished data set: dataset.json and dataset.sha256 exist and agree. Checks
// nothing else.
bool is_sealed(const std::filesystem::path& dir);

}  // namespace ensonify
