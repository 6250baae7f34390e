// The instruments of a rig as one page: their mounts and clocks, and their pings of one time side
// by side. Private to report/.
//
//   RigPage  WrittenRig  write_rig_page
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "dataset/rig_file.h"

namespace ensonify {

struct RigPage {
  std::filesystem::path dir;  // the folder of the rig
  RigFile rig;
  std::vector<std::string> reports;  // of each instrument, next to the page; empty: none
  std::uint64_t most_rows = 0;
};

struct WrittenRig {
  std::uint64_t pings = 0, shown = 0;  // of the instrument that begins the rows
  std::uint64_t bytes = 0;             // of the page
};

// A row has a ping of the first instrument with images and, of each other one, the ping of the same
// sequence that is nearest in time. Errors: those of read_dataset.h, interrupted.
Result<WrittenRig> write_rig_page(const RigPage& page, const std::filesystem::path& path,
                                  const Workers& workers, bool (*stop)());

}  // namespace ensonify
