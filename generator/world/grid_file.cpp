#include "world/grid_file.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <system_error>

#include <fmt/format.h>

#include "formats/bytes.h"
#include "formats/npy.h"
#include "formats/png.h"
#include "scenario/text.h"

namespace ensonify {
namespace {

Error wrong(const std::string& why) { return {ErrorKind::usage, why}; }

template <class T>
double number_at(std::string_view bytes, bool swapped) {
  std::string local(bytes.substr(0, sizeof(T)));
  if (swapped) std::reverse(local.begin(), local.end());
  return static_cast<double>(value_at<T>(local, 0));
}

struct NumberType {
  std::string_view name;
  std::size_t bytes;
  double (*at)(std::string_view, bool);
};
constexpr NumberType kTypes[] = {
    {"f4", 4, number_at<float>},        {"f8", 8, number_at<double>},
    {"i1", 1, number_at<std::int8_t>},  {"u1", 1, number_at<std::uint8_t>},
    {"i2", 2, number_at<std::int16_t>}, {"u2", 2, number_at<std::uint16_t>},
    {"i4", 4, number_at<std::int32_t>}, {"u4", 4, number_at<std::uint32_t>},
    {"i8", 8, number_at<std::int64_t>}, {"u8", 8, number_at<std::uint64_t>},
};

const NumberType* type_of(std::string_view name) {
  if (name.size() != 3 || std::string_view("<>|=").find(name[0]) == std::string_view::npos) {
    return nullptr;
  }
  for (const NumberType& type : kTypes) {
    if (type.name == name.substr(1) && (name[0] != '|' || type.bytes == 1)) return &type;
  }
  return nullptr;
}

}  // namespace

Result<GridFile> parse_npy_grid(std::string_view bytes) {
  const auto header = parse_npy_header(bytes);
  if (!header) return header.error();
  if (header->descr.starts_with('[')) {
    return wrong("is not an NPY file of plain numbers: its header cannot be read");
  }
  const std::string name = header->descr.substr(1, header->descr.size() - 2);
  const NumberType* type = type_of(name);
  if (type == nullptr) {
    return wrong(fmt::format("holds numbers of type {}; expected f4, f8, i1 to i8 or u1 to u8",
                             shown(name)));
  }
  if (header->shape.size() != 2) {
    return wrong(
        fmt::format("has {} dimensions; expected 2: rows from north to south, "
                    "columns from west to east",
                    header->shape.size()));
  }
  const auto rows = static_cast<std::int64_t>(header->shape[0]);
  const auto columns = static_cast<std::int64_t>(header->shape[1]);
  if (Status size = check_grid_size(rows, columns); !size) return size.error();
  const std::string_view data = bytes.substr(header->data_offset);
  const std::size_t count = header->shape[0] * header->shape[1];
  if (data.size() != count * type->bytes) {
    return wrong(
        fmt::format("holds {} bytes of numbers, but {} x {} of them take {}; it is cut "
                    "off or holds more than one array",
                    data.size(), rows, columns, count * type->bytes));
  }
  GridFile grid;
  grid.rows = static_cast<int>(rows);
  grid.columns = static_cast<int>(columns);
  grid.values.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at =
        header->fortran_order ? i % header->shape[1] * header->shape[0] + i / header->shape[1] : i;
    grid.values[i] = type->at(data.substr(at * type->bytes), name[0] == '>');
  }
  return grid;
}

Result<GridFile> parse_png_grid(std::string_view bytes) {
  // The size is checked before memory is allocated for the pixels.
  if (const auto header = parse_png_header(bytes)) {
    if (header->color_type != 0 || header->bit_depth < 8) {
      return Error{ErrorKind::usage,
                   fmt::format("is a PNG file of {} bits and color type {}; expected a grayscale "
                               "image (color type 0) of 8 or 16 bits",
                               header->bit_depth, header->color_type)};
    }
    if (Status size = check_grid_size(header->height, header->width); !size) return size.error();
  }
  const auto image = parse_grey_png(bytes);
  if (!image) return image.error();
  GridFile grid;
  grid.rows = static_cast<int>(image->rows);
  grid.columns = static_cast<int>(image->columns);
  grid.white = image->grey16.empty() ? 255 : 65535;
  grid.values.assign(image->grey8.begin(), image->grey8.end());
  if (grid.values.empty()) grid.values.assign(image->grey16.begin(), image->grey16.end());
  return grid;
}

namespace {

// 64 million numbers of 32 characters.
constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{1} << 31;

Result<GridFile> parse(const std::string& extension, std::string_view bytes) {
  if (equals_ignoring_case(extension, ".npy")) return parse_npy_grid(bytes);
  if (equals_ignoring_case(extension, ".png")) return parse_png_grid(bytes);
  if (equals_ignoring_case(extension, ".asc")) return parse_asc_grid(bytes);
  return Error{ErrorKind::usage, "has an unknown extension; expected .npy, .png or .asc"};
}

}  // namespace

Result<std::string> read_grid_bytes(const std::filesystem::path& file) {
  std::error_code failed;
  const std::uintmax_t size = std::filesystem::file_size(file, failed);
  if (failed) return Error{ErrorKind::io, "cannot be read: " + failed.message()};
  if (size > kMaxFileBytes) {
    return Error{ErrorKind::usage,
                 "is larger than 2 GiB; thin it out or split it into several files"};
  }
  std::string bytes(size, '\0');
  std::ifstream stream(file, std::ios::binary);
  if (!stream.read(bytes.data(), static_cast<std::streamsize>(size))) {
    return Error{ErrorKind::io, fmt::format("cannot be read: {}", std::strerror(errno))};
  }
  return bytes;
}

