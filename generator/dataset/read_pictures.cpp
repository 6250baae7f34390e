#include "dataset/read_pictures.h"

#include <algorithm>
#include <span>
#include <utility>

#include "dataset/image_exr.h"
#include "dataset/layout.h"
#include "formats/bytes.h"
#include "formats/files.h"
#include "formats/npy.h"
#include "formats/png.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

template <class Value>
std::string bytes_of_values(const std::vector<Value>& values) {
  std::string bytes(values.size() * sizeof(Value), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

template <class Value>
Result<std::string> bytes_of_result(const Result<std::vector<Value>>& values) {
  if (!values) return values.error();
  return bytes_of_values(*values);
}

// Most floats are stored as halves.
template <class Value>
void take_cells(const CatalogueRow& row, std::string_view bytes, std::vector<Value>& values) {
  if (std::is_floating_point_v<Value> && row.type == kNpyFloat32) {
    values = values_in<Value>(bytes);
  } else if constexpr (std::is_floating_point_v<Value>) {
    const auto halves = values_in<std::uint16_t>(bytes);
    values.resize(halves.size());
    from_halves(halves, values);
  } else {
    values = values_in<Value>(bytes);
  }
}

template <class Value>
std::string through_map(std::span<const std::int32_t> map, std::string_view polar_bytes,
                        Value blank) {
  const auto polar = values_in<Value>(polar_bytes);
  std::vector<Value> values(map.size(), blank);
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (map[i] >= 0) values[i] = polar[static_cast<std::size_t>(map[i])];
  }
  return bytes_of_values(values);
}

// The stored plane from which a plane of the other view is made; null if it is not derived.
const CatalogueRow* polar_source(const StoredSequence& sequence, const CatalogueRow& row) {
  if (row.view != ImageView::cartesian || row.plane == nullptr || !is_float_plane(*row.plane)) {
    return nullptr;
  }
  const CatalogueRow& polar = plane_row(ImageView::polar, row.plane->name);
  return sequence.cartesian_height > 0 && sequence.has(polar) ? &polar : nullptr;
}

const CatalogueRow* series_row_of(const StoredSequence& sequence) {
  for (const char* file : {layout::kTimeseries, layout::kTimeseriesExr}) {
    const CatalogueRow* row = find_file(FileScope::ping, file);
    if (row != nullptr && sequence.has(*row)) return row;
  }
  return nullptr;
}

}  // namespace

bool can_read(const StoredSequence& sequence, const CatalogueRow& row) {
  return sequence.has(row) || polar_source(sequence, row) != nullptr;
}

CellReader::CellReader(const StoredDataset& dataset, const StoredSequence& sequence,
                       std::uint32_t ping)
    : dataset_(dataset), sequence_(sequence), ping_(ping) {
  ENSONIFY_ASSERT(ping >= sequence.row.first_ping && ping < sequence.row.last_ping);
}

Result<std::string> CellReader::read(const CatalogueRow& row) {
  if (!sequence_.has(row)) return read_through_map(row);
  const GridSizes sizes = sequence_.sizes();
  const NpyShape shape = grid_shape(row, sizes);
  const std::uint32_t number = sequence_.row.sequence;
  if (sequence_.has_array(row.array)) {
    const auto path = stored_file(dataset_, number, row.array);
    if (!path) return path.error();
    return read_npy_row(*path, row.type, array_shape(row, sizes), ping_ - sequence_.row.first_ping);
  }
  const auto path = ping_file(dataset_, number, row.file, ping_);
  if (!path) return path.error();
  if (row.codec == FileCodec::png) {
    if (row.grid == FileGrid::camera_color) {
      return bytes_of_result(read_rgb8(*path, shape[0], shape[1]));
    }
    return row.type == kNpyUint8 ? bytes_of_result(read_grey8(*path, shape[0], shape[1]))
                                 : bytes_of_result(read_grey16(*path, shape[0], shape[1]));
  }
  if (row.codec == FileCodec::group_exr) {
    const auto read = [&](const fs::path& file, int rows, int columns) {
      return read_group_exr(file, row.plane->group(), rows, columns);
    };
    return read_exr_plane(row, *path, read, floats_);
  }
  std::error_code error;
  if (row.codec == FileCodec::front_exr) {
    // Deflate packs at most 1,032 bytes into one.
    const std::uint64_t bytes = packed_bytes(row, sizes) * front_exr_channels().size();
    if (fs::file_size(*path, error) < bytes / 1032 || error) {
      return damaged(*path, "is cut off");
    }
    return read_exr_plane(row, *path, read_front_exr, floats_);
  }
  if (row.codec == FileCodec::camera_exr) {
    const std::string_view of = row.camera_plane->file;
    const std::uint64_t bytes = packed_bytes(row, sizes) * camera_exr_channels(of).size();
    if (fs::file_size(*path, error) < bytes / 1032 || error) return damaged(*path, "is cut off");
    const auto read = [&](const fs::path& file, int rows, int columns) {
      return read_camera_exr(file, of, rows, columns);
    };
    return read_exr_plane(row, *path, read, floats_);
  }
  // Levels and time series are uncompressed, so a shorter file is rejected before allocating
  // memory.
  if (fs::file_size(*path, error) < packed_bytes(row, sizes) || error) {
    return damaged(*path, "is cut off");
  }
  if (row.codec == FileCodec::exr) {
    const bool labels = sequence_.manifest.info.output.labels;
    return read_exr_plane(row, *path, labels ? read_exr_halves : read_exr_level, images_);
  }
  if (row.codec == FileCodec::series_exr) {
    return bytes_of_result(
        read_series_exr(*path, static_cast<int>(shape[1]), static_cast<int>(shape[0])));
  }
  const auto array = read_npy(*path, row.type, shape);
  if (!array) return array.error();
  return std::string(array->data());
}

