// Locks of folders. Where the file system has none they do nothing.
//
//   FolderLock   two processes do not open or finish one folder at the same time
//   FolderUse    nobody empties a folder in which another is at work
#pragma once

#include <filesystem>

namespace ensonify {

// Waits for whoever holds it. The folder should be there.
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& dir);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_;
};

// Of any number of processes, as long as they work in the folder: a shared lock of its work.json,
// which is of one inode as long as the work is the same.
class FolderUse {
 public:
  FolderUse() = default;
  explicit FolderUse(const std::filesystem::path& dir);
  ~FolderUse();
  FolderUse(FolderUse&& other) noexcept;
  FolderUse& operator=(FolderUse&& other) noexcept;

  // Whether another has one. Under a FolderLock, so that nobody begins meanwhile.
  static bool is_used(const std::filesystem::path& dir);

 private:
  int descriptor_ = -1;
};

}  // namespace ensonify
