#include "world/grid_file.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>

#include "scenario/text.h"

namespace ensonify {
namespace {

// 64 million numbers of 32 characters.
constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{1} << 31;

Result<std::string> read_bytes(const std::filesystem::path& file) {
  std::error_code failed;
  const std::uintmax_t size = std::filesystem::file_size(file, failed);
  if (failed) return Error{ErrorKind::io, "cannot be read: " + failed.message()};
  if (size > kMaxFileBytes) {
    return Error{ErrorKind::usage, "is larger than 2 GiB; thin it out or cut it into several"};
  }
  std::string bytes(size, '\0');
  std::ifstream stream(file, std::ios::binary);
  if (!stream.read(bytes.data(), static_cast<std::streamsize>(size))) {
    return Error{ErrorKind::io, fmt::format("cannot be read: {}", std::strerror(errno))};
  }
  return bytes;
}

Result<GridFile> parse(const std::string& extension, std::string_view bytes) {
  if (equals_ignoring_case(extension, ".npy")) return parse_npy_grid(bytes);
  if (equals_ignoring_case(extension, ".png")) return parse_png_grid(bytes);
  if (equals_ignoring_case(extension, ".asc")) return parse_asc_grid(bytes);
  return Error{ErrorKind::usage, "has another ending, accepted are .npy, .png, .asc"};
}

}  // namespace

Status check_grid_size(std::int64_t rows, std::int64_t columns) {
  if (rows >= 2 && columns >= 2 && rows <= kMaxGridCells / columns) return {};
  return Error{ErrorKind::usage,
               fmt::format("holds {} rows of {} numbers, accepted are two of two at least and {} "
                           "numbers in all",
                           rows, columns, kMaxGridCells)};
}

Result<GridFile> load_grid_file(const std::filesystem::path& file) {
  const auto named = [&](const Error& error) {
    return Error{error.kind, file.string() + ": " + error.message};
  };
  const Result<std::string> bytes = read_bytes(file);
  if (!bytes) return named(bytes.error());
  Result<GridFile> grid = parse(file.extension().string(), *bytes);
  if (!grid) return named(grid.error());
  return grid;
}

}  // namespace ensonify
