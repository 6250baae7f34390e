#include <string>
#include <string_view>

#include "dataset/catalogue.h"
#include "dataset/layout.h"

namespace ensonify {
namespace {

using Cells = CatalogueRow::Cells;

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
    if (!row.shares_file && is_float_plane(plane)) {
      row.card =
          "| `front/PPPPPP.exr` | the surface that each ray meets first, rows elevations, columns "
          "azimuths: float channels `range_m`, normal (sonar frame) and backscatter in dB |";
      row.packed_card =
          "| `front_range_m.npy`, `front_normal_*.npy`, `front_backscatter_db.npy` | float32 "
          "[pings, elevations, azimuths], of the surface that each ray meets first: range, normal "
          "(sonar frame) and backscatter in dB |";
    }
    if (std::string_view(plane.name) == "instance") {
      row.card =
          "| `front/PPPPPP_instance.png`, `front/PPPPPP_semantic.png` | its exact ids, 16-bit and "
          "8-bit, 0: none |";
      row.packed_card =
          "| `front_instance.npy`, `front_semantic.npy` | its exact ids, uint16 and uint8, 0: none "
          "|";
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace ensonify
