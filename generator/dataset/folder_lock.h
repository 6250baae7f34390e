// Locks of folders. They do nothing on file systems without locks.
//
//   FolderLock   two processes do not open or finish one folder at the same time
//   FolderUse    no process empties a folder in which another one works
#pragma once

#include <filesystem>

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

}  // namespace ensonify
