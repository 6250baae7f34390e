#include "compare/read_pings.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "dataset/layout.h"
#include "dataset/read_dataset.h"
#include "dataset/read_pictures.h"
#include "formats/bytes.h"
#include "formats/npy.h"
#include "formats/png.h"
#include "instrument/recorder.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

Error refused_set(const fs::path& folder, const std::string& what) {
  return {ErrorKind::usage, folder.string() + ": " + what};
}

Result<std::vector<double>> axis_of(const StoredDataset& dataset, const StoredSequence& sequence,
                                    const char* name, std::uint64_t count) {
  const auto path = stored_file(dataset, sequence.row.sequence, name);
  if (!path) return path.error();
  const auto array = read_npy(*path, kNpyFloat64, {count});
  if (!array) return array.error();
  auto values = values_in<double>(array->data());
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (!(values[i] > values[i - 1])) return damaged(*path, "does not rise");
  }
  return values;
}

struct Axes {
  std::vector<double> range_m, azimuth_rad;
  friend bool operator==(const Axes&, const Axes&) = default;
};

Result<Axes> axes_of(const StoredDataset& dataset, const StoredSequence& sequence) {
  auto range = axis_of(dataset, sequence, "range_m.npy", sequence.samples);
  if (!range) return range.error();
  auto azimuth = axis_of(dataset, sequence, "azimuth_rad.npy", sequence.beams);
  if (!azimuth) return azimuth.error();
  return Axes{std::move(*range), std::move(*azimuth)};
}

const CatalogueRow* counts_row_of(const StoredSequence& sequence) {
  if (!sequence.manifest.info.recorder) return nullptr;
  for (const char* file : {layout::kRecorded8, layout::kRecorded16}) {
    const CatalogueRow* row = find_file(FileScope::ping, file);
    if (row != nullptr && sequence.has(*row)) return row;
  }
  return nullptr;
}

// The levels of a detector do not follow from the time series alone.
bool has_levels(const StoredSequence& sequence) {
  return counts_row_of(sequence) != nullptr ||
         sequence.has(plane_row(ImageView::polar, "level_db")) ||
         (has_series(sequence) && !sequence.manifest.info.sonar.detector);
}

// From the counts of the recorder, whose steps the levels of images do not show.
Result<std::vector<float>> recorded_amplitudes(const StoredDataset& dataset,
                                               const StoredSequence& sequence,
                                               const CatalogueRow& row, std::uint32_t ping) {
  CellReader reader(dataset, sequence, ping);
  const auto bytes = reader.read(row);
  if (!bytes) return bytes.error();
  const CatalogueRow* const gain_row = find_file(FileScope::ping, layout::kRecordedRowGain);
  std::vector<float> gains;
  if (gain_row != nullptr && sequence.has(*gain_row)) {
    const auto gain_bytes = reader.read(*gain_row);
    if (!gain_bytes) return gain_bytes.error();
    gains = values_in<float>(*gain_bytes);
  }
  const Recorder& recorder = *sequence.manifest.info.recorder;
  std::vector<std::uint16_t> counts;
  if (row.type == std::string_view(kNpyUint8)) {
    const auto small = values_in<std::uint8_t>(*bytes);
    counts.assign(small.begin(), small.end());
  } else {
    counts = values_in<std::uint16_t>(*bytes);
  }
  std::vector<float> amplitudes(counts.size());
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const std::size_t sample = i / sequence.beams;
    const double gain = sample < gains.size() ? static_cast<double>(gains[sample]) : 1;
    amplitudes[i] = recorded_amplitude(recorder, counts[i], gain);
  }
  return amplitudes;
}

Result<std::vector<float>> amplitudes_of(const StoredDataset& dataset,
                                         const StoredSequence& sequence, std::uint32_t ping) {
  if (const CatalogueRow* const counts = counts_row_of(sequence)) {
    return recorded_amplitudes(dataset, sequence, *counts, ping);
  }
  if (sequence.has(plane_row(ImageView::polar, "level_db"))) {
    auto pixels = read_picture(dataset, sequence, ImageView::polar, ping, {"level_db"});
    if (!pixels) return pixels.error();
    for (float& value : pixels->level_db) value = amplitude_of_level(value);
    return std::move(pixels->level_db);
  }
  const auto series = read_series(dataset, sequence, ping);
  if (!series) return series.error();
  std::vector<float> amplitudes(series->size());
  for (std::size_t beam = 0; beam < sequence.beams; ++beam) {
    for (std::size_t sample = 0; sample < sequence.samples; ++sample) {
      amplitudes[sample * sequence.beams + beam] =
          std::abs((*series)[beam * sequence.samples + sample]);
    }
  }
  return amplitudes;
}

struct Opened {
  StoredDataset dataset;
  std::vector<StoredSequence> sequences;  // of one grid
  Axes axes;
  std::vector<std::string> notes;
};

