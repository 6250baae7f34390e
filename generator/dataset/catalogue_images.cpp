#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <string_view>
#include <utility>

#include "dataset/catalogue.h"
#include "dataset/layout.h"

namespace ensonify {
namespace {

using Rows = std::vector<CatalogueRow>;
using Cells = CatalogueRow::Cells;

// The data card's text about a plane of polar images, and its bytes per pixel on disk: levels are
// stored uncompressed, other planes are deflated.
struct PlaneFile {
  std::string_view plane;
  double file_bytes;
  const char* meaning = "";  // for {meanings}; empty: that of another plane covers it
  // {meanings} and {arrays} stand for those of the float planes other than the level.
  const char* card = "";
  const char* packed_card = "";
};
constexpr PlaneFile kPlaneFiles[] = {
    {"level_db", 2, "", "| `polar/PPPPPP.exr` | level in dB (`Y`); second part: {meanings} |",
     "| `polar_level_db.npy` | float16 [pings, samples, beams], level in dB; likewise {arrays} |"},
    {"clean_db", 0.25, "expected level without speckle"},
    {"elevation_rad", 0.25, "elevation and its standard deviation"},
    {"elevation_std_rad", 0.25},
    {"instance_fraction", 0.125, "share of the strongest instance"},
    {"instance", 0.0625, "",
     "| `polar/PPPPPP_instance.png`, `polar/PPPPPP_semantic.png` | exact ids, "
     "16-bit and 8-bit, 0: none |",
     "| `polar_instance.npy`, `polar_semantic.npy` | exact ids, uint16 and uint8, 0: none |"},
    {"semantic", 0.0625},
    {"shadow", 0.02, "",
     "| `polar/PPPPPP_shadow.png` | 16-bit, the instance in whose shadow the pixel lies, "
     "0: none |",
     "| `polar_shadow.npy` | uint16, the instance in whose shadow the pixel lies, 0: none |"},
    {"multipath", 0.02, "",
     "| `polar/PPPPPP_multipath.png` | 16-bit, the instance whose multipath echoes are "
     "stronger there than the direct echoes, 0: none; no other mask counts multipath "
     "echoes |",
     "| `polar_multipath.npy` | uint16, the instance whose multipath echoes are stronger "
     "than the direct echoes, 0: none; no other mask counts multipath echoes |"},
    {"surface_elevation_rad", 0.4, "",
     "| `polar/PPPPPP_surfaces.exr` | float channels about the surfaces of the pixel's instance: "
     "elevation, range and normal (sonar frame) at the strongest echo, elevation and range at the "
     "lowest and at the highest, and the number of surfaces; the number of surfaces of all "
     "instances, "
     "and the second instance's share |",
     "| `polar_surface_*.npy`, `polar_lowest_*.npy`, `polar_highest_*.npy`, "
     "`polar_layover_count.npy`, `polar_second_fraction.npy` | float32 [pings, "
     "samples, beams], about the surfaces of the pixel's instance: elevation, range and normal "
     "(sonar "
     "frame) at the strongest echo, elevation and range at the lowest and at the highest, and the "
     "number of surfaces; the number of surfaces of all instances, and the second instance's share "
     "|"},
    {"surface_range_m", 0.4},
    {"surface_normal_x", 0.4},
    {"surface_normal_y", 0.4},
    {"surface_normal_z", 0.4},
    {"lowest_elevation_rad", 0.4},
    {"lowest_range_m", 0.4},
    {"highest_elevation_rad", 0.4},
    {"highest_range_m", 0.4},
    {"surface_count", 0.05},
    {"layover_count", 0.05},
    {"second_fraction", 0.2},
    {"second_instance", 0.05, "",
     "| `polar/PPPPPP_second_instance.png` | 16-bit, the instance with the second most energy in "
     "the pixel, 0: none |",
     "| `polar_second_instance.npy` | uint16, the instance with the second most energy in the "
     "pixel, 0: none |"},
    {"point_sample", 0.4, "",
     "| `polar/PPPPPP_motion.exr` | float channels about the point of the strongest echo of the "
     "pixel's instance: its place among samples and beams, and its displacement to another ping |",
     "| `polar_point_*.npy`, `polar_motion_samples.npy`, `polar_motion_beams.npy` | float32 "
     "[pings, "
     "samples, beams], the point of the strongest echo of the pixel's instance: its place among "
     "samples and beams, and its displacement to another ping |"},
    {"point_beam", 0.4},
    {"motion_samples", 0.8},
    {"motion_beams", 0.8},
    {"motion_state", 0.02, "",
     "| `polar/PPPPPP_motion_state.png`, `polar/PPPPPP_motion_occluder.png` | 8-bit, that point in "
     "the other ping: 1 seen, 2 hidden, 3 outside, 0: none; 16-bit, the instance that hides it |",
     "| `polar_motion_state.npy`, `polar_motion_occluder.npy` | uint8, that point in the other "
     "ping: 1 seen, 2 hidden, 3 outside, 0: none; uint16, the instance that hides it |"},
    {"motion_occluder", 0.02},
    {"artifact", 0.02, "",
     "| `polar/PPPPPP_artifact.png` | 8-bit, what the electronics changed: 1 clipped, 2 streak, 4 "
     "interference, 8 leakage, 16 blanked |",
     "| `polar_artifact.npy` | uint8, what the electronics changed: 1 clipped, 2 streak, 4 "
     "interference, 8 leakage, 16 blanked |"},
};

constexpr const PlaneFile* file_of(const ImagePlane& plane) {
  return std::find_if(std::begin(kPlaneFiles), std::end(kPlaneFiles),
                      [&](const PlaneFile& file) { return file.plane == plane.name; });
}
static_assert(std::size(kPlaneFiles) == std::size(kImagePlanes) &&
                  std::all_of(std::begin(kImagePlanes), std::end(kImagePlanes),
                              [](const ImagePlane& p) {
                                return file_of(p) != std::end(kPlaneFiles);
                              }),
              "every plane of kImagePlanes has one row in kPlaneFiles");

std::string with_label_names(std::string card) {
  std::vector<std::string> meanings, arrays;
  for (const ImagePlane& plane : kImagePlanes) {
    if (!is_float_plane(plane) || is_level_plane(plane) || has_own_file(plane)) continue;
    arrays.push_back(fmt::format("`polar_{}`", plane.name));
    if (*file_of(plane)->meaning != 0) meanings.emplace_back(file_of(plane)->meaning);
  }
  return fmt::format(fmt::runtime(card), fmt::arg("meanings", fmt::join(meanings, ", ")),
                     fmt::arg("arrays", fmt::join(arrays, ", ")));
}

const std::optional<LabelledImage>& image_of(const PingResult& r, ImageView view) {
  return view == ImageView::polar ? r.polar : r.cartesian;
}

const char* maker_of_group(std::string_view group) {
  return group == kMotionPlanes ? "`output.motion: true`" : "`output.surfaces: true`";
}

// Float planes are stored as halves in one image, except those of a group, which has its own image
// of floats. Each plane of ids has its own image.
CatalogueRow row_of(ImageView view, const ImagePlane& plane) {
  const std::string name = view_name(view);
  const bool is_float = is_float_plane(plane);
  const bool is_byte =
      std::holds_alternative<std::vector<std::uint8_t> ImagePlanes::*>(plane.values);
  CatalogueRow row;
  row.file = has_own_file(plane) ? name + "/{ping}_" + plane.group + ".exr"
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
  row.maker = has_own_file(plane)        ? maker_of_group(plane.group)
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
    row.file_bytes = file_of(plane)->file_bytes;
    if (view == ImageView::polar) {
      row.card = with_label_names(file_of(plane)->card);
      row.packed_card = with_label_names(file_of(plane)->packed_card);
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

}  // namespace ensonify
