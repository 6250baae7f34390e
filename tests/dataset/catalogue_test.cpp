// The rows that everything else loops over.
#include "dataset/catalogue.h"

#include <set>

#include "catch.h"
#include "dataset/layout.h"
#include "dataset/sample.h"
#include "results.h"

using namespace ensonify;

// Protects every look-up by name: no two rows share a file or an array, but the planes of an image.
TEST_CASE("names of files and arrays are those of one row") {
  std::set<std::pair<FileScope, std::string>> files;
  std::set<std::string> arrays;
  for (const CatalogueRow& row : catalogue()) {
    INFO(row.file);
    if (!row.shares_file) CHECK(files.emplace(row.scope, row.file).second);
    if (!row.array.empty()) CHECK(arrays.insert(row.array).second);
    if (row.scope == FileScope::ping) CHECK(row.file.find("{ping}") != std::string::npos);
    CHECK((row.array.empty() || row.cells));
  }
}

// Protects new labels from being forgotten: each plane has an array, a file and a place in both
// views, and an output that asks for it brings both.
TEST_CASE("every plane of an image has its rows") {
  FileSelection selection{.output = sample::sequence_info(0).output};
  FileSelection without_exr = selection;
  without_exr.output.cartesian_exr = false;
  for (const ImagePlane& plane : kImagePlanes) {
    if (plane.wanted != nullptr) selection.output.*plane.wanted = true;
    for (const ImageView view : {ImageView::polar, ImageView::cartesian}) {
      const CatalogueRow& row = plane_row(view, plane.name);
      CHECK(row.plane == &plane);
      CHECK(is_wanted(row, selection));
      if (plane.wanted == nullptr) {
        const bool needs_exr = view == ImageView::cartesian && is_float_plane(plane);
        CHECK(is_wanted(row, without_exr) != needs_exr);
      }
      CHECK((row.shares_file || is_ping_file(row, selection)));
      CHECK_FALSE(is_array(row, selection));
      FileSelection packed = selection;
      packed.output.packed = true;
      CHECK(is_array(row, packed));
      CHECK_FALSE(is_ping_file(row, packed));
    }
  }
}

// Protects sizes: what a sample holds is as large as its rows say.
TEST_CASE("cells of a ping fill their grids") {
  SequenceInfo info = sample::sequence_info(0);
  const PingResult result = sample::ping_result(info, 1);
  const GridSizes sizes = sizes_of(info);
  int rows = 0;
  for (const CatalogueRow& row : catalogue()) {
    if (!row.cells || !is_wanted(row, selection_of(info))) continue;
    ++rows;
    const auto count =
        std::visit([](const auto& cells) { return cells.size(); }, row.cells(result));
    CHECK(count == cell_count(row, sizes));
  }
  int planes = 0;
  for (const ImagePlane& plane : kImagePlanes) planes += sample::has_plane(info.output, plane);
  CHECK(rows == 2 * planes + 4);  // in both views; two grey images and the series as NPY and EXR
  CHECK(array_shape(plane_row(ImageView::cartesian, "shadow"), sizes) == NpyShape{3, 7, 8});
  CHECK(packed_bytes(plane_row(ImageView::polar, "level_db"), sizes) == 9 * 6 * 2);
}

// Protects names: templates and file names turn into each other, also beyond six digits.
TEST_CASE("names of ping files go both ways") {
  for (const std::uint32_t ping : {0u, 42u, 999999u, 1000000u, 4294967295u}) {
    const std::string name = layout::ping_file(layout::kPolarGrey, ping);
    const auto file = value_of(layout::parse_ping_file(name));
    CHECK(file.name_template == layout::kPolarGrey);
    CHECK(file.ping == ping);
  }
  CHECK(layout::ping_file(layout::kPolarGrey, 7) == "png/000007_polar.png");
  CHECK_FALSE(layout::parse_ping_file("poses.csv"));
  CHECK_FALSE(layout::parse_ping_file("polar/0000007.exr"));
  CHECK_FALSE(layout::parse_ping_file("polar/99999999999.exr"));
}

// Protects strangers' files: only names that a data set can have are in its way.
TEST_CASE("names of the layout are told from others") {
  for (const char* name :
       {"work.json", "dataset.json", "splits", "splits/val.txt", "assets/x", ".work", "sequences",
        "sequences/000012", "sequences/000000/sequence.json", "sequences/000000/polar",
        "sequences/000000/polar/000123_instance.png", "sequences/000000/png/1000000_polar.png"}) {
    INFO(name);
    CHECK(layout::is_layout_name(name));
  }
  for (const char* name : {"notes.txt", "splits/mine.txt", "sequences/notes", "sequences/12",
                           "sequences/000000/notes", "sequences/000000/polar/000123.pdf"}) {
    INFO(name);
    CHECK_FALSE(layout::is_layout_name(name));
  }
}
