// Pictures of the shown pings as chunks of the page. Private to report/.
//
//   pixels_of  for_each_picture
//   PictureScale  look_at   what the codes of pictures stand for; the same pass takes the speckle
//   grey_code               ... the code of a value
//   CodedPing  PictureBook  encode_pictures   chunks, no more of them than the page may hold
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/parallel.h"
#include "dataset/read_pictures.h"
#include "report/chunks.h"
#include "report/speckle.h"
#include "report/survey.h"

namespace ensonify {

struct PictureScale {
  double min_db = 0, max_db = 1;            // of codes 1 and 255
  double show_min_db = 0, show_max_db = 1;  // of the first view
  std::optional<double> min_rad, max_rad;   // of elevations; absent: there is none
};

// 0 for nothing (not a number), 1 to 255 for values from low to high.
std::uint8_t grey_code(double value, double low, double high);

struct Look {
  PictureScale scale;
  std::optional<Speckle> speckle;
};

// What is shared by all that read pictures.
struct PictureJob {
  const StoredDataset& dataset;
  const Survey& survey;
  const Workers& workers;
  bool (*stop)() = nullptr;
};

// The polar picture; where there is none, levels of the series.
Result<StoredPixels> pixels_of(const PictureJob& job, const ShownPing& ping);

Result<Look> look_at(const PictureJob& job);

// use(i) for all i below `count`, side by side; the first Error by i, or that the user stopped it.
Status for_each_picture(const PictureJob& job, std::size_t count,
                        const std::function<Status(std::size_t)>& use);

struct CodedPing {
  // Numbers of chunks.
  std::optional<std::size_t> level, clean, elevation, labels, shadow;
  std::size_t beam = 0;  // the one whose levels are told exactly
  std::optional<std::size_t> beam_level, beam_clean;
};

struct PictureBook {
  std::vector<CodedPing> pings;  // as Survey::shown
  int quality = 0;               // of lossy pictures
  int elevation_step = 1;        // every so manieth row and column of elevations is kept
};

// As good as `budget` bytes, in base64, allow.
Result<PictureBook> encode_pictures(const PictureJob& job, const PictureScale& scale,
                                    std::uint64_t budget, Chunks& chunks);

}  // namespace ensonify