template <class Planes, class Read>
Result<std::string> CellReader::read_exr_plane(const CatalogueRow& row, const fs::path& path,
                                               Read read_planes,
                                               std::map<std::string, Planes>& images) {
  const NpyShape shape = grid_shape(row, sequence_.sizes());
  const auto [image, is_new] = images.try_emplace(row.file);
  if (is_new) {
    auto planes = read_planes(path, static_cast<int>(shape[0]), static_cast<int>(shape[1]));
    if (!planes) return planes.error();
    image->second = std::move(*planes);
  }
  const auto values = image->second.find(plane_facts(row).name);
  ENSONIFY_ASSERT(values != image->second.end());
  return bytes_of_values(values->second);
}

Result<std::string> CellReader::read_through_map(const CatalogueRow& row) {
  const CatalogueRow* source = polar_source(sequence_, row);
  ENSONIFY_ASSERT(source != nullptr);
  if (map_.empty()) {
    auto map = read_cartesian_map(dataset_, sequence_);
    if (!map) return map.error();
    map_ = std::move(*map);
  }
  const Result<std::string> bytes = read(*source);
  if (!bytes) return bytes.error();
  const float blank = blank_value<float>(row.plane->blank);
  if (row.type == kNpyFloat32) return through_map(map_, *bytes, blank);
  std::uint16_t blank_half = 0;
  to_halves({&blank, 1}, {&blank_half, 1});
  return through_map(map_, *bytes, blank_half);
}

Result<std::vector<std::int32_t>> read_cartesian_map(const StoredDataset& dataset,
                                                     const StoredSequence& sequence) {
  const auto path = stored_file(dataset, sequence.row.sequence, layout::kCartesianMap);
  if (!path) return path.error();
  const auto array =
      read_npy(*path, kNpyInt32, {sequence.cartesian_height, sequence.cartesian_width});
  if (!array) return array.error();
  auto map = values_in<std::int32_t>(array->data());
  const std::uint64_t pixels = sequence.beams * sequence.samples;
  const bool fits = std::all_of(map.begin(), map.end(), [&](std::int32_t from) {
    return from < 0 || static_cast<std::uint64_t>(from) < pixels;
  });
  if (!fits) return damaged(*path, "refers to pixels that the polar image does not have");
  return map;
}

PlaneNames stored_planes(const StoredSequence& sequence, ImageView view) {
  PlaneNames names;
  for (const ImagePlane& plane : kImagePlanes) {
    if (can_read(sequence, plane_row(view, plane.name))) names.insert(plane.name);
  }
  return names;
}

Result<StoredPixels> read_picture(const StoredDataset& dataset, const StoredSequence& sequence,
                                  ImageView view, std::uint32_t ping, const PlaneNames& planes) {
  CellReader reader(dataset, sequence, ping);
  const NpyShape shape = grid_shape(plane_row(view, "level_db"), sequence.sizes());
  StoredPixels pixels;
  pixels.rows = shape[0];
  pixels.columns = shape[1];
  if (pixels.rows == 0 || pixels.columns == 0) return pixels;
  for (const ImagePlane& plane : kImagePlanes) {
    const CatalogueRow& row = plane_row(view, plane.name);
    if (!planes.contains(plane.name) || !can_read(sequence, row)) continue;
    const auto bytes = reader.read(row);
    if (!bytes) return bytes.error();
    with_plane(pixels, plane, [&](auto& values) { take_cells(row, *bytes, values); });
  }
  return pixels;
}

bool has_series(const StoredSequence& sequence) { return series_row_of(sequence) != nullptr; }

Result<std::vector<std::complex<float>>> read_series(const StoredDataset& dataset,
                                                     const StoredSequence& sequence,
                                                     std::uint32_t ping) {
  CellReader reader(dataset, sequence, ping);
  const CatalogueRow* row = series_row_of(sequence);
  if (row == nullptr) return std::vector<std::complex<float>>{};
  const auto bytes = reader.read(*row);
  if (!bytes) return bytes.error();
  return values_in<std::complex<float>>(*bytes);
}

}  // namespace ensonify
