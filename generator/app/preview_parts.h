// What a preview takes of a scenario: a few of its pings, and less of what only costs. And whether
// files have changed, found by looking at them, which works on network file systems too.
//
//   spread_pings      which pings
//   reduced_scenario  the scenario that is rendered
//   reduction_text    what is less in it, for people
//   FileStamp  FileWatch  wait_for_change
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "scenario/scenario.h"

namespace ensonify {

// `count` of `pings` pings, from the first to the last, evenly; all where there are fewer. One is
// the first.
std::vector<std::uint32_t> spread_pings(std::uint32_t pings, std::uint32_t count);

// Polar pictures and labels alone, whatever the scenario writes. Unless it is `full`: half of the
// rays in elevation, one column of them a sector, half as many by need, but as many as speckle
// needs, and none fixed on surfaces. Beams, range and samples stay, and so does all that sounds.
Scenario reduced_scenario(const Scenario& scenario, bool full);

// "rays 512 x 57 for 512 x 114, 10 a cell for 20; pictures and labels alone"
std::string reduction_text(const Scenario& scenario, const Scenario& reduced);

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
