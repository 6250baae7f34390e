#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "dataset/catalogue.h"
#include "dataset/image_exr.h"
#include "dataset/layout.h"

namespace ensonify {
namespace {

using Rows = std::vector<CatalogueRow>;
using Cells = CatalogueRow::Cells;

const std::optional<LabelledImage>& image_of(const PingResult& r, ImageView view) {
  return view == ImageView::polar ? r.polar : r.cartesian;
}

// Float planes are stored as halves in one image, except those of a group, which has its own image
// of floats. Each plane of ids has its own image.
CatalogueRow row_of(ImageView view, const ImagePlane& plane) {
  const std::string name = view_name(view);
  const bool is_float = is_float_plane(plane);
  constexpr const char* kTypes[] = {kNpyFloat16, kNpyUint16, kNpyUint8};
  CatalogueRow row;
  row.file = has_own_file(plane) ? fmt::format("{}/{{ping}}_{}.exr", name, plane.group())
             : is_float          ? name + "/{ping}.exr"
                                 : name + "/{ping}_" + plane.name + ".png";
  row.array = name + "_" + plane.name + ".npy";
  row.codec = has_own_file(plane) ? FileCodec::group_exr
              : is_float          ? FileCodec::exr
                                  : FileCodec::png;
  row.grid = view == ImageView::polar ? FileGrid::polar : FileGrid::cartesian;
  row.type = has_own_file(plane) ? kNpyFloat32 : kTypes[plane.values.index()];
  row.maker = has_own_file(plane)        ? fmt::format("`output.{}: true`", plane.group())
              : view == ImageView::polar ? "`output.polar: true`"
              : is_float                 ? "`output.cartesian: {exr: true}`"
                                         : "`output.cartesian`";
  row.cells = [view, &plane](const PingResult& r) -> Cells {
    const auto& image = image_of(r, view);
    if (!image) return std::span<const float>();
    return with_plane(*image, plane, [](const auto& v) -> Cells { return std::span(v); });
  };
  row.view = view;
  row.plane = &plane;
  return row;
}

using Wanted = decltype(CatalogueRow::wanted);
Wanted wanted_of(ImageView view, const ImagePlane& plane) {
  if (view == ImageView::polar) return [](const FileSelection& s) { return s.output.polar; };
  if (!is_float_plane(plane)) return [](const FileSelection& s) { return s.output.cartesian; };
  return [](const FileSelection& s) { return s.output.cartesian && s.output.cartesian_exr; };
}

void add_images(Rows& rows, ImageView view) {
  for (const ImagePlane& plane : kImagePlanes) {
    CatalogueRow row = row_of(view, plane);
    row.wanted = wanted_of(view, plane);
    row.shares_file = std::any_of(rows.begin(), rows.end(), [&](const CatalogueRow& before) {
      return before.file == row.file;
    });
    row.file_bytes = plane.file_bytes;
    if (view == ImageView::polar) {
      const char* channel = is_level_plane(plane) ? kExrLevelChannel : plane.name;
      set_cards(row, plane.meaning, is_float_plane(plane) ? channel : "");
    } else if (is_level_plane(plane)) {
      row.card = "| `cartesian/PPPPPP.exr` | the channels of `polar`, seen from above |";
      row.packed_card =
          "| `cartesian_*_db.npy`, `cartesian_*_rad.npy`, `cartesian_instance_fraction.npy` | "
          "levels and labels of `polar`, [pings, rows, columns], seen from above |";
    } else if (std::string_view(plane.name) == "instance") {
      row.card = "| `cartesian/PPPPPP_*.png` | the ids of `polar`, seen from above |";
      row.packed_card =
          "| other `cartesian_*.npy` | the ids of `polar`, [pings, rows, columns], seen from "
          "above |";
    }
    rows.push_back(std::move(row));
  }
}

void add_greys(Rows& rows) {
  const auto add = [&](ImageView view, const char* file, FileGrid grid) {
    CatalogueRow row;
    row.file = file;
    row.array = std::string(view_name(view)) + "_grey.npy";
    row.codec = FileCodec::png;
    row.grid = grid;
    row.type = kNpyUint8;
    row.file_bytes = 0.35;
    row.view = view;
    row.cells = [view](const PingResult& r) -> Cells {
      const auto& grey = view == ImageView::polar ? r.polar_grey : r.cartesian_grey;
      return grey ? std::span<const std::uint8_t>(grey->pixels) : std::span<const std::uint8_t>();
    };
    rows.push_back(std::move(row));
  };
  add(ImageView::polar, layout::kPolarGrey, FileGrid::polar);
  rows.back().wanted = [](const FileSelection& s) { return s.output.png; };
  rows.back().card =
      "| `png/PPPPPP_polar.png`, `png/PPPPPP_cartesian.png` | 8-bit display images |";
  rows.back().packed_card = "| `polar_grey.npy`, `cartesian_grey.npy` | uint8, display images |";
  rows.back().maker = "`output.png: true`";
  add(ImageView::cartesian, layout::kCartesianGrey, FileGrid::cartesian);
  rows.back().wanted = [](const FileSelection& s) { return s.output.png && s.output.cartesian; };
  rows.back().maker = "`output.png: true` and `output.cartesian`, or give --view polar";
}

}  // namespace

std::vector<CatalogueRow> image_rows() {
  Rows rows;
  add_images(rows, ImageView::polar);
  add_images(rows, ImageView::cartesian);
  add_greys(rows);
  return rows;
}

namespace {

CatalogueRow front_row(const FrontPlane& plane) {
  const bool is_float = is_float_plane(plane);
  const std::string name = plane.name;
  CatalogueRow row;
  row.file = is_float ? layout::kFrontExr : "front/{ping}_" + name + ".png";
  row.array = "front_" + name + ".npy";
  row.codec = is_float ? FileCodec::front_exr : FileCodec::png;
  row.grid = FileGrid::front;
  constexpr const char* kTypes[] = {kNpyFloat32, kNpyUint16, kNpyUint8};
  row.type = kTypes[plane.values.index()];
  row.file_bytes = plane.file_bytes;
  row.wanted = [](const FileSelection& s) { return s.output.front; };
  row.maker = "`output.front: true`";
  row.front_plane = &plane;
  row.cells = [&plane](const PingResult& r) -> Cells {
    if (!r.front) return std::span<const float>();
    return with_plane(*r.front, plane,
                      [](const auto& values) -> Cells { return std::span(values); });
  };
  return row;
}

}  // namespace

std::vector<CatalogueRow> front_rows() {
  std::vector<CatalogueRow> rows;
  bool has_image = false;
  for (const FrontPlane& plane : kFrontPlanes) {
    CatalogueRow row = front_row(plane);
    row.shares_file = is_float_plane(plane) && has_image;
    has_image = has_image || is_float_plane(plane);
    set_cards(row, plane.meaning, is_float_plane(plane) ? plane.name : "");
    rows.push_back(std::move(row));
  }
  return rows;
}

std::vector<CatalogueRow> camera_rows() {
  std::vector<CatalogueRow> rows;
  for (const CameraPlane& plane : kCameraPlanes) {
    const bool is_float = is_float_plane(plane);
    constexpr const char* kTypes[] = {kNpyFloat32, kNpyUint16, kNpyUint8};
    CatalogueRow row;
    row.file = camera_file(plane);
    row.array = std::string("camera_") + plane.name + ".npy";
    row.codec = is_float ? FileCodec::camera_exr : FileCodec::png;
    row.grid = plane.channels > 1 ? FileGrid::camera_color : FileGrid::camera;
    row.type = kTypes[plane.values.index()];
    row.file_bytes = plane.file_bytes;
    row.maker = "`camera` and `output.camera`";
    row.camera_plane = &plane;
    row.cells = [&plane](const PingResult& r) -> Cells {
      if (!r.camera) return std::span<const float>();
      return with_plane(*r.camera, plane,
                        [](const auto& values) -> Cells { return std::span(values); });
    };
    row.shares_file = !rows.empty() && rows.back().file == row.file;
    set_cards(row, plane.meaning, is_float ? plane.name : "");
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace ensonify
