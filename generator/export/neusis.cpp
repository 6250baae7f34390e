// SEQUENCE/Config.json and SEQUENCE/Data/PPPP.pkl, the layout of neusis (Qadri, Kaess and
// Gkioulekas, "Neural implicit surface reconstruction using imaging sonar", 2023). Where the data
// set has them: SEQUENCE/sdf.vdb, SEQUENCE/mesh.ply, and from the height map what neusis_ngp reads,
// SEQUENCE/heightmap_gt.npy and SEQUENCE/PC.npy.
//
// The reader takes pixel (i, j) to lie between RangeMin + i d and RangeMin + (i + 1) d, with
// d = (RangeMax - RangeMin) / rows, and at the azimuth -Azimuth / 2 + j Azimuth / columns. Images
// have one column more than beams, before the first, so that column j + 1 lies at the azimuth of
// beam j. The reader blanks the last 200 rows: as many are added.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/units.h"
#include "dataset/layout.h"
#include "export/ping_values.h"
#include "formats/bytes.h"
#include "formats/files.h"
#include "formats/json.h"
#include "formats/npy.h"
#include "formats/output_place.h"
#include "formats/pickle.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t kBlankedRows = 200;

struct NeusisImage {
  std::uint64_t first_sample = 0;  // the first with a range of half a step or more
  std::uint64_t rows = 0, columns = 0;
  double range_min_m = 0, range_max_m = 0;
  double azimuth_rad = 0, elevation_rad = 0;
};

NeusisImage neusis_image(const StoredSequence& sequence) {
  const Sonar& sonar = sequence.manifest.info.sonar;
  const double step_m = sequence.range_step_m;
  NeusisImage image;
  image.first_sample = sequence.first_range_m < step_m / 2 ? 1 : 0;
  image.rows = sequence.samples - image.first_sample + kBlankedRows;
  image.columns = sequence.beams + 1;
  image.range_min_m =
      sequence.first_range_m + (static_cast<double>(image.first_sample) - 0.5) * step_m;
  image.range_max_m = image.range_min_m + static_cast<double>(image.rows) * step_m;
  image.azimuth_rad = static_cast<double>(image.columns) * sonar.beam_spacing_rad;
  image.elevation_rad = sonar.elevation_fan_rad;
  return image;
}

// neusis_ngp compares heights on a square grid with x along the rows.
constexpr std::size_t kMostNgpPoints = 20'000;  // along a side

// The height map, and how neusis_ngp counts its points: (i, j) lies at
// (x_west_m + i spacing_m, y_south_m + j spacing_m), and i and j end at points - 1.
struct NgpMap {
  std::size_t rows = 0, columns = 0;  // as stored
  std::vector<float> heights_m;
  double spacing_m = 0, x_west_m = 0, y_south_m = 0;

  std::size_t points() const { return std::max(rows, columns); }
  // NaN: none.
  float at(std::size_t i, std::size_t j) const {
    if (i >= columns || j >= rows) return std::numeric_limits<float>::quiet_NaN();
    return heights_m[(rows - 1 - j) * columns + i];
  }
};

// None without a height map.
Result<std::optional<NgpMap>> ngp_map(const ExportJob& job, const StoredSequence& sequence) {
  const std::optional<HeightMap>& grid = sequence.manifest.info.height_map;
  if (!grid) return std::optional<NgpMap>();
  const auto file = stored_file(job.dataset, sequence.row.sequence, layout::kHeightMap);
  if (!file) return file.error();
  const GridSizes sizes = sequence.sizes();
  const auto stored = read_npy(*file, kNpyFloat32, {sizes.height_rows, sizes.height_columns});
  if (!stored) return stored.error();
  NgpMap map{sizes.height_rows, sizes.height_columns, values_in<float>(stored->data()),
             grid->spacing_m,   grid->x_west_m,       0};
  map.y_south_m = grid->y_north_m - static_cast<double>(map.rows - 1) * map.spacing_m;
  if (map.points() <= kMostNgpPoints) return std::optional(std::move(map));
  return refused_sequence(sequence,
                          fmt::format("its height map has {} points along a side; expected {} at "
                                      "most: use a larger output.height_map.spacing_m",
                                      map.points(), kMostNgpPoints));
}

// By the names of the section `mesh` of neusis_ngp's settings, whose reader rounds the number of
// points down.
Json map_limits(const NgpMap& map) {
  const double side_m = (static_cast<double>(map.points()) + 0.5) * map.spacing_m;
  float low = std::numeric_limits<float>::infinity(), high = -low;
  for (const float height_m : map.heights_m) {
    if (std::isnan(height_m)) continue;
    low = std::min(low, height_m);
    high = std::max(high, height_m);
  }
  return {{"x_min", map.x_west_m},        {"x_max", map.x_west_m + side_m},
          {"y_min", map.y_south_m},       {"y_max", map.y_south_m + side_m},
          {"z_min", number_or_null(low)}, {"z_max", number_or_null(high)},
          {"res", map.spacing_m}};
}

