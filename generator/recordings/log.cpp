#include "recordings/log.h"

#include <fmt/format.h>

#include <cerrno>
#include <cmath>
#include <fstream>
#include <memory>

#include "formats/files.h"

namespace ensonify {

LogBytes memory_log(std::string name, std::string_view bytes) {
  return {std::move(name), bytes.size(),
          [bytes](std::uint64_t offset, std::uint64_t count) -> Result<std::string> {
            ENSONIFY_ASSERT(offset <= bytes.size() && count <= bytes.size() - offset);
            return std::string(bytes.substr(offset, count));
          }};
}

Result<LogBytes> file_log(const std::filesystem::path& path) {
  std::error_code code;
  const auto size = std::filesystem::file_size(path, code);
  if (code) return read_error(path, code.value());
  const auto file = std::make_shared<std::ifstream>(path, std::ios::binary);
  if (!*file) return read_error(path, errno != 0 ? errno : EIO);
  return LogBytes{path.filename().string(), size,
                  [file, path](std::uint64_t offset, std::uint64_t count) -> Result<std::string> {
                    std::string bytes(count, '\0');
                    file->seekg(static_cast<std::streamoff>(offset));
                    file->read(bytes.data(), static_cast<std::streamsize>(count));
                    if (!*file) return read_error(path, EIO);
                    return bytes;
                  }};
}

bool same_sequence(const LogSettings& a, const LogSettings& b) {
  const double end = a.samples * a.range_step_m + a.first_range_m;
  const double other = b.samples * b.range_step_m + b.first_range_m;
  const double slack = a.range_step_m / 2;
  return a.instrument == b.instrument && a.mode == b.mode && a.beams == b.beams &&
         a.samples == b.samples && a.bits == b.bits && a.row_gains == b.row_gains && a.db == b.db &&
         a.gamma == b.gamma && a.frequency_hz == b.frequency_hz && a.azimuth_rad == b.azimuth_rad &&
         std::abs(end - other) <= slack && std::abs(a.first_range_m - b.first_range_m) <= slack;
}

Error log_error(const LogBytes& log, std::uint64_t offset, const std::string& what) {
  return {ErrorKind::usage, fmt::format("{}: byte {}: {}", log.name, offset, what)};
}

}  // namespace ensonify
