#include "world/grid_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <system_error>

#include "scenario/text.h"

namespace ensonify {
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
          fmt::format("unknown key {}; expected one of {}", shown(name), joined(kHeadWords)));
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
