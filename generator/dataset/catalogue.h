// The files of a data set and the planes of its images, one row each. All code that writes, packs,
// checks, lists, estimates, describes or reads files loops over these rows.
//
//   FileScope  FileGrid  FileCodec     a file's folder, its cells and their encoding
//   CatalogueRow  catalogue            the rows, in the order of the data card
//   FileSelection  selection_of        the settings that select files
//   is_wanted  is_ping_file  is_array
//   find_file  find_array  arrays_of   rows by name
//   plane_row  grey_row  picture_row   rows by their content
//   PlaneFacts  plane_facts            of the plane of a row, whatever image it belongs to
//   GridSizes  sizes_of                the sizes of a sequence's grids
//   grid_shape  array_shape  cell_count  packed_bytes
#pragma once

#include <complex>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/camera_planes.h"
#include "core/front_planes.h"
#include "core/image_planes.h"
#include "core/ping.h"
#include "formats/npy.h"

namespace ensonify {

// Whether a file exists once per data set, per sequence or per ping.
enum class FileScope { dataset, sequence, ping };

// [beams], [samples], [elevations], [azimuths], [frequencies], [pings, beams], [pings, pings],
// [beams, beams], [beams, samples], [elements, samples], [samples, beams], [rows, columns],
// [elevations, azimuths], [rows, columns] of the camera, alone and with the three
// colors, [rows, columns] of the height map, [bins, beams] of histograms,
// [lags, beams], and a list of scatterers. Angles are of rays, frequencies of Record::transform.
enum class FileGrid {
  none,
  beams,
  samples,
  elevations,
  azimuths,
  frequencies,
  returns,
  ping_pairs,
  beam_pairs,
  series,
  channels,
  polar,
  cartesian,
  front,
  camera,
  camera_color,
  heights,
  histogram,
  lags,
  list
};

enum class FileCodec {
  text,
  csv,
  tum,
  json,
  json_lines,
  npy,
  png,
  exr,
  group_exr,
  series_exr,
  front_exr,
  camera_exr,
  ply,
  mesh_ply,
  glb,
  vdb
};

// The settings that select the files of a sequence.
struct FileSelection {
  bool sonar = true;
  OutputSelection output;
  std::vector<Layer> layers = {};
  bool sdf = false;
  bool bounces = false;
  bool array = false;      // of elements, in place of beam patterns
  int recorded_bits = 0;   // of the counts of a recorder; 0: none
  bool row_gains = false;  // of a recorder
  bool height_map = false;
  Navigation navigation = {};
};

// Packed sequences have `array`, one file of all pings, instead of a `file` per ping. Packed
// sequences lack rows without an array, except lists, which stay one file per ping.
struct CatalogueRow {
  using Cells = std::variant<std::span<const float>, std::span<const std::uint16_t>,
                             std::span<const std::uint8_t>, std::span<const std::complex<float>>>;

  FileScope scope = FileScope::ping;
  std::string file;                           // in the folder of its scope; {ping}: the ping's stem
  std::string array = {};                     // in the sequence's folder
  FileCodec codec = FileCodec::text;          // of `file`
  FileGrid grid = FileGrid::none;             // of a ping
  std::string type = {};                      // of a cell in `array` or NPY (npy.h); empty: none
  double file_bytes = 0;                      // of a cell in `file`, as typical images have them
  bool (*wanted)(const FileSelection&) = {};  // null: always
  std::string card = {};                      // the line of README.md; empty: in an earlier row
  std::string packed_card = {};               // the line of packed sequences
  std::string maker = {};                     // the keys of a scenario that enable it
  std::function<Cells(const PingResult&)> cells = {};  // null: no cells of fixed number
  std::optional<ImageView> view = {};                  // of an image
  const ImagePlane* plane = nullptr;                   // ... and which of its planes
  const FrontPlane* front_plane = nullptr;             // of a front view
  const CameraPlane* camera_plane = nullptr;           // of a camera's image
  bool shares_file = false;                            // with a row before: planes of one EXR
  std::optional<Layer> layer = {};
  int fewer_rows = 0, fewer_columns = 0;  // of statistics: pairs of neighbors
};

std::span<const CatalogueRow> catalogue();
// Make the rows: all, those of images, of front views and of the camera. Only for catalogue().
std::vector<CatalogueRow> catalogue_rows();
std::vector<CatalogueRow> image_rows();
std::vector<CatalogueRow> front_rows();
std::vector<CatalogueRow> camera_rows();
// Both cards of a row that has a type and an array; `channel`: of the plane in an EXR file.
void set_cards(CatalogueRow& row, std::string_view what, std::string_view channel = {});

// What the plane of a row is called, measured in and filled with; of a row without a plane empty
// texts and zero.
struct PlaneFacts {
  std::string_view name = {};
  const char* unit = "";
  PlaneBlank blank = PlaneBlank::zero;
};
PlaneFacts plane_facts(const CatalogueRow& row);

FileSelection selection_of(const SequenceInfo& info);
bool is_wanted(const CatalogueRow& row, const FileSelection& selection);
// Whether each ping has this file; whether the sequence has the array.
bool is_ping_file(const CatalogueRow& row, const FileSelection& selection);
bool is_array(const CatalogueRow& row, const FileSelection& selection);

// Null if no data set has a file or array of this name.
const CatalogueRow* find_file(FileScope scope, std::string_view file);
const CatalogueRow* find_array(std::string_view array);
// The arrays of a packed sequence, in the order in which they lie in a ping's piece.
std::vector<const CatalogueRow*> arrays_of(const FileSelection& selection);

const CatalogueRow& plane_row(ImageView view, std::string_view plane);
const CatalogueRow& grey_row(ImageView view);
// The image for training a detector: the 8-bit one or, if missing, the level; null if both are
// missing.
const CatalogueRow* picture_row(ImageView view, const FileSelection& selection);

struct GridSizes {
  std::uint64_t beams = 0, samples = 0;
  std::uint64_t elements = 0;                               // of an array; 0: none
  std::uint64_t cartesian_height = 0, cartesian_width = 0;  // 0: none
  std::uint64_t elevations = 0, azimuths = 0;               // of rays
  std::uint64_t camera_height = 0, camera_width = 0;        // 0: none
  std::uint64_t frequencies = 0;
  std::uint64_t lags = 0;  // of statistics, with lag 0
  std::uint64_t pings = 0;
  std::uint64_t height_rows = 0, height_columns = 0;  // of the height map; 0: none
};
GridSizes sizes_of(const SequenceInfo& info);
// A list has the shape {0}, which stands for any length.
NpyShape grid_shape(const CatalogueRow& row, const GridSizes& sizes);
// Shape of `array`: pings first.
NpyShape array_shape(const CatalogueRow& row, const GridSizes& sizes);
std::uint64_t cell_count(const CatalogueRow& row, const GridSizes& sizes);
// The bytes of one ping in `array`.
std::uint64_t packed_bytes(const CatalogueRow& row, const GridSizes& sizes);

}  // namespace ensonify
