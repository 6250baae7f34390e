#include "dataset/catalogue.h"

#include <algorithm>

#include "core/moments.h"

namespace ensonify {
namespace {

template <class Test>
const CatalogueRow* find_row(Test test) {
  const auto rows = catalogue();
  const auto found = std::find_if(rows.begin(), rows.end(), test);
  return found == rows.end() ? nullptr : &*found;
}

}  // namespace

std::span<const CatalogueRow> catalogue() {
  static const std::vector<CatalogueRow> kRows = catalogue_rows();
  return kRows;
}

FileSelection selection_of(const SequenceInfo& info) {
  return {is_sonar(info),
          info.output,
          info.layers,
          info.sdf.has_value(),
          !info.multipath && !info.paths.empty(),
          info.sonar.array.has_value(),
          info.recorder ? info.recorder->bits : 0,
          info.recorder && info.recorder->row_gain_db > 0,
          info.height_map.has_value(),
          info.navigation ? info.navigation->sensors : Navigation{}};
}

PlaneFacts plane_facts(const CatalogueRow& row) {
  const auto facts = [](const auto& plane) {
    return PlaneFacts{plane.name, plane.unit, plane.blank};
  };
  if (row.plane != nullptr) return facts(*row.plane);
  if (row.front_plane != nullptr) return facts(*row.front_plane);
  return row.camera_plane != nullptr ? facts(*row.camera_plane) : PlaneFacts{};
}

bool is_wanted(const CatalogueRow& row, const FileSelection& s) {
  if (row.layer) return std::find(s.layers.begin(), s.layers.end(), *row.layer) != s.layers.end();
  const bool label = row.plane != nullptr && !is_level_plane(*row.plane);
  if (label && !s.output.labels) return false;
  const bool plane =
      row.plane == nullptr || row.plane->wanted == nullptr || s.output.*(row.plane->wanted);
  if (row.camera_plane != nullptr && !(s.output.*row.camera_plane->wanted)) return false;
  return plane && (row.wanted == nullptr || row.wanted(s));
}

bool is_ping_file(const CatalogueRow& row, const FileSelection& s) {
  return row.scope == FileScope::ping && !row.shares_file && is_wanted(row, s) &&
         (!s.output.packed || row.grid == FileGrid::list);
}

bool is_array(const CatalogueRow& row, const FileSelection& s) {
  return s.output.packed && !row.array.empty() && is_wanted(row, s);
}

const CatalogueRow* find_file(FileScope scope, std::string_view file) {
  return find_row([&](const CatalogueRow& row) { return row.scope == scope && row.file == file; });
}

const CatalogueRow* find_array(std::string_view array) {
  if (array.empty()) return nullptr;
  return find_row([&](const CatalogueRow& row) { return row.array == array; });
}

std::vector<const CatalogueRow*> arrays_of(const FileSelection& selection) {
  std::vector<const CatalogueRow*> arrays;
  for (const CatalogueRow& row : catalogue()) {
    if (is_array(row, selection)) arrays.push_back(&row);
  }
  return arrays;
}

const CatalogueRow& plane_row(ImageView view, std::string_view plane) {
  const CatalogueRow* row =
      find_array(std::string(view_name(view)) + "_" + std::string(plane) + ".npy");
  ENSONIFY_ASSERT(row != nullptr);
  return *row;
}

const CatalogueRow& grey_row(ImageView view) { return plane_row(view, "grey"); }

const CatalogueRow* picture_row(ImageView view, const FileSelection& selection) {
  for (const CatalogueRow* row : {&grey_row(view), &plane_row(view, "level_db")}) {
    if (is_wanted(*row, selection)) return row;
  }
  return nullptr;
}

GridSizes sizes_of(const SequenceInfo& info) {
  GridSizes sizes;
  sizes.beams = static_cast<std::uint64_t>(info.sonar.beam_count);
  sizes.samples = static_cast<std::uint64_t>(info.record.samples);
  sizes.elements = info.element_y_m.size();
  if (info.cartesian) {
    sizes.cartesian_height = static_cast<std::uint64_t>(info.cartesian->height_px);
    sizes.cartesian_width = static_cast<std::uint64_t>(info.cartesian->width_px);
  }
  sizes.elevations = static_cast<std::uint64_t>(info.sonar.rays_elevation);
  sizes.azimuths = sizes.beams * static_cast<std::uint64_t>(info.sonar.rays_azimuth);
  if (info.camera) {
    sizes.camera_height = static_cast<std::uint64_t>(info.camera->optics.height_px);
    sizes.camera_width = static_cast<std::uint64_t>(info.camera->optics.width_px);
  }
  if (info.height_map) {
    sizes.height_rows = static_cast<std::uint64_t>(info.height_map->rows);
    sizes.height_columns = static_cast<std::uint64_t>(info.height_map->columns);
  }
  sizes.lags = static_cast<std::uint64_t>(info.output.statistics_lags) + 1;
  sizes.frequencies = static_cast<std::uint64_t>(info.record.transform);
  sizes.pings = info.last_ping - info.first_ping;
  return sizes;
}

NpyShape grid_shape(const CatalogueRow& row, const GridSizes& s) {
  const auto less = [](std::uint64_t size, int fewer) {
    return size - std::min<std::uint64_t>(size, static_cast<std::uint64_t>(fewer));
  };
  switch (row.grid) {
    case FileGrid::none:
      return {};
    case FileGrid::beams:
      return {s.beams};
    case FileGrid::samples:
      return {s.samples};
    case FileGrid::elevations:
      return {s.elevations};
    case FileGrid::azimuths:
      return {s.azimuths};
    case FileGrid::frequencies:
      return {s.frequencies};
    case FileGrid::returns:
      return {s.pings, s.beams};
    case FileGrid::ping_pairs:
      return {s.pings, s.pings};
    case FileGrid::beam_pairs:
      return {s.beams, s.beams};
    case FileGrid::series:
      return {s.beams, s.samples};
    case FileGrid::channels:
      return {s.elements, s.samples};
    case FileGrid::polar:
      return {less(s.samples, row.fewer_rows), less(s.beams, row.fewer_columns)};
    case FileGrid::cartesian:
      return {s.cartesian_height, s.cartesian_width};
    case FileGrid::front:
      return {s.elevations, s.azimuths};
    case FileGrid::camera:
      return {s.camera_height, s.camera_width};
    case FileGrid::camera_color:
      return {s.camera_height, s.camera_width, 3};
    case FileGrid::heights:
      return {s.height_rows, s.height_columns};
    case FileGrid::histogram:
      return {kHistogramBins, s.beams};
    case FileGrid::lags:
      return {s.lags, s.beams};
    case FileGrid::list:
      return {0};
  }
  return {};
}

NpyShape array_shape(const CatalogueRow& row, const GridSizes& sizes) {
  NpyShape shape = grid_shape(row, sizes);
  shape.insert(shape.begin(), sizes.pings);
  return shape;
}

std::uint64_t cell_count(const CatalogueRow& row, const GridSizes& sizes) {
  std::uint64_t count = 1;
  for (const std::uint64_t n : grid_shape(row, sizes)) count *= n;
  return count;
}

std::uint64_t packed_bytes(const CatalogueRow& row, const GridSizes& sizes) {
  return npy_item_bytes(row.type).value_or(0) * cell_count(row, sizes);
}

}  // namespace ensonify
