// The identity of a piece of work and the folder it is done in.
//
//   to_json                what must be equal for a folder to be continued
//   open_work  is_sealed   new, continued, complete, or refused
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "core/error.h"
#include "dataset/folder_lock.h"
#include "dataset/manifest.h"

namespace ensonify {

// The bytes of work.json: the same for equal identities, different for different ones.
std::string to_json(const WorkIdentity& identity);

enum class FolderState {
  started,    // new or emptied; work.json is written
  continued,  // the same work, not done, or done for fewer sequences
  complete,   // the same work, done: dataset.json and dataset.sha256 agree; leave it alone
};

// Makes `dir` ready for the work, which has `sequences` sequences.
//
// A folder that is new or empty is started; one with the same work is continued or complete (then
// a .work that was left behind is removed). Any other is refused (usage) with what differs, and so
// is the same work with more sequences than asked for. Before a folder is continued, a
// sequence.json that lists missing files is taken away, so that its sequence is made again.
//
// With `overwrite` those refused are emptied and started if ensonify made them (a valid work.json
// or dataset.json), and so is one that is complete. Only files that a manifest lists are removed;
// links and '..' are not followed. Others stay, and where such a file stands in the place of one of
// ours the folder is refused before anything is removed. The same work that is not yet complete is
// continued even then, so that shards which all say `overwrite` do not undo each other.
//
// Error (io): the folder cannot be made, read or written.
//
// Nor is a folder emptied in which another process is at work; whoever goes on to work here keeps
// `use` as long. A folder of ours that is a link is refused: what stands behind it is somebody's.
//
// With `keep_sealed` a finished data set is complete whatever work it is, and stays.
Result<FolderState> open_work(const std::filesystem::path& dir, const WorkIdentity& identity,
                              std::uint32_t sequences, bool overwrite, bool keep_sealed = false,
                              FolderUse* use = nullptr);

// Whether a data set was finished in `dir`: dataset.json and dataset.sha256 are there and agree.
// Looks at nothing else.
bool is_sealed(const std::filesystem::path& dir);

}  // namespace ensonify
