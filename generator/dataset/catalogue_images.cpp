#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>

#include "dataset/catalogue.h"
#include "dataset/layout.h"

namespace ensonify {
namespace {

using Rows = std::vector<CatalogueRow>;
using Cells = CatalogueRow::Cells;

// The data card's lines about polar images, by the first plane that each is about. {arrays} stands
// for the arrays of the float planes of its group other than the level.
struct PlaneCard {
  std::string_view plane;
  const char* card;
  const char* packed_card;
};
constexpr PlaneCard kPlaneCards[] = {
    {"level_db",
     "| `polar/PPPPPP.exr` | level in dB (`Y`); second part: expected level without speckle, "
     "elevation and its standard deviation, share of the strongest instance |",
     "| `polar_level_db.npy` | float16 [pings, samples, beams], level in dB; likewise {arrays} |"},
    {"instance",
     "| `polar/PPPPPP_instance.png`, `polar/PPPPPP_semantic.png` | exact ids, 16-bit and 8-bit, 0: "
     "none |",
     "| `polar_instance.npy`, `polar_semantic.npy` | exact ids, uint16 and uint8, 0: none |"},
    {"shadow",
     "| `polar/PPPPPP_shadow.png` | 16-bit, the instance in whose shadow the pixel lies, 0: none |",
     "| `polar_shadow.npy` | uint16, the instance in whose shadow the pixel lies, 0: none |"},
    {"multipath",
     "| `polar/PPPPPP_multipath.png` | 16-bit, the instance whose multipath echoes are stronger "
     "there than the direct echoes, 0: none; no other mask counts multipath echoes |",
     "| `polar_multipath.npy` | uint16, the instance whose multipath echoes are stronger than the "
     "direct echoes, 0: none; no other mask counts multipath echoes |"},
    {"surface_elevation_rad",
     "| `polar/PPPPPP_surfaces.exr` | float channels about the surfaces of the pixel's instance: "
     "elevation, range and normal (sonar frame) at the strongest echo, elevation and range at the "
     "lowest and at the highest, and the number of surfaces; the number of surfaces of all "
     "instances, and the second instance's share |",
     "| {arrays} | float32 [pings, samples, beams], about the surfaces of the pixel's instance: "
     "elevation, range and normal (sonar frame) at the strongest echo, elevation and range at the "
     "lowest and at the highest, and the number of surfaces; the number of surfaces of all "
     "instances, and the second instance's share |"},
    {"second_instance",
     "| `polar/PPPPPP_second_instance.png` | 16-bit, the instance with the second most energy in "
     "the pixel, 0: none |",
     "| `polar_second_instance.npy` | uint16, the instance with the second most energy in the "
     "pixel, 0: none |"},
    {"point_sample",
     "| `polar/PPPPPP_motion.exr` | float channels about the point of the strongest echo of the "
     "pixel's instance: its place among samples and beams, and its displacement to another ping |",
     "| {arrays} | float32 [pings, samples, beams], the point of the strongest echo of the pixel's "
     "instance: its place among samples and beams, and its displacement to another ping |"},
    {"motion_state",
     "| `polar/PPPPPP_motion_state.png`, `polar/PPPPPP_motion_occluder.png` | 8-bit, that point in "
     "the other ping: 1 seen, 2 hidden, 3 outside, 0: none; 16-bit, the instance that hides it |",
     "| `polar_motion_state.npy`, `polar_motion_occluder.npy` | uint8, that point in the other "
     "ping: 1 seen, 2 hidden, 3 outside, 0: none; uint16, the instance that hides it |"},
    {"artifact",
     "| `polar/PPPPPP_artifact.png` | 8-bit, what the electronics changed: 1 clipped, 2 streak, 4 "
     "interference, 8 leakage, 16 blanked |",
     "| `polar_artifact.npy` | uint8, what the electronics changed: 1 clipped, 2 streak, 4 "
     "interference, 8 leakage, 16 blanked |"},
};

// "point_": the first word of a plane's name.
std::string_view first_word(const ImagePlane& plane) {
  const std::string_view name = plane.name;
  return name.substr(0, name.find('_') + 1);
}

// The names of the arrays of a plane's group; `polar_WORD_*.npy` where all planes that begin with a
// word belong to it.
std::string arrays_of_group(const ImagePlane& first) {
  const auto belongs = [&](const ImagePlane& plane) {
    return is_float_plane(plane) && plane.group() == first.group() && !is_level_plane(plane);
  };
  std::vector<std::string> names;
  for (const ImagePlane& plane : kImagePlanes) {
    if (!belongs(plane)) continue;
    std::string name = fmt::format("`polar_{}`", plane.name);
    if (has_own_file(plane)) {
      const auto same_word = [&](const ImagePlane& other) {
        return first_word(other) == first_word(plane);
      };
      const bool is_whole = std::ranges::count_if(kImagePlanes, same_word) > 1 &&
                            std::ranges::none_of(kImagePlanes, [&](const ImagePlane& other) {
                              return same_word(other) && !belongs(other);
                            });
      name = is_whole ? fmt::format("`polar_{}*.npy`", first_word(plane))
                      : fmt::format("`polar_{}.npy`", plane.name);
    }
    if (names.empty() || names.back() != name) names.push_back(std::move(name));
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

void set_cards(const ImagePlane& plane, CatalogueRow& row) {
  const auto* lines = std::ranges::find(kPlaneCards, plane.name, &PlaneCard::plane);
  if (lines == std::end(kPlaneCards)) return;
  row.card = lines->card;
  row.packed_card =
      fmt::format(fmt::runtime(lines->packed_card), fmt::arg("arrays", arrays_of_group(plane)));
}

const std::optional<LabelledImage>& image_of(const PingResult& r, ImageView view) {
  return view == ImageView::polar ? r.polar : r.cartesian;
}

// Float planes are stored as halves in one image, except those of a group, which has its own image
// of floats. Each plane of ids has its own image.
CatalogueRow row_of(ImageView view, const ImagePlane& plane) {
  const std::string name = view_name(view);
  const bool is_float = is_float_plane(plane);
  const bool is_byte =
      std::holds_alternative<std::vector<std::uint8_t> ImagePlanes::*>(plane.values);
  CatalogueRow row;
  row.file = has_own_file(plane) ? fmt::format("{}/{{ping}}_{}.exr", name, plane.group())
             : is_float          ? name + "/{ping}.exr"
                                 : name + "/{ping}_" + plane.name + ".png";
  row.array = name + "_" + plane.name + ".npy";
  row.codec = has_own_file(plane) ? FileCodec::group_exr
              : is_float          ? FileCodec::exr
                                  : FileCodec::png;
  row.grid = view == ImageView::polar ? FileGrid::polar : FileGrid::cartesian;
  row.type = has_own_file(plane) ? kNpyFloat32
             : is_float          ? kNpyFloat16
             : is_byte           ? kNpyUint8
                                 : kNpyUint16;
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
      set_cards(plane, row);
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
