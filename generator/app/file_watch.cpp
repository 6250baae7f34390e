#include "app/file_watch.h"

#include <sys/stat.h>

#include <chrono>
#include <thread>
#include <utility>

namespace ensonify {
namespace {

constexpr std::chrono::milliseconds kPause(250);
constexpr int kPausesBetweenQuestions = 4;

FileStamp stamp_of(const std::filesystem::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return {};
  return {true, static_cast<std::uint64_t>(status.st_size), status.st_ino, status.st_mtim.tv_sec,
          status.st_mtim.tv_nsec};
}

}  // namespace

void FileWatch::watch(const std::vector<std::filesystem::path>& files) {
  std::map<std::filesystem::path, FileStamp> stamps;
  for (const std::filesystem::path& file : files) {
    const auto known = stamps_.find(file);
    stamps[file] = known != stamps_.end() ? known->second : stamp_of(file);
  }
  stamps_ = std::move(stamps);
}

void FileWatch::renew() {
  for (auto& [file, stamp] : stamps_) stamp = stamp_of(file);
}

bool FileWatch::changed() const {
  for (const auto& [file, stamp] : stamps_) {
    if (stamp_of(file) != stamp) return true;
  }
  return false;
}

void wait_for_change(FileWatch& files, const std::function<bool()>& also, bool (*stop)()) {
  for (int pauses = 1; !stop(); ++pauses) {
    std::this_thread::sleep_for(kPause);
    const bool asks = also && pauses % kPausesBetweenQuestions == 0;
    if (files.changed() || (asks && also())) break;
  }
  for (FileWatch before; !stop() && before != files;) {
    before = files;
    std::this_thread::sleep_for(kPause / 2);
    files.renew();
  }
}

}  // namespace ensonify
