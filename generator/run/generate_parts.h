// What `generate` makes together: the data set of a scenario, or one for each instrument of a rig.
// Nothing is written here.
//
//   warn
//   Opened  Parts  open_parts   everything known before the checks
//   of_part                     an error with the name of its instrument
#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>
#include <vector>

#include "dataset/work.h"
#include "ping/tables.h"
#include "run/make_dataset.h"
#include "run/options.h"
#include "run/rig.h"
#include "run/sequence_worlds.h"

namespace ensonify {

void warn(const GenerateOptions& options, std::string_view text);

struct Opened {
  GenerateOptions options;  // with its own folder
  SequenceWorlds worlds;
  Numerics numerics;
  DatasetWork work;
  int threads = 1;
  SharedParts first = {};
  FolderState state = FolderState::started;
  FolderUse use = {};
};

enum class Pings { wanted, made };  // made: no memory is needed for them

struct Parts {
  std::vector<Opened> list;
  Instruments names;  // empty without a rig
};

// Errors: those of open_untraced, numerics_that_fit, threads_that_fit and settle_dataset.
Result<Parts> open_parts(GenerateOptions options, Pings pings);

Error of_part(const Parts& parts, std::size_t part, const Error& error,
              const std::filesystem::path& scenario);

}  // namespace ensonify
