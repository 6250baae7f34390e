// Pictures of a finished data set, read again, from files of a ping or from packed arrays.
//
//   stored_channels  has_series   what a sequence has
//   read_picture                  the channels of one ping's picture that are asked for
//   read_series                   one ping's series
#pragma once

#include <complex>
#include <cstdint>
#include <string_view>
#include <vector>

#include "dataset/read_dataset.h"

namespace ensonify {

enum class StoredView { polar, cartesian };

struct PictureChannels {
  bool level = false, clean = false, elevation = false;
  bool instance = false, semantic = false, shadow = false;
};

// Row-major, row 0 on top: of a polar picture rows are samples and columns beams. What was not
// asked for, or what the data set has not got, is empty.
struct StoredPixels {
  std::uint64_t rows = 0, columns = 0;
  std::vector<float> level_db, clean_db;        // dB re 1 uPa; -99 without energy
  std::vector<float> elevation_rad;             // NaN without echo
  std::vector<std::uint16_t> instance, shadow;  // ids, 0 for none
  std::vector<std::uint8_t> semantic;
};

PictureChannels stored_channels(const StoredSequence& sequence, StoredView view);
bool has_series(const StoredSequence& sequence);

// Needs a ping of the sequence. Error (io): a file is missing, damaged or of another size than the
// manifest says.
Result<StoredPixels> read_picture(const StoredDataset& dataset, const StoredSequence& sequence,
                                  StoredView view, std::uint32_t ping,
                                  const PictureChannels& channels);

// [beams x samples], Pa; empty where the data set has no series. Error (io): as above.
Result<std::vector<std::complex<float>>> read_series(const StoredDataset& dataset,
                                                     const StoredSequence& sequence,
                                                     std::uint32_t ping);

}  // namespace ensonify
