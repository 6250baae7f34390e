// Frames of a figure, ping by ping.
//
//   FigureView  FigureQuantity  FigureOptions   what the user asks of a figure (figure.h)
//   FigureJob  choose         the content: options checked against the data set
//   is_animated  plane_of  is_mask
//   FrameMaker                draws the frames
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "dataset/read_pictures.h"
#include "figure/compose.h"
#include "figure/drawing.h"

namespace ensonify {

enum class FigureView { cartesian, polar };
enum class FigureQuantity { level, clean, elevation, instance, semantic, shadow, multipath };

// Absent options have the defaults in docs/figures.md.
struct FigureOptions {
  std::filesystem::path dataset;
  std::filesystem::path output;  // its extension names the format: png, svg, webp, mp4
  std::optional<std::uint32_t> sequence;
  std::optional<std::uint32_t> ping;                             // of png and svg
  std::optional<std::pair<std::uint32_t, std::uint32_t>> pings;  // [first, last) of webp and mp4
  std::optional<double> fps;                                     // of webp and mp4
  FigureView view = FigureView::cartesian;
  FigureQuantity quantity = FigureQuantity::level;
  std::optional<std::array<double, 2>> db;  // of level and clean
  std::string colour_map;                   // empty: the quantity's own
  bool bilinear = false;                    // of level and clean
  bool outlines = false;                    // over level, clean and elevation
  std::vector<std::string> instances;       // only these are outlined or have a mask
  std::optional<std::string> title;         // UTF-8; "": none
  int width_px = 0;                         // 0: 1200, animated 800
  bool overwrite = false;
  bool (*stop)() = nullptr;  // called between pings
};

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
