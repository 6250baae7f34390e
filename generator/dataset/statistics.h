// Statistics of a sequence on disk: the arrays, and the moments of an interrupted run.
//
//   statistics_arrays                    the arrays, which catalogue.h also lists
//   statistics_json                      their description in sequence.json
//   no_moments                           of a sequence, before its first realization
//   write_statistics                     moments -> arrays
//   MomentsFile  load_moments  remove_moments   a checkpoint in .work
//   realizations_in                             ... its number of realizations
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "core/moments.h"
#include "core/ping.h"
#include "formats/files.h"
#include "formats/json.h"

namespace ensonify {

// What rows of an array are; its columns are beams. Samples and beams are the polar image's rows
// and columns; a covariance of neighbors has one row or one column less. Lags begin with 0.
enum class StatisticsRows { samples, bins, lags };

struct StatisticsArray {
  const char* name;   // statistics/contrast.npy
  const char* descr;  // npy.h
  const char* unit;
  const char* what;
  int fewer_rows = 0, fewer_columns = 0;
  StatisticsRows rows = StatisticsRows::samples;
};
std::vector<StatisticsArray> statistics_arrays();

Json statistics_json(const SequenceInfo& info);

Moments no_moments(const SequenceInfo& info);

// Error (bug): they are not of all pings of the sequence; (io): a file cannot be written.
Result<std::vector<FileEntry>> write_statistics(const std::filesystem::path& dir,
                                                const SequenceInfo& info, const Moments& moments,
                                                const PooledPixels& pool);

// Moments written row by row while other threads use the finished rows.
class MomentsFile {
 public:
  MomentsFile(const std::filesystem::path& dir, const SequenceInfo& info, std::uint64_t count);
  // Appends the moments of beams [first, last), which must follow the previous ones.
  void append(const Moments& moments, int first, int last);
  Status commit();

 private:
  StreamedFile file_;
  std::uint64_t check_;
};

// None if there is no checkpoint of this sequence or it is damaged; then the work is repeated.
std::optional<Moments> load_moments(const std::filesystem::path& dir, const SequenceInfo& info);
// As the first line of the checkpoint says; 0 if it says nothing. Its moments are not checked.
std::uint64_t realizations_in(const std::filesystem::path& checkpoint);
void remove_moments(const std::filesystem::path& dir, std::uint32_t sequence);

}  // namespace ensonify
