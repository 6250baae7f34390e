// Keeps two processes from opening one folder at the same time.
#pragma once

#include <filesystem>

namespace ensonify {

// Waits for whoever holds it. Where the file system has no locks it does nothing. The folder should
// be there.
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& dir);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace ensonify
