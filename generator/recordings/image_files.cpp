#include "recordings/image_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "core/units.h"
#include "formats/bytes.h"
#include "formats/files.h"
#include "formats/jpeg.h"
#include "formats/npy.h"
#include "formats/png.h"
#include "recordings/log.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMostImageBytes = std::uint64_t{1} << 28;

template <class T>
std::string bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

Error wrong_image(const fs::path& path, const std::string& what) {
  return {ErrorKind::usage, path.string() + ": " + what};
}

Result<std::string> image_bytes(const fs::path& path) {
  std::error_code error;
  if (fs::file_size(path, error) > kMostImageBytes || error) {
    return wrong_image(path, "is missing or larger than 256 MiB");
  }
  return read_file(path);
}

// Brightness from 0 to 255, row-major.
struct Brightness {
  int rows = 0, columns = 0;
  std::vector<float> values;

  double at(int row, int column) const {
    return static_cast<double>(
        values[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
               static_cast<std::size_t>(column)]);
  }
};

Result<Brightness> read_brightness(const fs::path& path) {
  const auto bytes = image_bytes(path);
  if (!bytes) return bytes.error();
  if (parse_png_header(*bytes)) {
    auto png = parse_bright_png(*bytes);
    if (!png) return wrong_image(path, png.error().message);
    for (float& value : png->brightness) value *= 255;
    return Brightness{static_cast<int>(png->rows), static_cast<int>(png->columns),
                      std::move(png->brightness)};
  }
  if (!bytes->starts_with("\xff\xd8")) return wrong_image(path, "neither a PNG nor a JPEG file");
  const auto jpeg = parse_grey_jpeg(*bytes);
  if (!jpeg) return wrong_image(path, jpeg.error().message);
  return Brightness{static_cast<int>(jpeg->rows),
                    static_cast<int>(jpeg->columns),
                    {jpeg->grey.begin(), jpeg->grey.end()}};
}

// Column and row of a cell, from the middle of the first pixel.
std::array<double, 2> place_of(const FanDisplay& display, double range_m, double azimuth_rad) {
  const double ahead = range_m * display.pixels_per_m * std::cos(azimuth_rad);
  const double starboard =
      range_m * display.pixels_per_m * std::sin(azimuth_rad) * (display.mirrored ? 1 : -1);
  constexpr double kAhead[][2] = {{0, -1}, {1, 0}, {0, 1}, {-1, 0}};
  const auto [x, y] = kAhead[static_cast<int>(display.look)];
  return {display.apex_column + ahead * x - starboard * y - 0.5,
          display.apex_row + ahead * y + starboard * x - 0.5};
}

// The place must be at most half a pixel outside of the outer middles.
double interpolated(const Brightness& image, double column, double row) {
  const auto split = [](double place, int size) {
    const double inside = std::clamp(place, 0.0, size - 1.0);
    const int first = std::min(static_cast<int>(inside), std::max(0, size - 2));
    return std::pair(first, inside - first);
  };
  const auto [c, across] = split(column, image.columns);
  const auto [r, down] = split(row, image.rows);
  const int next_c = std::min(c + 1, image.columns - 1), next_r = std::min(r + 1, image.rows - 1);
  const double upper = (1 - across) * image.at(r, c) + across * image.at(r, next_c);
  const double lower = (1 - across) * image.at(next_r, c) + across * image.at(next_r, next_c);
  return (1 - down) * upper + down * lower;
}

}  // namespace

Result<LogImage> read_log_image(const fs::path& path) {
  const auto bytes = image_bytes(path);
  if (!bytes) return bytes.error();
  if (parse_png_header(*bytes)) {
    const auto png = parse_grey_png(*bytes);
    if (!png) return wrong_image(path, png.error().message);
    const bool words = !png->grey16.empty();
    return LogImage{png->rows, png->columns, words ? 16 : 8,
                    words ? bytes_of(png->grey16) : bytes_of(png->grey8)};
  }
  const auto header = parse_npy_header(*bytes);
  if (!header) return wrong_image(path, "neither a grayscale PNG nor an NPY file");
  const bool is_bytes = header->descr == kNpyUint8, words = header->descr == kNpyUint16;
  if ((!is_bytes && !words) || header->fortran_order || header->shape.size() != 2) {
    return wrong_image(
        path, "an array of another kind; expected uint8 or uint16 [rows, columns] in C order");
  }
  const std::uint64_t rows = header->shape[0], columns = header->shape[1];
  const std::string_view data =
      std::string_view(*bytes).substr(std::min<std::uint64_t>(header->data_offset, bytes->size()));
  if (rows > kMostLogSamples || columns > kMostLogBeams ||
      data.size() != rows * columns * (words ? 2 : 1)) {
    return wrong_image(path, "does not have the length that its header gives");
  }
  return LogImage{rows, columns, words ? 16 : 8, std::string(data)};
}

Result<LogImage> read_display(const fs::path& path, const FanDisplay& display,
                              std::span<const double> range_m,
                              std::span<const double> azimuth_rad) {
  const auto image = read_brightness(path);
  if (!image) return image.error();
  LogImage polar{range_m.size(), azimuth_rad.size(), 8, {}};
  polar.counts.reserve(range_m.size() * azimuth_rad.size());
  for (const double range : range_m) {
    for (const double azimuth : azimuth_rad) {
      const auto [column, row] = place_of(display, range, azimuth);
      if (!(column >= -0.5 && column <= image->columns - 0.5 && row >= -0.5 &&
            row <= image->rows - 0.5)) {
        return wrong_image(
            path,
            fmt::format("{} x {} pixels; range {:.4g} m at azimuth {:.4g} degrees would be at "
                        "column {:.1f}, row {:.1f} of it; expected another display.apex_px, "
                        "display.pixels_per_m, range_m or fan",
                        image->columns, image->rows, range, degrees(azimuth), column + 0.5,
                        row + 0.5));
      }
      polar.counts.push_back(static_cast<char>(
          static_cast<std::uint8_t>(std::lround(interpolated(*image, column, row)))));
    }
  }
  return polar;
}

}  // namespace ensonify
