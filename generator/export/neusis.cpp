// SEQUENCE/Config.json and SEQUENCE/Data/PPPP.pkl, the layout of neusis (Qadri, Kaess and
// Gkioulekas, "Neural implicit surface reconstruction using imaging sonar", 2023); SEQUENCE/sdf.vdb
// where the data set has one.
//
// The reader takes pixel (i, j) to lie between RangeMin + i d and RangeMin + (i + 1) d, with
// d = (RangeMax - RangeMin) / rows, and at the azimuth -Azimuth / 2 + j Azimuth / columns. Images
// have one column more than beams, before the first, so that column j + 1 lies at the azimuth of
// beam j. The reader blanks the last 200 rows: as many are added.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "dataset/layout.h"
#include "export/posed_images.h"
#include "formats/json.h"
#include "formats/output.h"
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
  // A recording has no rays.
  image.elevation_rad =
      sonar.elevation_fan_rad > 0 ? sonar.elevation_fan_rad : sonar.elevation_width_rad;
  return image;
}

std::string neusis_config(const StoredSequence& sequence, const NeusisImage& image) {
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
  return json_text(
      {{"name", fmt::format("{:06}", sequence.row.sequence)}, {"agents", Json::array({agent})}});
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

Status write_neusis_sequence(const ExportJob& job, const fs::path& folder, const StoredSequence& sequence,
                      const DatasetScale& scale) {
  if (const Status fits = equal_beams(sequence); !fits) return fits;
  const NeusisImage image = neusis_image(sequence);
  Status done = write_whole(folder / "Config.json", neusis_config(sequence, image));
  if (done && sequence.manifest.info.sdf) {
    const auto sdf = stored_file(job.dataset, sequence.row.sequence, layout::kSdf);
    done = sdf ? copy_whole(*sdf, folder / layout::kSdf) : Status(sdf.error());
  }
  if (!done) return done;
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
    return write_neusis_sequence(job, target / fmt::format("{:06}", sequence.row.sequence), sequence,
                          *scale);
  });
}

}  // namespace ensonify
