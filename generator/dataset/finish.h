// Finishes a sequence once all its pings exist, and the data set once all its sequences do. Both
// steps may be interrupted anywhere and called again, also by two processes at once.
//
//   sequence_is_finished  finished_pings  SequenceParts  finish_sequence
//   Asset  DatasetInfo  data_card  finish_dataset
#pragma once

#include <complex>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "core/moments.h"
#include "core/navigation_tables.h"
#include "core/ping.h"
#include "dataset/croissant.h"
#include "dataset/work.h"

namespace ensonify {

// Whether the sequence has its sequence.json and every listed file exists with its size.
bool sequence_is_finished(const std::filesystem::path& dir, std::uint32_t sequence);
// The number of its pings; none if it is not finished.
std::optional<std::uint64_t> finished_pings(const std::filesystem::path& dir,
                                            std::uint32_t sequence);

// Writes a file piece by piece.
using WriteFile = std::function<void(const std::function<void(std::string_view)>& append)>;

// Appends text to the tables of the navigation sensors.
using WriteTables = std::function<void(
    const std::function<void(NavigationTable table, std::string_view text)>& append)>;

// The result of a ping without its files.
using PingFrame = std::function<PingResult(std::uint32_t ping)>;

// Parts of a sequence that are not in the records of its pings.
struct SequenceParts {
  std::string_view sdf_vdb = {};  // the bytes of sdf.vdb, where info.sdf asks for them
  // Of all its pings, where info.output.statistics asks; and their expected intensities.
  const Moments* moments = nullptr;
  const PooledPixels* pool = nullptr;
  // labels/cartesian.h's, [rows x columns], where info.output.cartesian asks for it.
  std::span<const std::int32_t> cartesian_map = {};
  std::span<const float> covisibility = {};  // [pings x pings], where info.output asks for it
  // How beams and pulse spread echo powers, where info.output.elevation asks and there is no array:
  std::span<const float> beam_power = {};  // [beams x beams], of beam and cell
  std::span<const std::complex<float>> pulse_power =
      {};                                    // [record.transform], Fourier coefficients
  WriteFile world_ply = {}, world_glb = {};  // where info.output.world asks for them
  std::span<const float> height_map = {};    // [rows x columns], where info.height_map asks for it
  WriteTables navigation = {};               // where info.navigation asks for them
  PingFrame frame = {};  // in place of records, where pings have no files and no records
};

// Writes the sequence's arrays and tables from the records of its pings
// [info.first_ping, info.last_ping), or from their frames, then sequence.json. Does nothing if it
// is finished. Error (usage): records of some pings, or their files, are missing. Error (io): as it
// says.
Status finish_sequence(const std::filesystem::path& dir, const SequenceInfo& info,
                       const SequenceParts& parts = {});

// An input file of the scenario; goes to assets/<sha256>.<extension>.
struct Asset {
  std::string sha256;
  std::string extension;  // with or without its dot; may be empty
  std::filesystem::path source;
};

struct DatasetInfo {
  WorkIdentity identity;
  std::string scenario_yaml;             // resolved, `sequences` included
  SequenceInfo first;                    // sequence 0, which the data card describes
  std::vector<std::uint32_t> sequences;  // those that are finished, ascending
  std::vector<SequenceFailure> failed;   // those that cannot be made, ascending
  std::uint64_t sequences_in_all = 0;    // of the scenario; other processes make the rest
  std::vector<std::string> classes;      // class id k is classes[k - 1]
  std::vector<ClassKind> class_kinds;    // of each
  std::vector<Asset> assets;
  PublicationInfo publication = {};
  // Values that differ between runs. They go to provenance.json, the only file that is never
  // hashed.
  std::string host;
  double wall_seconds = 0;
  int threads = 0;
};

// The text of README.md, which describes the data set and how to read it. `pings` counts all its
// sequences.
std::string data_card(const DatasetInfo& info, std::uint64_t pings);

// Writes the top-level files, dataset.json and finally dataset.sha256, and removes .work; while
// sequences are missing, it removes only the parts of finished ones, since other processes may be
// making the rest. Renews the files if `sequences` grew; reads the files of sequences one after
// another. Returns the content of dataset.json. Error (usage): a sequence is not finished, the
// folder holds the data set of another run, or an input file has changed since it was hashed. Error
// (io): as it says.
Result<DatasetManifest> finish_dataset(const std::filesystem::path& dir, const DatasetInfo& info);

}  // namespace ensonify
