// Frames of a figure, ping by ping.
//
//   FigureJob  choose         the content: options checked against the data set
//   is_animated  plane_of  is_mask
//   FrameMaker                draws the frames
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dataset/read_pictures.h"
#include "figure/compose.h"
#include "figure/drawing.h"
#include "figure/options.h"

namespace ensonify {

enum class FigureFormat { png, svg, webp, mp4 };

struct FigureJob {
  FigureFormat format = FigureFormat::png;
  StoredDataset dataset;
  StoredSequence sequence;
  std::uint32_t first_ping = 0, last_ping = 0;  // [first, last)
  PlaneNames planes;                            // to be read
  const ColourMap* map = nullptr;               // null for masks
  std::vector<bool> chosen;                     // [id]: drawn; of all instances, and none
};

bool is_animated(FigureFormat format);
// The plane that a quantity shows (core/image_planes.h).
std::string_view plane_of(FigureQuantity quantity);
bool is_mask(FigureQuantity quantity);

// Error (usage): not a finished data set, or it lacks the requested data; (io) it is damaged.
Result<FigureJob> choose(const FigureOptions& options);

// Limits, legend and layout come from the first ping, so that all frames are alike.
class FrameMaker {
 public:
  // The job and the options must outlive it.
  static Result<FrameMaker> open(const FigureJob& job, const FigureOptions& options);

  const Layout& layout() const { return layout_; }
  std::optional<std::array<double, 2>> limits() const;
  double fps() const;  // the rate of the pings, from 1 to 30; 5 if their times do not give one
  Result<Drawing> frame(std::uint32_t ping) const;

 private:
  FrameMaker(const FigureJob& job, const FigureOptions& options)
      : job_(job), options_(options), drawn_(job.chosen) {}
  Status read_axes();
  Status read_times();
  void set_scale(const StoredPixels& first);
  void leave_out_wide(const StoredPixels& first);
  void set_legend(const StoredPixels& first);
  Result<StoredPixels> pixels_of(std::uint32_t ping) const;
  RgbImage paint(const StoredPixels& pixels) const;
  std::string title_of(std::uint32_t ping) const;

  const FigureJob& job_;
  const FigureOptions& options_;
  std::vector<bool> drawn_;  // [id]: has an outline or a mask
  Surroundings around_;
  Layout layout_;
  std::vector<Cell> cells_;
  std::vector<double> times_s_;  // from the job's first ping on
};

}  // namespace ensonify
