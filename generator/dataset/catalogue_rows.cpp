#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "core/navigation_tables.h"
#include "dataset/catalogue.h"
#include "dataset/echo_arrays.h"
#include "dataset/geometry_files.h"
#include "dataset/layout.h"
#include "dataset/statistics.h"

namespace ensonify {
namespace {

using Rows = std::vector<CatalogueRow>;
using Cells = CatalogueRow::Cells;

// "complex64".
std::string type_name(const std::string& descr) {
  constexpr std::pair<char, const char*> kKinds[] = {
      {'u', "uint"}, {'i', "int"}, {'f', "float"}, {'c', "complex"}};
  const auto* kind = std::ranges::find(kKinds, descr[2], &std::pair<char, const char*>::first);
  return fmt::format("{}{}", kind->second, 8 * std::stoi(descr.substr(3)));
}

const char* axes_of(FileGrid grid) {
  return grid == FileGrid::polar          ? "samples, beams"
         : grid == FileGrid::series       ? "beams, samples"
         : grid == FileGrid::front        ? "elevations, azimuths"
         : grid == FileGrid::camera       ? "rows, columns"
         : grid == FileGrid::camera_color ? "rows, columns, 3"
         : grid == FileGrid::channels     ? "elements, samples"
                                          : "samples";
}

struct FixedFile {
  const char* name;
  FileCodec codec;
  const char* card;
  FileGrid grid = FileGrid::none;
  const char* type = "";
  bool (*wanted)(const FileSelection&) = nullptr;  // null: always
};

bool has_sonar(const FileSelection& s) { return s.sonar; }
bool has_world(const FileSelection& s) { return s.output.world; }
bool has_sdf(const FileSelection& s) { return s.sdf; }
bool has_front(const FileSelection& s) { return s.output.front; }
bool has_cartesian(const FileSelection& s) { return s.output.cartesian; }
bool has_covisibility(const FileSelection& s) { return s.output.covisibility; }
bool has_powers(const FileSelection& s) { return s.output.elevation && !s.array; }
bool has_height_map(const FileSelection& s) { return s.height_map; }
template <NavigationTable table>
bool has_sensor(const FileSelection& s) {
  return has_table(s.navigation, table);
}

constexpr FixedFile kDatasetFiles[] = {
    {"README.md", FileCodec::text, ""},
    {layout::kDatasetSha256, FileCodec::text, ""},
    {layout::kDatasetJson, FileCodec::json,
     "| `dataset.json` | manifest with the SHA-256 of all files; its own hash is in "
     "`dataset.sha256` |"},
    {layout::kWorkJson, FileCodec::json,
     "| `work.json` | what was generated: scenario, seed, program and instruction sets |"},
    {"scenario.yaml", FileCodec::text,
     "| `scenario.yaml`, `assets/` | the resolved scenario and its input files; "
     "running it again gives the same bytes |"},
    {"index.csv", FileCodec::csv,
     "| `index.csv` | one row per ping: sequence, ping, time_s, split, stem |"},
    {"splits/train.txt", FileCodec::text,
     "| `splits/*.txt` | the stems (`sequence/ping`) of each split; a sequence is in one split |"},
    {"splits/val.txt", FileCodec::text, ""},
    {"splits/test.txt", FileCodec::text, ""},
    {"coco.json", FileCodec::json,
     "| `coco.json` | boxes and masks (compressed RLE) of every instance in every image; with "
     "`amodal_segmentation` also its hidden part, and `occlusion`, the share that is hidden |"},
    {layout::kCroissantJson, FileCodec::json,
     "| `croissant.json` | description for catalogs and loaders (Croissant 1.1) |"},
    {layout::kProvenanceJson, FileCodec::json,
     "| `provenance.json` | host, wall time, threads: not part of the data |"},
};

constexpr const char* name_of(NavigationTable table) {
  return kNavigationTables[static_cast<std::size_t>(table)].name;
}

template <NavigationTable table>
constexpr FixedFile sensor_file(const char* card) {
  return {name_of(table), FileCodec::csv, card, FileGrid::none, "", has_sensor<table>};
}

// {voxel_m} stands for the number.
constexpr FixedFile kSequenceFiles[] = {
    {layout::kSequenceJson, FileCodec::json,
     "| `sequence.json` | the sampled sequence: sonar, water, instances, model, every file with "
     "its SHA-256 |"},
    {"azimuth_rad.npy", FileCodec::npy, "| `azimuth_rad.npy`, `range_m.npy` | float64, the axes |",
     FileGrid::beams, kNpyFloat64, has_sonar},
    {"range_m.npy", FileCodec::npy, "", FileGrid::samples, kNpyFloat64, has_sonar},
    {layout::kFrontElevations, FileCodec::npy,
     "| `front_elevation_rad.npy`, `front_azimuth_rad.npy` | float64, the directions of the rays |",
     FileGrid::elevations, kNpyFloat64, has_front},
    {layout::kFrontAzimuths, FileCodec::npy, "", FileGrid::azimuths, kNpyFloat64, has_front},
    {"poses.csv", FileCodec::csv, "| `poses.csv`, `poses.tum` | the sonar's pose at each ping |"},
    {"poses.tum", FileCodec::tum, ""},
    {"objects.csv", FileCodec::csv, "| `objects.csv` | the pose of each object at each ping |"},
    {"boxes.csv", FileCodec::csv,
     "| `boxes.csv` | the 3-D box of each instance at each ping, in the world and in the sonar's "
     "frame |"},
    {"first_return_m.npy", FileCodec::npy,
     "| `first_return_m.npy` | float32 [pings, beams], range of the first echo, NaN where there "
     "is none |",
     FileGrid::returns, kNpyFloat32, has_sonar},
    {layout::kAnnotations, FileCodec::json_lines,
     "| `annotations.jsonl` | boxes and masks by ping, from which `coco.json` is made |"},
    {layout::kCovisibility, FileCodec::npy,
     "| `covisibility.npy` | float32 [pings, pings], the share of what a ping (row) sees that "
     "another (column) sees as well |",
     FileGrid::ping_pairs, kNpyFloat32, has_covisibility},
    {layout::kBeamPower, FileCodec::npy,
     "| `beam_power.npy`, `pulse_power.npy` | float32 [beams, beams] and complex64 [frequencies]: "
     "how beams and pulse spread the powers in `elevation/` |",
     FileGrid::beam_pairs, kNpyFloat32, has_powers},
    {layout::kPulsePower, FileCodec::npy, "", FileGrid::frequencies, kNpyComplex64, has_powers},
    {layout::kSdf, FileCodec::vdb,
     "| `sdf.vdb` | OpenVDB level set `sdf` of the scene at the first ping: signed distances in "
     "meters, voxels of {voxel_m} m, world coordinates |",
     FileGrid::none, "", has_sdf},
    {layout::kWorldPly, FileCodec::mesh_ply,
     "| `world.ply`, `world.glb` | the surfaces of the scene at the first ping as triangles: in "
     "world coordinates, and by object as glTF, with y up |",
     FileGrid::none, "", has_world},
    {layout::kWorldGlb, FileCodec::glb, "", FileGrid::none, "", has_world},
    {layout::kHeightMap, FileCodec::npy,
     "| `height_map.npy` | float32 [rows, columns], the height of the highest surface at the first "
     "ping, north first, NaN where there is none; `height_map` in `sequence.json` gives the axes |",
     FileGrid::heights, kNpyFloat32, has_height_map},
    {layout::kCartesianMap, FileCodec::npy,
     "| `cartesian_map.npy` | int32 [rows, columns], for each Cartesian pixel the index of its "
     "polar pixel, sample × beams + beam; −1 outside the fan |",
     FileGrid::cartesian, kNpyInt32, has_cartesian},
    sensor_file<NavigationTable::imu>(
        "| `navigation/imu.csv` | mean angular rate and specific force around each time, in the "
        "frame of the IMU |"),
    sensor_file<NavigationTable::imu_truth>(
        "| `navigation/imu_truth.csv` | pose, velocity and biases of the IMU where its samples "
        "begin |"),
    sensor_file<NavigationTable::dvl>(
        "| `navigation/dvl.csv` | velocity in the frame of the DVL, altitude, and range and "
        "velocity along each beam; nan without a lock |"),
    sensor_file<NavigationTable::depth>("| `navigation/depth.csv` | depth and absolute pressure |"),
    sensor_file<NavigationTable::altimeter>(
        "| `navigation/altimeter.csv` | range along the beam; nan without an echo |"),
    sensor_file<NavigationTable::usbl>(
        "| `navigation/usbl.csv` | acoustic fixes of the transponder in the world |"),
    sensor_file<NavigationTable::gps>(
        "| `navigation/gps.csv` | fixes of the antenna at the surface, WGS 84 |"),
    sensor_file<NavigationTable::odometry>(
        "| `navigation/odometry.csv` | drifting dead reckoning of the body |"),
};

void add_fixed_files(Rows& rows, FileScope scope, std::span<const FixedFile> files) {
  for (const FixedFile& file : files) {
    rows.push_back({.scope = scope,
                    .file = file.name,
                    .codec = file.codec,
                    .grid = file.grid,
                    .type = file.type,
                    .wanted = file.wanted,
                    .card = file.card,
                    .packed_card = file.card});
  }
}

void add_statistics(Rows& rows) {
  const std::size_t first = rows.size();
  const auto always = [](const FileSelection& s) { return s.output.statistics; };
  const auto with_lags = [](const FileSelection& s) {
    return s.output.statistics && s.output.statistics_lags > 0;
  };
  for (const StatisticsArray& array : statistics_arrays()) {
    const bool is_lagged = array.rows == StatisticsRows::lags;
    rows.push_back({.scope = FileScope::sequence,
                    .file = array.name,
                    .codec = FileCodec::npy,
                    .grid = is_lagged                            ? FileGrid::lags
                            : array.rows == StatisticsRows::bins ? FileGrid::histogram
                                                                 : FileGrid::polar,
                    .type = array.descr,
                    .wanted = is_lagged ? +with_lags : +always,
                    .fewer_rows = array.fewer_rows,
                    .fewer_columns = array.fewer_columns});
  }
  rows[first].card = rows[first].packed_card =
      "| `statistics/*.npy` | float64 or complex128 [samples, beams]: mean, variance, "
      "contrast, moments, covariance of neighbors and expectation over all pings, which show one "
      "scene with fresh speckle; [bins, beams]: histograms of the intensity; `statistics` in "
      "`sequence.json` describes each |";
}

CatalogueRow series_row(std::string file, std::string array, FileCodec codec = FileCodec::npy) {
  return {.file = std::move(file),
          .array = std::move(array),
          .codec = codec,
          .grid = FileGrid::series,
          .type = kNpyComplex64,
          .file_bytes = 8,
          .cells = [](const PingResult& r) -> Cells { return std::span(r.series); }};
}

void add_series(Rows& rows) {
  rows.push_back(series_row(layout::kTimeseries, "timeseries.npy"));
  rows.back().wanted = [](const FileSelection& s) { return s.output.timeseries; };
  set_cards(rows.back(), "The time series, Pa.");
  rows.back().maker = "`output.timeseries: npy`";

  rows.push_back(series_row(layout::kTimeseriesExr, "", FileCodec::series_exr));
  rows.back().wanted = [](const FileSelection& s) { return s.output.timeseries_exr; };
  rows.back().card =
      "| `timeseries/PPPPPP.exr` | the time series as an image: rows samples, columns beams, "
      "float channels `p.re` and `p.im`, Pa |";
  rows.back().maker = "`output.timeseries: exr`";

  rows.push_back(series_row(layout::kChannels, "channels.npy"));
  rows.back().grid = FileGrid::channels;
  rows.back().wanted = [](const FileSelection& s) { return s.output.channels; };
  rows.back().cells = [](const PingResult& r) -> Cells { return std::span(r.channels); };
  set_cards(rows.back(), "The signal of each element of the array, Pa.");
  rows.back().maker = "`output.channels: true`";
}

// {layers} stands for their names.
void add_layers(Rows& rows) {
  const std::size_t first = rows.size();
  for (const Layer layer : {Layer::noise, Layer::volume, Layer::target, Layer::background,
                            Layer::multipath, Layer::quantisation, Layer::electronics}) {
    const std::string name = layer_name(layer);
    rows.push_back(series_row("layers/{ping}_" + name + ".npy", "layers_" + name + ".npy"));
    rows.back().layer = layer;
    rows.back().maker = "`output.layers: true`";
    rows.back().cells = [layer](const PingResult& r) -> Cells {
      for (const LayerSeries& series : r.layers) {
        if (series.layer == layer) return std::span(series.pressure_pa);
      }
      return std::span<const std::complex<float>>();
    };
  }
  rows[first].card =
      "| `layers/PPPPPP_*.npy` | complex64 [beams, samples], Pa: {layers}, where "
      "present; their sum is the time series |";
  rows[first].packed_card =
      "| `layers_*.npy` | the same of {layers}, where present; their sum is "
      "the time series |";
}

constexpr double kElevationBytes = sizeof(ElevationEcho);

CatalogueRow counts_row(const char* file, const char* array, const char* type, double file_bytes) {
  CatalogueRow row{.file = file,
                   .array = array,
                   .codec = FileCodec::png,
                   .grid = FileGrid::polar,
                   .type = type,
                   .file_bytes = file_bytes,
                   .maker = "`sonar.recorder`"};
  set_cards(
      row, "The counts that the instrument stores; `recorder` in `sequence.json` has their scale.");
  return row;
}

void add_recorded(Rows& rows) {
  CatalogueRow bytes = counts_row(layout::kRecorded8, "recorded_8bit.npy", kNpyUint8, 0.7);
  bytes.wanted = [](const FileSelection& s) { return s.recorded_bits == 8; };
  bytes.cells = [](const PingResult& r) -> Cells { return std::span(r.recorded.counts_8); };

  CatalogueRow words = counts_row(layout::kRecorded16, "recorded_16bit.npy", kNpyUint16, 1.6);
  words.wanted = [](const FileSelection& s) { return s.recorded_bits == 16; };
  words.cells = [](const PingResult& r) -> Cells { return std::span(r.recorded.counts_16); };

  CatalogueRow gains{.file = layout::kRecordedRowGain,
                     .array = "recorded_row_gain.npy",
                     .codec = FileCodec::npy,
                     .grid = FileGrid::samples,
                     .type = kNpyFloat32,
                     .file_bytes = 4,
                     .maker = "`sonar.recorder.row_gain_db`"};
  gains.wanted = [](const FileSelection& s) { return s.recorded_bits > 0 && s.row_gains; };
  gains.cells = [](const PingResult& r) -> Cells { return std::span(r.recorded.row_gain); };
  set_cards(gains, "The gain of each row of counts; amplitudes are divided by its root.");
  rows.insert(rows.end(), {bytes, words, gains});
}

CatalogueRow list_row(const char* file, const char* type, double file_bytes, const char* maker,
                      const char* card, bool (*wanted)(const FileSelection&)) {
  return {.file = file,
          .codec = *type == '\0' ? FileCodec::ply : FileCodec::npy,
          .grid = FileGrid::list,
          .type = type,
          .file_bytes = file_bytes,
          .wanted = wanted,
          .card = card,
          .packed_card = card,
          .maker = maker};
}

void add_lists(Rows& rows) {
  rows.push_back(
      list_row(layout::kScatterers, kNpyScatterer, kScattererBytes, "--export-scatterers",
               "| `scatterers/PPPPPP.npy` | structured array of every scatterer; with `model` in "
               "`sequence.json`, the time series follows from it |",
               [](const FileSelection& s) { return s.output.scatterers; }));
  rows.push_back(list_row(
      layout::kScattererVia, kNpyVia, kMostBounces * sizeof(std::uint16_t),
      "--export-scatterers with `bounces` or a wall",
      "| `scatterers/PPPPPP_via.npy` | the other instances on the path of each scatterer, in the "
      "order of the sound, then the walls that it passes; 0: no more |",
      [](const FileSelection& s) { return s.output.scatterers && s.bounces; }));
  rows.push_back(list_row(
      layout::kElevation, kNpyElevation, kElevationBytes, "`output.elevation`",
      "| `elevation/PPPPPP.npy` | structured array of the echo power in each range bin, beam cell "
      "and step of elevation, before pulse and beams spread it |",
      [](const FileSelection& s) { return s.output.elevation; }));
  rows.push_back(
      list_row(layout::kPoints, "", kPlyPointBytes, "`output.points: true`",
               "| `points/PPPPPP.ply` | the scatterers as a point cloud in the world frame |",
               [](const FileSelection& s) { return s.output.points; }));
}

}  // namespace

void set_cards(CatalogueRow& row, std::string_view what, std::string_view channel) {
  const std::string file = fmt::format(fmt::runtime(row.file), fmt::arg("ping", "PPPPPP"));
  const std::string of_channel = channel.empty() ? "" : fmt::format(", channel `{}`", channel);
  const std::string type = type_name(row.type), axes = axes_of(row.grid);
  row.card = fmt::format("| `{}`{} | {} [{}]. {} |", file, of_channel, type, axes, what);
  row.packed_card = fmt::format("| `{}` | {} [pings, {}]. {} |", row.array, type, axes, what);
}

std::vector<CatalogueRow> catalogue_rows() {
  Rows rows;
  add_fixed_files(rows, FileScope::dataset, kDatasetFiles);
  add_fixed_files(rows, FileScope::sequence, kSequenceFiles);
  add_statistics(rows);
  add_series(rows);
  add_layers(rows);
  for (CatalogueRow& row : image_rows()) rows.push_back(std::move(row));
  add_recorded(rows);
  for (CatalogueRow& row : front_rows()) rows.push_back(std::move(row));
  for (CatalogueRow& row : camera_rows()) rows.push_back(std::move(row));
  add_lists(rows);
  return rows;
}

}  // namespace ensonify