Status check_grid_size(std::int64_t rows, std::int64_t columns) {
  if (rows >= 2 && columns >= 2 && rows <= kMaxGridCells / columns) return {};
  return Error{ErrorKind::usage,
               fmt::format("holds {} rows of {} numbers; expected at least 2 rows of 2 and at most "
                           "{} numbers in all",
                           rows, columns, kMaxGridCells)};
}

Result<GridFile> load_grid_file(const std::filesystem::path& file) {
  const auto named = [&](const Error& error) {
    return Error{error.kind, file.string() + ": " + error.message};
  };
  const Result<std::string> bytes = read_grid_bytes(file);
  if (!bytes) return named(bytes.error());
  Result<GridFile> grid = parse(file.extension().string(), *bytes);
  if (!grid) return named(grid.error());
  return grid;
}

namespace {

// Splits a text into words; a word ends at a blank or line end.
struct Words {
  std::string_view text;
  std::size_t at = 0;
  std::size_t word_start = 0;

  static bool is_blank(char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r'; }
  std::string_view next() {
    while (at < text.size() && is_blank(text[at])) ++at;
    word_start = at;
    while (at < text.size() && !is_blank(text[at])) ++at;
    return text.substr(word_start, at - word_start);
  }
  Error wrong(const std::string& why) const {
    const auto line = 1 + std::count(text.begin(), text.begin() + word_start, '\n');
    return {ErrorKind::usage, fmt::format("line {}: {}", line, why)};
  }
};

bool read_number(std::string_view word, double& out) {
  const char* end = word.data() + word.size();
  const auto [stop, failed] = std::from_chars(word.data(), end, out);
  return failed == std::errc{} && stop == end && !word.empty();
}

using Head = std::map<std::string, double>;

const std::vector<std::string_view> kHeadWords = {"ncols",     "nrows",       "xllcorner",
                                                  "xllcenter", "yllcorner",   "yllcenter",
                                                  "cellsize",  "nodata_value"};

// Reads the lines with a name and a number; stops before the first height.
Status read_head(Words& words, Head& head) {
  for (;;) {
    const Words before = words;
    const std::string_view name = words.next();
    double ignored = 0;
    if (name.empty() || read_number(name, ignored)) {
      words = before;
      return {};
    }
    const auto known =
        std::find_if(kHeadWords.begin(), kHeadWords.end(),
                     [&](std::string_view word) { return equals_ignoring_case(name, word); });
    if (known == kHeadWords.end()) {
      return words.wrong(
          fmt::format("unknown key {}{}; expected one of {}", shown(name), hint(name, kHeadWords),
                      joined(kHeadWords)));
    }
    double value = 0;
    if (!read_number(words.next(), value)) {
      return words.wrong(fmt::format("{} is not followed by a number", *known));
    }
    if (!head.emplace(*known, value).second) {
      return words.wrong(fmt::format("{} is given twice", *known));
    }
  }
}

Status check_head(const Head& head) {
  for (const char* needed : {"ncols", "nrows", "cellsize"}) {
    if (!head.contains(needed)) {
      return Error{ErrorKind::usage,
                   fmt::format("is not an ESRI ASCII grid: {} is missing", needed)};
    }
  }
  for (const char* count : {"ncols", "nrows"}) {
    const double value = head.at(count);
    if (value == std::floor(value) && value >= 2 && value <= kMaxGridCells) continue;
    return Error{ErrorKind::usage, fmt::format("{} is {}; expected a whole number from 2 to {}",
                                               count, value, kMaxGridCells)};
  }
  const double cell = head.at("cellsize");
  if (cell > 0 && cell <= 1e7) return {};
  return Error{ErrorKind::usage,
               fmt::format("cellsize is {}; expected a number above 0 and at most 1e7", cell)};
}

}  // namespace

Result<GridFile> parse_asc_grid(std::string_view bytes) {
  Words words{bytes};
  Head head;
  if (Status read = read_head(words, head); !read) return read.error();
  if (Status sound = check_head(head); !sound) return sound.error();
  const auto rows = static_cast<std::int64_t>(head["nrows"]);
  const auto columns = static_cast<std::int64_t>(head["ncols"]);
  if (Status size = check_grid_size(rows, columns); !size) return size.error();
  const std::size_t count = std::size_t(rows) * columns;
  if (bytes.size() - words.at < 2 * count - 1) {
    return Error{ErrorKind::usage, fmt::format("is too short for {} rows of {} heights: it is cut "
                                               "off",
                                               rows, columns)};
  }
  const double no_data = head.contains("nodata_value") ? head["nodata_value"] : -9999;
  GridFile grid{static_cast<int>(rows), static_cast<int>(columns), {}, 0, head["cellsize"]};
  grid.values.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::string_view word = words.next();
    double value = 0;
    if (!read_number(word, value)) {
      return words.wrong(fmt::format("found {} for height {} of {}; expected a number",
                                     word.empty() ? "nothing" : shown(word), i + 1, count));
    }
    grid.values.push_back(value == no_data ? std::numeric_limits<double>::quiet_NaN() : value);
  }
  if (!words.next().empty()) {
    return words.wrong(fmt::format("holds more than {} rows of {} heights", rows, columns));
  }
  return grid;
}

}  // namespace ensonify
