#include "dataset/verify_parts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <fstream>

#include "core/counted.h"
#include "dataset/geometry_files.h"
#include "dataset/image_exr.h"
#include "dataset/layout.h"
#include "dataset/schema.h"
#include "formats/bytes.h"
#include "formats/csv.h"
#include "formats/npy.h"
#include "formats/png.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

// Large enough for every checked header.
constexpr std::size_t kNpyHeaderBytes = 4096;

std::string start_of(const fs::path& path) {
  std::string bytes(kNpyHeaderBytes, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
  return bytes;
}

// The shape {0} stands for any length.
std::string npy_fault(const fs::path& path, std::string_view descr, const NpyShape& shape) {
  const auto header = parse_npy_header(start_of(path));
  if (!header) return "is not an NPY file as ensonify writes it";
  if (header->descr != descr) return fmt::format("has dtype {}, not {}", header->descr, descr);
  const bool any_length = shape == NpyShape{0} && header->shape.size() == 1;
  if (header->fortran_order || (!any_length && header->shape != shape)) {
    return fmt::format("has shape ({}), not ({})", fmt::join(header->shape, ", "),
                       fmt::join(shape, ", "));
  }
  std::uint64_t size = npy_item_bytes(descr).value_or(0);
  for (const std::uint64_t n : header->shape) size *= n;
  std::error_code error;
  if (fs::file_size(path, error) != header->data_offset + size) {
    return "does not have the length that its header gives";
  }
  return {};
}

std::string map_fault(const fs::path& path, const NpyShape& shape, std::uint64_t polar_pixels) {
  const auto map = read_npy(path, kNpyInt32, shape);
  if (!map) return map.error().message;
  for (const auto from : values_in<std::int32_t>(map->data())) {
    if (from >= -1 && (from < 0 || static_cast<std::uint64_t>(from) < polar_pixels)) continue;
    return fmt::format("refers to the polar pixel {}; expected -1 or a number from 0 to {}", from,
                       polar_pixels - 1);
  }
  return {};
}

std::string png_fault(const fs::path& path, std::uint64_t rows, std::uint64_t columns, int bits,
                      bool is_color) {
  const auto header = parse_png_header(start_of(path));
  if (!header) return "is not a PNG file";
  if (header->height == rows && header->width == columns && header->bit_depth == bits &&
      header->color_type == (is_color ? 2 : 0)) {
    return {};
  }
  return fmt::format("has {} x {} pixels of {} bits, not {} x {} {} pixels of {}", header->width,
                     header->height, header->bit_depth, columns, rows,
                     is_color ? "color" : "grayscale", bits);
}

// A recording has the level alone.
std::string exr_fault(const fs::path& path, const NpyShape& shape, bool with_labels) {
  const auto parts = read_exr_parts(path);
  if (!parts) return "cannot be read as EXR: " + parts.error().message;
  const std::vector<std::string> labels = exr_channels("");
  if (parts->size() != (with_labels ? 2 : 1) || (*parts)[0].name != "level" ||
      (*parts).back().name != (with_labels ? "labels" : "level")) {
    return with_labels ? "does not have the parts level and labels, in this order"
                       : "does not have the part level alone";
  }
  if ((*parts)[0].half_channels != std::vector<std::string>{kExrLevelChannel} ||
      (with_labels && (*parts)[1].half_channels != labels)) {
    return "does not have the channels Y, and " + fmt::format("{}", fmt::join(labels, ", "));
  }
  for (const ExrPart& part : *parts) {
    if (!part.other_channels.empty() || !part.float_channels.empty()) {
      return "has channels that are not half";
    }
    if (std::cmp_not_equal(part.height, shape[0]) || std::cmp_not_equal(part.width, shape[1])) {
      return fmt::format("has {} x {} pixels, not {} x {}", part.width, part.height, shape[1],
                         shape[0]);
    }
  }
  return {};
}

// A file with one part and these float channels.
std::string floats_exr_fault(const fs::path& path, std::uint64_t rows, std::uint64_t columns,
                             const std::vector<std::string>& channels) {
  const auto parts = read_exr_parts(path);
  if (!parts) return "cannot be read as EXR: " + parts.error().message;
  if (parts->size() != 1) return fmt::format("has {} parts, not 1", parts->size());
  const ExrPart& part = parts->front();
  if (part.float_channels != channels || !part.half_channels.empty() ||
      !part.other_channels.empty()) {
    return fmt::format("does not have exactly the float channels {}", fmt::join(channels, ", "));
  }
  if (std::cmp_equal(part.height, rows) && std::cmp_equal(part.width, columns)) return {};
  return fmt::format("has {} x {} pixels, not {} x {}", part.width, part.height, columns, rows);
}

// Calls use(row) for every line after the header; a fault is a header or row that does not match
// tables.json, a row that `use` refuses, or another number of rows.
template <class Use>
std::string rows_fault(const fs::path& path, std::uint64_t expected, Use use) {
  const auto table = table_schema(path.filename().string());
  std::ifstream file(path, std::ios::binary);
  std::string line;
  if (table) {
    std::getline(file, line);
    if (std::string fault = header_fault(*table, line); !fault.empty()) return fault;
  }
  std::uint64_t rows = 0;
  while (std::getline(file, line)) {
    if (++rows > expected) continue;
    const std::string fault = table ? row_fault(*table, line) : "";
    if (!fault.empty()) return fmt::format("row {}: {}", rows, fault);
    if (!use(line)) return fmt::format("has an invalid row: {}", line);
  }
  if (rows != expected) return fmt::format("has {}, not {}", counted(rows, "row"), expected);
  return {};
}

bool are_numbers(const std::vector<std::string_view>& columns, std::size_t count) {
  return columns.size() == count &&
         std::all_of(columns.begin(), columns.end(), parse_number<double>);
}

std::string poses_fault(const fs::path& path, const SequenceShape& shape) {
  std::uint64_t ping = shape.first_ping;
  return rows_fault(path, shape.pings(), [&](const std::string& line) {
    return columns_of(line, ',')[0] == std::to_string(ping++);
  });
}

std::string tum_fault(const fs::path& path, const SequenceShape& shape) {
  return rows_fault(path, shape.pings(),
                    [](const std::string& line) { return are_numbers(columns_of(line, ' '), 8); });
}

std::string objects_fault(const fs::path& path, const SequenceShape& shape) {
  std::ifstream file(path, std::ios::binary);
  std::uint64_t lines = 0;
  for (std::string line; std::getline(file, line);) ++lines;
  const std::uint64_t rows = lines > 0 ? lines - 1 : 0;
  if (rows > shape.pings() * shape.instances || (shape.pings() > 0 && rows % shape.pings() != 0)) {
    return fmt::format("has {} for {} and {}", counted(rows, "row"), counted(shape.pings(), "ping"),
                       counted(shape.instances, "instance"));
  }
  return rows_fault(path, rows, [](const std::string&) { return true; });
}

std::string boxes_fault(const fs::path& path, const SequenceShape& shape) {
  return rows_fault(path, shape.pings() * shape.boxes, [](const std::string&) { return true; });
}

std::string annotations_fault(const fs::path& path, const SequenceShape& shape) {
  const SchemaCheck schema("annotations");
  std::ifstream file(path, std::ios::binary);
  std::uint64_t ping = shape.first_ping;
  for (std::string line; std::getline(file, line); ++ping) {
    const auto json = parse_json(line);
    std::string fault = json ? schema.fault(*json) : "is not JSON";
    if (fault.empty()) fault = line_masks_fault(*json);
    if (!fault.empty()) return fmt::format("line {}: {}", ping - shape.first_ping + 1, fault);
    if (count_at(*json, "ping") != ping) break;
  }
  if (file.eof() && ping == shape.last_ping) return {};
  return "does not have one line per ping, in order";
}

// The head of an OpenVDB file, its random tag set to zeros.
std::string vdb_fault(const fs::path& path) {
  constexpr std::string_view kMagic(" BDV\0\0\0\0", 8);
  const std::string head = start_of(path);
  if (!head.starts_with(kMagic)) return "is not an OpenVDB file";
  if (head.find("00000000-0000-0000-0000-000000000000") != 21) {
    return "is not an OpenVDB file as ensonify writes it";
  }
  return {};
}

using TableCheck = std::string (*)(const fs::path& path, const SequenceShape&);
constexpr std::pair<std::string_view, TableCheck> kTableChecks[] = {
    {"poses.csv", poses_fault},
    {"poses.tum", tum_fault},
    {"objects.csv", objects_fault},
    {"boxes.csv", boxes_fault},
    {layout::kAnnotations, annotations_fault}};

std::string file_fault(const fs::path& path, const CatalogueRow& row, const SequenceShape& shape) {
  const NpyShape grid = grid_shape(row, shape.sizes);
  switch (row.codec) {
    case FileCodec::npy:
      if (std::string fault = npy_fault(path, row.type, grid); !fault.empty()) return fault;
      if (row.file != layout::kCartesianMap) return {};
      return map_fault(path, grid, shape.sizes.beams * shape.sizes.samples);
    case FileCodec::png:
      return png_fault(path, grid[0], grid[1], row.type == kNpyUint8 ? 8 : 16,
                       row.grid == FileGrid::camera_color);
    case FileCodec::exr:
      return exr_fault(path, grid, shape.labels);
    case FileCodec::group_exr:
      return floats_exr_fault(path, grid[0], grid[1], exr_channels(row.plane->group()));
    case FileCodec::front_exr:
      return floats_exr_fault(path, grid[0], grid[1], front_exr_channels());
    case FileCodec::camera_exr:
      return floats_exr_fault(path, grid[0], grid[1], camera_exr_channels(row.camera_plane->file));
    case FileCodec::series_exr:
      return floats_exr_fault(path, grid[1], grid[0], {"p.im", "p.re"});
    case FileCodec::ply:
      return ply_fault(path);
    case FileCodec::mesh_ply:
      return mesh_ply_fault(path);
    case FileCodec::glb:
      return glb_fault(path);
    case FileCodec::vdb:
      return vdb_fault(path);
    default:
      break;
  }
  for (const auto& [name, check] : kTableChecks) {
    if (name == row.file) return check(path, shape);
  }
  return {};
}

}  // namespace

