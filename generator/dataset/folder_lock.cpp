#include "dataset/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

#include "dataset/layout.h"

namespace ensonify {

FolderLock::FolderLock(const std::filesystem::path& dir)
    : descriptor_(::open(dir.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (descriptor_ >= 0) ::flock(descriptor_, LOCK_EX);
}

FolderLock::~FolderLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

FolderUse::FolderUse(const std::filesystem::path& dir)
    : descriptor_(::open((dir / layout::kWorkJson).c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW)) {
  if (descriptor_ >= 0) ::flock(descriptor_, LOCK_SH);
}

FolderUse::~FolderUse() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

FolderUse::FolderUse(FolderUse&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)) {}

FolderUse& FolderUse::operator=(FolderUse&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

bool FolderUse::is_used(const std::filesystem::path& dir) {
  const int file = ::open((dir / layout::kWorkJson).c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (file < 0) return false;
  const bool used = ::flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  ::close(file);
  return used;
}

}  // namespace ensonify
