// The folder of a data set while processes work in it: its locks, and .work, which records
// sequences that cannot be made until dataset.json lists them, and is removed in the end.
//
//   FolderLock         two processes do not open or finish one folder at the same time
//   FolderUse          no process empties a folder in which another one works
//   Failures  failures_in  record_failure   sequences that cannot be made
//   sequence_numbers   of the sequences of which a folder has any file
//   remove_work_folder  remove_work_of  remove_temporary_files
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/error.h"
#include "dataset/manifest.h"

namespace ensonify {

// Waits until the lock is free. The folder must exist.
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& dir);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_;
};

// A shared lock that any number of processes hold while they work in the folder. It is on
// work.json, whose inode does not change during the work.
class FolderUse {
 public:
  FolderUse() = default;
  explicit FolderUse(const std::filesystem::path& dir);
  ~FolderUse();
  FolderUse(FolderUse&& other) noexcept;
  FolderUse& operator=(FolderUse&& other) noexcept;

  // Whether another process holds one. Call it under a FolderLock, so that no process starts
  // meanwhile.
  static bool is_used(const std::filesystem::path& dir);

 private:
  int descriptor_ = -1;
};

using Failures = std::map<std::uint32_t, std::string>;  // the error of each

// Failures in dataset.json, and those recorded since. Ignores unreadable records: these sequences
// are tried again.
Failures failures_in(const std::filesystem::path& dir);

// Error (io): it cannot be written.
Status record_failure(const std::filesystem::path& dir, const SequenceFailure& failure);

// In ascending order, without duplicates.
std::vector<std::uint32_t> sequence_numbers(const std::filesystem::path& dir);

// Removes the records, plans and temporary files of .work, then the folders that are empty. Another
// process may do the same at the same time. Foreign files in it stay.
void remove_work_folder(const std::filesystem::path& dir);
// The same for some sequences, while other processes may work on theirs: temporary files stay.
void remove_work_of(const std::filesystem::path& dir, std::span<const std::uint32_t> sequences);
// Removes those of killed processes; a process that still works writes its own again.
void remove_temporary_files(const std::filesystem::path& dir);

}  // namespace ensonify