std::string content_fault(const fs::path& dir, const std::string& relative, std::uint64_t bytes,
                          const std::string& sha256) {
  if (!is_safe_relative_path(relative))
    return "is listed, but is not a path inside the folder; not followed";
  const auto size = listed_file_size(dir, relative);
  if (!size) {
    std::error_code error;
    const bool there = fs::exists(fs::symlink_status(dir / relative, error));
    return there ? "is a link or not a file; not followed" : "is missing";
  }
  if (*size != bytes) return fmt::format("has {}, not {}", counted(*size, "byte"), bytes);
  const auto hash = sha256_of_file(dir / relative);
  if (!hash) return hash.error().message;
  return *hash == sha256 ? "" : "does not have the listed SHA-256";
}

std::string format_fault(const fs::path& dir, const SequenceShape& shape, const std::string& name,
                         const std::string& name_template) {
  const fs::path path = dir / layout::in_sequence(shape.sequence, name);
  if (const CatalogueRow* row = find_array(name_template)) {
    return npy_fault(path, row->type, array_shape(*row, shape.sizes));
  }
  for (const FileScope scope : {FileScope::ping, FileScope::sequence}) {
    if (const CatalogueRow* row = find_file(scope, name_template)) {
      return file_fault(path, *row, shape);
    }
  }
  return {};
}

