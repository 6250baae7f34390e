// The parts of a preview: a few pings of a scenario at reduced cost. Also detects changed files by
// polling, which works on network file systems, too.
//
//   spread_pings      the selection of pings
//   reduced_scenario  the scenario that is rendered
//   reduction_text    the reductions in words
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

// Selects `count` of `pings` pings, evenly spaced from the first to the last, or all if there are
// fewer. A count of one selects the first.
std::vector<std::uint32_t> spread_pings(std::uint32_t pings, std::uint32_t count);

// The result writes only polar images and labels, whatever the scenario selects. Unless `full` is
// set, it has half of the rays in elevation, one column of rays per beam cell, half of the adaptive
// refinement but enough for speckle, and no scatterers fixed on surfaces. Beams, range, samples and
// all sources of echoes stay unchanged.
Scenario reduced_scenario(const Scenario& scenario, bool full);

// "rays 512 x 57 instead of 512 x 114, 10 per cell instead of 20; images and labels only"
std::string reduction_text(const Scenario& scenario, const Scenario& reduced);

// The visible state of a file. An editor that replaces a file by a new one changes its number, even
// if size and time stay the same.
struct FileStamp {
  bool there = false;
  std::uint64_t bytes = 0, number = 0;
  std::int64_t changed_s = 0, changed_ns = 0;
  friend bool operator==(const FileStamp&, const FileStamp&) = default;
};

class FileWatch {
 public:
  // Watches these from now on, in their current state; call it before they are read. Files that are
  // watched already keep their recorded state.
  void watch(const std::vector<std::filesystem::path>& files);
  // Records the current state of all files.
  void renew();
  // Whether any file differs from its recorded state.
  bool changed() const;
  std::size_t size() const { return stamps_.size(); }
  friend bool operator==(const FileWatch&, const FileWatch&) = default;

 private:
  std::map<std::filesystem::path, FileStamp> stamps_;
};

// Returns after a file has changed and all of them have been unchanged for a moment, so that
// several files, or one in pieces, can be written. Also returns when `also`, called from time to
// time, or `stop` returns true. The current state is recorded then.
void wait_for_change(FileWatch& files, const std::function<bool()>& also, bool (*stop)());

}  // namespace ensonify