// For each ping the point of the map nearest to the sonar in x and y, as an altimeter sees it; none
// where the map has none.
Result<std::vector<double>> altimeter_points(const ExportJob& job, const StoredSequence& sequence,
                                             const NgpMap& map) {
  std::vector<double> points;
  const Status read = for_each_exported_ping(job, sequence, [&](const StoredPing& ping) -> Status {
    const Vec3 at = ping.sonar_in_world.position_m;
    const double i = std::round((at.x - map.x_west_m) / map.spacing_m);
    const double j = std::round((at.y - map.y_south_m) / map.spacing_m);
    const auto most = static_cast<double>(map.points());
    if (!(i >= 0 && i < most && j >= 0 && j < most)) return {};
    const float height_m = map.at(static_cast<std::size_t>(i), static_cast<std::size_t>(j));
    // NaN, or something above the sonar, which an altimeter does not see.
    if (!(height_m < at.z)) return {};
    points.insert(points.end(), {map.x_west_m + i * map.spacing_m,
                                 map.y_south_m + j * map.spacing_m, double{height_m}});
    return {};
  });
  if (!read) return read.error();
  return points;
}

Status write_ngp_files(const ExportJob& job, const StoredSequence& sequence, const NgpMap& map,
                       const fs::path& folder) {
  StreamedFile heights(folder / "heightmap_gt.npy");
  heights.append(npy_header(kNpyFloat32, {map.points(), map.points()}));
  for (std::size_t i = 0; i < map.points(); ++i) {
    std::string row;
    for (std::size_t j = 0; j < map.points(); ++j) put_value(row, map.at(i, j));
    heights.append(row);
  }
  if (const Status written = heights.close(); !written) return written;
  const auto points = altimeter_points(job, sequence, map);
  if (!points) return points.error();
  return write_whole(folder / "PC.npy", encode_npy(*points, {points->size() / 3, 3}));
}

// The distance field and the meshes, where the data set has them.
Status copy_truth(const ExportJob& job, const StoredSequence& sequence, const fs::path& folder) {
  const SequenceInfo& info = sequence.manifest.info;
  Status done;
  const auto copy = [&](const char* name, const char* to) {
    const auto file = stored_file(job.dataset, sequence.row.sequence, name);
    done = file ? copy_whole(*file, folder / to) : Status(file.error());
  };
  if (info.sdf) copy(layout::kSdf, layout::kSdf);
  if (done && info.output.world) copy(layout::kWorldPly, "mesh.ply");
  return done;
}

std::string neusis_config(const StoredSequence& sequence, const NeusisImage& image,
                          const std::optional<NgpMap>& map) {
  const Json configuration = {{"Azimuth", degrees(image.azimuth_rad)},
                              {"Elevation", degrees(image.elevation_rad)},
                              {"RangeMin", image.range_min_m},
                              {"RangeMax", image.range_max_m},
                              {"RangeBins", image.rows},
                              {"AzimuthBins", image.columns}};
  const Json sensor = {{"sensor_type", "ImagingSonar"},
                       {"sensor_name", "ImagingSonar"},
                       {"configuration", configuration}};
  const Json agent = {{"agent_name", "sonar"}, {"sensors", Json::array({sensor})}};
  Json config = {{"name", fmt::format("{:06}", sequence.row.sequence)},
                 {"agents", Json::array({agent})}};
  if (map) config["mesh"] = map_limits(*map);
  return json_text(config);
}

// The column before the first beam repeats it: the reader takes an empty one for free water.
std::vector<float> with_neusis_margins(const std::vector<float>& amplitudes, std::uint64_t beams,
                                       const NeusisImage& image) {
  std::vector<float> pixels(image.rows * image.columns);
  for (std::uint64_t row = 0; row < image.rows - kBlankedRows; ++row) {
    const float* const from = amplitudes.data() + (row + image.first_sample) * beams;
    float* const to = pixels.data() + row * image.columns;
    to[0] = from[0];
    std::copy_n(from, beams, to + 1);
  }
  return pixels;
}

template <class T>
std::string_view raw_bytes(const T& values) {
  const void* const data = values.data();
  return {static_cast<const char*>(data), values.size() * sizeof(values[0])};
}

Status write_neusis_sequence(const ExportJob& job, const fs::path& folder,
                             const StoredSequence& sequence, const DatasetScale& scale) {
  if (const Status fits = equal_beams(sequence); !fits) return fits;
  const NeusisImage image = neusis_image(sequence);
  const auto map = ngp_map(job, sequence);
  if (!map) return map.error();
  if (const Status done = write_whole(folder / "Config.json", neusis_config(sequence, image, *map));
      !done) {
    return done;
  }
  if (const Status done = copy_truth(job, sequence, folder); !done) return done;
  if (*map) {
    const Status done = write_ngp_files(job, sequence, **map, folder);
    if (!done) return done;
  }
  return for_each_exported_ping(job, sequence, [&](const StoredPing& ping) -> Status {
    const auto amplitudes = scaled_amplitudes(job, sequence, ping.ping, scale);
    if (!amplitudes) return amplitudes.error();
    const std::vector<float> pixels = with_neusis_margins(*amplitudes, sequence.beams, image);
    const std::array<double, 16> pose = matrix_of(ping.sonar_in_world);
    const auto pickle =
        encode_pickle({{"ImagingSonar", "f4", {image.rows, image.columns}, raw_bytes(pixels)},
                       {"PoseSensor", "f8", {4, 4}, raw_bytes(pose)}});
    if (!pickle) return refused_sequence(sequence, pickle.error().message);
    return write_whole(folder / "Data" / fmt::format("{:04}.pkl", ping.ping), *pickle);
  });
}

}  // namespace

Status write_neusis(const ExportJob& job, const fs::path& target) {
  const auto scale = scale_of_dataset(job);
  if (!scale) return scale.error();
  return for_each_sequence(job, [&](const StoredSequence& sequence) {
    return write_neusis_sequence(job, target / fmt::format("{:06}", sequence.row.sequence),
                                 sequence, *scale);
  });
}

}  // namespace ensonify