std::string index_fault(const fs::path& path, const std::vector<SequenceShape>& shapes) {
  std::uint64_t rows = 0;
  for (const SequenceShape& shape : shapes) rows += shape.pings();
  auto shape = shapes.begin();
  std::uint64_t done = 0;  // pings of this sequence
  return rows_fault(path, rows, [&](const std::string& line) {
    for (; done == shape->pings(); done = 0) ++shape;
    const auto ping = static_cast<std::uint32_t>(shape->first_ping + done++);
    const auto columns = columns_of(line, ',');
    return columns[0] == std::to_string(shape->sequence) && columns[1] == std::to_string(ping) &&
           columns[3] == shape->split && columns[4] == layout::index_stem(shape->sequence, ping);
  });
}

std::string split_fault(const fs::path& path, const std::string& split,
                        const std::vector<SequenceShape>& shapes) {
  std::uint64_t rows = 0;
  for (const SequenceShape& shape : shapes) rows += shape.split == split ? shape.pings() : 0;
  auto shape = shapes.begin();
  std::uint64_t done = 0;  // pings of this sequence
  return rows_fault(path, rows, [&](const std::string& line) {
    for (; shape->split != split || done == shape->pings(); done = 0) ++shape;
    const auto ping = static_cast<std::uint32_t>(shape->first_ping + done++);
    return line == layout::index_stem(shape->sequence, ping);
  });
}

}  // namespace ensonify
