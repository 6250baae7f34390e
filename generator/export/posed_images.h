// Amplitude images with poses, as neural surfaces and registration read them. Private to export/.
//
//   DatasetScale  scale_of_dataset  scaled_amplitudes   one gain for all images of a data set
//   matrix_of                                           a pose as a 4 x 4 matrix
//   equal_beams                                         whether an azimuth is linear in the column
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "export/log_counts.h"

namespace ensonify {

// The level that becomes 1: full_scale_of the first exported sequence.
struct DatasetScale {
  double full_scale_db = 0;
};
Result<DatasetScale> scale_of_dataset(const ExportJob& job);

// [samples x beams], 10^((level - full scale) / 20), at most 1. Errors: those of log_ping_of.
Result<std::vector<float>> scaled_amplitudes(const ExportJob& job, const StoredSequence& sequence,
                                             std::uint32_t ping, const DatasetScale& scale);

// Row-major, from the sonar's frame to the world.
std::array<double, 16> matrix_of(const Pose& pose);

// Error (usage): beams that are not equally spaced.
Status equal_beams(const StoredSequence& sequence);

}  // namespace ensonify
