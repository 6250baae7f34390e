// Whether files have changed, by looking at them: that works on network file systems too.
//
//   FileStamp  FileWatch
//   wait_for_change
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <vector>

namespace ensonify {

// What a file looks like from outside. An editor that replaces a file by another one gives it
// another number, even where size and time stay.
struct FileStamp {
  bool there = false;
  std::uint64_t bytes = 0, number = 0;
  std::int64_t changed_s = 0, changed_ns = 0;
  friend bool operator==(const FileStamp&, const FileStamp&) = default;
};

class FileWatch {
 public:
  // These from now on, as they are now: to be called before they are read. Those that are watched
  // already are as they were.
  void watch(const std::vector<std::filesystem::path>& files);
  // As all files are now.
  void renew();
  // Whether any is another than it was.
  bool changed() const;
  std::size_t size() const { return stamps_.size(); }
  friend bool operator==(const FileWatch&, const FileWatch&) = default;

 private:
  std::map<std::filesystem::path, FileStamp> stamps_;
};

// Returns once a file has changed and they all have been left alone for a moment: whoever writes
// several, or one in pieces, is waited for. Also when `also`, asked now and then, or `stop` says
// so. The files are as renewed then.
void wait_for_change(FileWatch& files, const std::function<bool()>& also, bool (*stop)());

}  // namespace ensonify