Result<Opened> open_pings(const PingSource& source) {
  auto dataset = open_dataset(source.dataset);
  if (!dataset) return dataset.error();
  Opened opened{std::move(*dataset), {}, {}, {}};
  std::size_t others = 0;
  for (const StoredSequenceRow& row : opened.dataset.sequences) {
    auto sequence = read_sequence(opened.dataset, row);
    if (!sequence) return sequence.error();
    if (!has_levels(*sequence)) {
      return refused_set(
          source.dataset,
          std::string(sequence->manifest.info.sonar.detector
                          ? "its pings have no polar levels, and those of sonar.detector do not "
                            "follow from time series"
                          : "its pings have neither polar levels nor time series, which a "
                            "comparison needs") +
              "; generate the data set with output.polar: true");
    }
    auto axes = axes_of(opened.dataset, *sequence);
    if (!axes) return axes.error();
    if (opened.sequences.empty()) opened.axes = *axes;
    if (!(*axes == opened.axes)) {
      ++others;
    } else if (row.pings() > 0) {
      opened.sequences.push_back(std::move(*sequence));
    }
  }
  if (opened.sequences.empty()) return refused_set(source.dataset, "has no pings");
  if (others > 0) {
    opened.notes.push_back(fmt::format(
        "{}: {} of {} sequences have other ranges or azimuths than the first and are not used",
        source.dataset.string(), others, opened.dataset.sequences.size()));
  }
  return opened;
}

Status read_mask(const PingSource& source, PolarPings& pings) {
  if (source.mask.empty()) return {};
  const auto bytes = read_file(source.mask);
  if (!bytes) return bytes.error();
  auto image = parse_grey_png(*bytes);
  if (!image) {
    return Error{ErrorKind::usage, source.mask.string() + ": " + image.error().message};
  }
  if (image->grey8.empty() || image->rows != pings.range_m.size() ||
      image->columns != pings.azimuth_rad.size()) {
    return Error{ErrorKind::usage,
                 fmt::format("{}: expected an 8-bit image of {} rows (samples) and {} columns "
                             "(beams), as the polar images",
                             source.mask.string(), pings.range_m.size(), pings.azimuth_rad.size())};
  }
  pings.use = std::move(image->grey8);
  return {};
}

// Times and heights of the pings of all runs, in their order.
Status read_tables(const PingSource& source, const Opened& opened, const std::vector<PingRun>& runs,
                   PolarPings& pings) {
  for (std::size_t s = 0; s < opened.sequences.size(); ++s) {
    std::map<std::uint32_t, std::pair<double, double>> of_ping;  // time, height of the sonar
    const Status read =
        for_each_ping(opened.dataset, opened.sequences[s], [&](const StoredPing& ping) -> Status {
          of_ping[ping.ping] = {ping.time_s, ping.sonar_in_world.position_m.z};
          return {};
        });
    if (!read) return read;
    for (const PingRun& run : runs) {
      if (run.sequence != s) continue;
      for (std::uint32_t p = run.first; p < run.first + run.count; ++p) {
        const auto found = of_ping.find(p);
        const auto [time, z] = found == of_ping.end() ? std::pair(0.0, 0.0) : found->second;
        pings.time_s.push_back(time);
        if (source.bottom_z_m) pings.height_m.push_back(z - *source.bottom_z_m);
      }
    }
  }
  return {};
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> pings_of(const Opened& opened) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pings;
  for (const StoredSequence& sequence : opened.sequences) {
    pings.emplace_back(sequence.row.first_ping, sequence.row.last_ping);
  }
  return pings;
}

Result<ReadPings> read_opened(const PingSource& source, const Workers& workers) {
  auto opened = open_pings(source);
  if (!opened) return opened.error();
  const std::vector<PingRun> runs = ping_runs(pings_of(*opened), source.amount);
  if (runs.size() < 2) {
    return refused_set(source.dataset, "has too few pings; errors need 2 blocks of pings or more");
  }
  ReadPings read;
  read.notes = std::move(opened->notes);
  const StoredSequence& first = opened->sequences.front();
  read.pings.from_counts = counts_row_of(first) != nullptr;
  if (read.pings.from_counts) read.recorder = first.manifest.info.recorder;
  PolarPings& pings = read.pings;
  pings.transmit_groups = beams_of_group(first.manifest.info.sonar, 0).step;
  pings.range_m = opened->axes.range_m;
  pings.azimuth_rad = opened->axes.azimuth_rad;
  if (const Status mask = read_mask(source, pings); !mask) return mask.error();
  if (const Status tables = read_tables(source, *opened, runs, pings); !tables) {
    return tables.error();
  }
  std::vector<PingPlace> places;
  for (std::size_t b = 0; b < runs.size(); ++b) {
    for (std::uint32_t i = 0; i < runs[b].count; ++i) {
      places.emplace_back(runs[b].sequence, runs[b].first + i);
      pings.block.push_back(static_cast<std::uint32_t>(b));
    }
  }
  pings.amplitude.resize(places.size());
  std::vector<Status> statuses(places.size());
  workers.for_each(places.size(), [&](std::size_t i) {
    if (source.stop != nullptr && source.stop()) {
      statuses[i] = Error{ErrorKind::interrupted, "interrupted"};
      return;
    }
    auto amplitude =
        amplitudes_of(opened->dataset, opened->sequences[places[i].first], places[i].second);
    if (amplitude) {
      pings.amplitude[i] = std::move(*amplitude);
    } else {
      statuses[i] = amplitude.error();
    }
  });
  for (const Status& status : statuses) {
    if (!status) return status.error();
  }
  auto classes = read_classes(source.classes, opened->dataset, opened->sequences, places, workers);
  if (!classes) return classes.error();
  pings.classes = std::move(*classes);
  return read;
}

}  // namespace

Result<ReadPings> read_pings(const PingSource& source, const Workers& workers) {
  return without_exceptions("reading " + source.dataset.string(),
                            [&] { return read_opened(source, workers); });
}

bool is_dataset(const fs::path& folder) {
  std::error_code error;
  return fs::exists(folder / layout::kDatasetJson, error) ||
         fs::exists(folder / layout::kWorkJson, error);
}

}  // namespace ensonify
