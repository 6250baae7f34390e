// rig.json, at the top of the folder of a rig: its instruments, each with the data set of that
// name.
//
//   RigInstrument  RigFile  to_json  read_rig
//   folder_of_kind    of the first instrument of a kind
//   open_rig_folder
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/ping.h"
#include "core/vec.h"

namespace ensonify {

// Absent values are sampled for each sequence.
struct RigInstrument {
  std::string name;  // of its folder
  InstrumentKind kind = InstrumentKind::sonar;
  std::optional<Pose> mount;  // on the body that the trajectory moves
  std::optional<double> ping_rate_hz;
  std::optional<double> time_offset_s;  // of its first ping, after the start of the trajectory
};

struct RigFile {
  std::string name;  // of the scenario
  std::vector<RigInstrument> instruments;
};

std::string to_json(const RigFile& rig);

// None if the folder has no rig.json. Errors (io): it cannot be read, or it is damaged.
Result<std::optional<RigFile>> read_rig(const std::filesystem::path& dir);

// The data set of the rig's first instrument of this kind, beside the data set `dir` of another one
// of its instruments; none without a rig, or without such an instrument. Errors: those of read_rig.
Result<std::optional<std::filesystem::path>> folder_of_kind(const std::filesystem::path& dir,
                                                            InstrumentKind kind);

// Makes `dir` the folder of the rig: a new or empty one, or one that has the same rig.json. With
// `overwrite` also one whose rig.json lists the same names. Errors (usage): another folder; (io).
Status open_rig_folder(const std::filesystem::path& dir, const RigFile& rig, bool overwrite);

}  // namespace ensonify
