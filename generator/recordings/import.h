// Makes a data set from a log.
//
//   ImportOptions  ImportReport  import_log
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "recordings/log.h"

namespace ensonify {

struct ImportOptions {
  std::filesystem::path log, output;
  std::optional<std::pair<std::uint32_t, std::uint32_t>> pings;  // frames of the log, [first, last)
  std::string name;             // empty: the log's, without its end
  std::string split = "train";  // of all sequences
  int cartesian_height_px = 1000;
  LogChoices choices;
  int threads = 0;
  bool overwrite = false;
  std::string program_version, program_commit, host;
  std::function<bool()> stop;         // true ends with ErrorKind::interrupted
  std::function<void()> listen = {};  // called when the first file is about to be written
};

struct ImportReport {
  std::uint64_t pings = 0, sequences = 0;
  std::string instrument;             // of the first sequence
  bool complete = false;              // the folder held the data set already
  std::vector<std::string> warnings;  // what was left out or is unusual
};

// Reads the log twice and holds a few frames at a time. A folder with an interrupted import of the
// same log is continued. Errors: those of survey_log, open_work, write_ping and finish_dataset.
Result<ImportReport> import_log(const ImportOptions& options);

}  // namespace ensonify
