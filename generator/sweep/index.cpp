#include "sweep/index.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstring>
#include <iterator>
#include <set>
#include <string_view>
#include <vector>

#include "core/units.h"
#include "dataset/layout.h"
#include "dataset/read_dataset.h"
#include "formats/csv.h"
#include "formats/exr.h"
#include "formats/files.h"
#include "formats/half_floats.h"
#include "formats/json.h"
#include "formats/npy.h"
#include "formats/sha256.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

struct RunPlace {
  fs::path folder;  // of the sequence
  StoredSequenceRow row;
  Json head;  // sequence.json without its files
};

struct Sums {
  double intensity_pa2 = 0, max_pa2 = 0, pixels = 0;
  double noise_pa2 = 0, noisy_pings = 0;
  double first_return_m = 0, returns = 0;
  double labelled_px = 0, imaged_pings = 0;
  std::set<std::uint64_t> instances;
  double contrast = 0, variance = 0, ensembles = 0;

  void add_intensity(double value_pa2) {
    intensity_pa2 += value_pa2;
    max_pa2 = std::max(max_pa2, value_pa2);
    pixels += 1;
  }
};

template <class T>
Result<std::vector<T>> read_array(const fs::path& path, std::string_view descr) {
  const auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  const auto header = parse_npy_header(*bytes);
  if (!header || header->descr != descr)
    return damaged(path, "is not an array of the expected type");
  std::uint64_t count = 1;
  for (const std::uint64_t size : header->shape) count *= size;
  if (bytes->size() != header->data_offset + count * sizeof(T)) {
    return damaged(path, "has another size than its header states");
  }
  std::vector<T> values(count);
  std::memcpy(values.data(), bytes->data() + header->data_offset, count * sizeof(T));
  return values;
}

Status add_series(const fs::path& path, Sums& sums) {
  const auto series = read_array<std::complex<float>>(path, kNpyComplex64);
  if (!series) return series.error();
  for (const std::complex<float>& p : *series) {
    sums.add_intensity(double{p.real()} * p.real() + double{p.imag()} * p.imag());
  }
  return {};
}

Status add_image(const fs::path& path, int rows, int columns, Sums& sums) {
  const auto image = read_exr_halves(path, rows, columns);
  if (!image) return image.error();
  const std::vector<std::uint16_t>& halves = image->at("level_db");
  std::vector<float> levels(halves.size());
  from_halves(halves, levels);
  for (const float level_db : levels) {
    sums.add_intensity(std::isfinite(level_db) ? mean_square_pa2(level_db) : 0);
  }
  return {};
}

int count_in(const Json& head, const char* pointer) {
  return head.value(Json::json_pointer(pointer), 0);
}

Status add_levels(const RunPlace& place, Sums& sums) {
  const Json arrays = place.head.value("arrays", Json());
  if (arrays.is_object() && arrays.contains("timeseries.npy")) {
    return add_series(place.folder / "timeseries.npy", sums);
  }
  const int rows = count_in(place.head, "/record/samples");
  const int columns = count_in(place.head, "/sonar/beams/count");
  // A file that the sequence should have but does not is an error, not a gap.
  const Json files = place.head.value("each_ping", Json::array());
  const auto has = [&](const char* kind) {
    return std::find(files.begin(), files.end(), kind) != files.end();
  };
  const bool has_series = has(layout::kTimeseries);
  if (!has_series && !has(layout::kPolarExr)) return {};
  for (std::uint32_t ping = place.row.first_ping; ping < place.row.last_ping; ++ping) {
    const fs::path series = place.folder / layout::ping_file(layout::kTimeseries, ping);
    const fs::path polar = place.folder / layout::ping_file(layout::kPolarExr, ping);
    const Status added =
        has_series ? add_series(series, sums) : add_image(polar, rows, columns, sums);
    if (!added) return added;
  }
  return {};
}

Status add_first_returns(const RunPlace& place, Sums& sums) {
  const auto ranges = read_array<float>(place.folder / "first_return_m.npy", kNpyFloat32);
  if (!ranges) return ranges.error();
  for (const float range_m : *ranges) {
    if (std::isnan(range_m)) continue;
    sums.first_return_m += range_m;
    sums.returns += 1;
  }
  return {};
}

Status add_labels(const RunPlace& place, Sums& sums) {
  const fs::path path = place.folder / layout::kAnnotations;
  const auto text = read_file(path);
  if (!text) return text.error();
  for (std::size_t at = 0; at < text->size();) {
    const std::size_t end = std::min(text->find('\n', at), text->size());
    const Json line = parse_shallow(std::string_view(*text).substr(at, end - at));
    at = end + 1;
    if (!line.is_object()) return damaged(path, "has a line that is not JSON");
    bool first = true;
    for (const Json& image : line.value("images", Json::array())) {
      for (const Json& annotation : image.value("annotations", Json::array())) {
        sums.instances.insert(annotation.value("instance", std::uint64_t{0}));
        if (first) sums.labelled_px += annotation.value("area", 0.0);
      }
      if (first) sums.imaged_pings += 1;
      first = false;
    }
  }
  return {};
}

// How many correlated pixels count as one along a direction. |coherence| is assumed to decrease
// with the square of the distance in the exponent, and estimates to be correlated by its fourth
// power.
double correlated(const std::vector<std::complex<double>>& coherence,
                  const std::vector<bool>& pair) {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < coherence.size(); ++i) {
    if (!pair[i]) continue;
    sum += std::abs(coherence[i]);
    count += 1;
  }
  const double near = count > 0 ? sum / count : 0;
  double factor = 1;
  for (int lag = 1; lag < 64; ++lag) factor += 2 * std::pow(near, 4.0 * lag * lag);
  return factor;
}

struct Coherences {
  std::vector<std::complex<double>> bins, beams;
};

// For pixels [rows x columns], of which `mask` selects some.
double correlated_pixels(const Coherences& coherence, const std::vector<bool>& mask,
                         std::size_t rows, std::size_t columns) {
  std::vector<bool> below, beside;
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      const std::size_t i = row * columns + column;
      if (row + 1 < rows) below.push_back(mask[i] && mask[i + columns]);
      if (column + 1 < columns) beside.push_back(mask[i] && mask[i + 1]);
    }
  }
  return correlated(coherence.bins, below) * correlated(coherence.beams, beside);
}

// With `levels`, for a sequence that keeps no levels itself.
Status add_statistics(const RunPlace& place, bool levels, Sums& sums) {
  const fs::path folder = place.folder / "statistics";
  const auto intensity = read_array<double>(folder / "mean_intensity.npy", kNpyFloat64);
  const auto contrast = read_array<double>(folder / "contrast.npy", kNpyFloat64);
  const auto bins = read_array<std::complex<double>>(folder / "bin_coherence.npy", kNpyComplex128);
  const auto beams =
      read_array<std::complex<double>>(folder / "beam_coherence.npy", kNpyComplex128);
  if (!intensity) return intensity.error();
  if (!contrast) return contrast.error();
  if (!bins) return bins.error();
  if (!beams) return beams.error();
  const auto rows = static_cast<std::size_t>(count_in(place.head, "/record/samples"));
  const auto columns = static_cast<std::size_t>(count_in(place.head, "/sonar/beams/count"));
  const std::size_t pixels = rows * columns;
  if (pixels == 0 || intensity->size() != pixels || contrast->size() != pixels ||
      bins->size() != pixels - columns || beams->size() != pixels - rows) {
    return damaged(folder, "has arrays of another size than its sequence.json states");
  }
  double highest = 0, sum = 0, count = 0;
  for (const double value : *intensity) highest = std::max(highest, value);
  std::vector<bool> mask(pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    mask[i] = (*intensity)[i] > 0.01 * highest && std::isfinite((*contrast)[i]);
    if (mask[i]) sum += (*contrast)[i];
    count += mask[i];
  }
  for (const double value : *intensity) {
    if (levels) sums.add_intensity(value);
  }
  const double realisations = count_in(place.head, "/statistics/realisations");
  if (count == 0 || realisations == 0) return {};
  const double many = correlated_pixels({*bins, *beams}, mask, rows, columns);
  sums.contrast += sum / count;
  sums.variance += many / (count * realisations);
  sums.ensembles += 1;
  return {};
}

Result<Json> read_head(const fs::path& path) {
  const auto text = read_file(path);
  if (!text) return text.error();
  // Skips the list of files, which makes the file long.
  const auto keep = [](int depth, Json::parse_event_t event, Json& parsed) {
    return !(depth == 1 && event == Json::parse_event_t::key && parsed == "files");
  };
  Json head = parse_shallow_with(keep, *text);
  if (!head.is_object()) return damaged(path, "is not JSON");
  return head;
}

Status add_sequence(const RunPlace& place, Sums& sums) {
  const auto pings = static_cast<double>(place.row.pings());
  const Json power = place.head.value("/noise/power_pa2"_json_pointer, Json());
  if (power.is_number()) {
    sums.noise_pa2 += pings * power.get<double>();
    sums.noisy_pings += pings;
  }
  const double pixels_before = sums.pixels;
  if (Status added = add_levels(place, sums); !added) return added;
  const bool has_levels = sums.pixels > pixels_before;
  if (Status added = add_first_returns(place, sums); !added) return added;
  if (Status added = add_labels(place, sums); !added) return added;
  if (!place.head.contains("statistics")) return {};
  return add_statistics(place, !has_levels, sums);
}

std::optional<double> level_of(double intensity_pa2) {
  if (!(intensity_pa2 > 0)) return std::nullopt;
  return level_db(intensity_pa2);
}

RunResults results_of(const Sums& sums) {
  RunResults results;
  if (sums.pixels > 0) {
    results.mean_level_db = level_of(sums.intensity_pa2 / sums.pixels);
    results.max_level_db = level_of(sums.max_pa2);
  }
  if (sums.noisy_pings > 0) results.noise_level_db = level_of(sums.noise_pa2 / sums.noisy_pings);
  if (sums.returns > 0) results.first_return_m = sums.first_return_m / sums.returns;
  if (sums.imaged_pings > 0) {
    results.labelled_px = sums.labelled_px / sums.imaged_pings;
    results.instances = sums.instances.size();
  }
  if (sums.ensembles > 0) {
    results.contrast = sums.contrast / sums.ensembles;
    results.contrast_se = std::sqrt(sums.variance) / sums.ensembles;
  }
  return results;
}

constexpr const char* kBefore[] = {"run", "name"};
constexpr const char* kAfter[] = {
    "seed",           "pings",          "folder",      "status",    "mean_level_db", "max_level_db",
    "noise_level_db", "first_return_m", "labelled_px", "instances", "contrast",      "contrast_se"};

bool is_result(const std::string& name) {
  const auto same = [&](const char* other) { return name == other; };
  return std::any_of(std::begin(kBefore), std::end(kBefore), same) ||
         std::any_of(std::begin(kAfter), std::end(kAfter), same);
}

// A name that no result and no other axis has.
std::string column_of(const std::string& axis, const PlannedRun& run) {
  const auto is_axis = [&](const std::string& name) {
    return std::any_of(run.values.begin(), run.values.end(),
                       [&](const auto& value) { return value.first == name; });
  };
  std::string name = axis;
  while (is_result(name) || (name != axis && is_axis(name))) name = "axis_" + name;
  return name;
}

// A text unchanged, any other value as JSON.
std::string value_cell(const std::string& json_text) {
  const Json json = parse_shallow(json_text);
  return csv_cell(json.is_string() ? json.get<std::string>() : json_text);
}

std::string number(const std::optional<double>& value) {
  return value ? fmt::format("{:.6g}", *value) : "";
}

std::string row_of(const PlannedRun& run, const FinishedRun& finished) {
  std::vector<std::string> cells = {run.id, csv_cell(run.name)};
  for (const auto& [axis, value] : run.values) cells.push_back(value_cell(value));
  const RunResults& r = finished.results;
  cells.insert(cells.end(),
               {fmt::format("{}", run.seed), fmt::format("{}", run.pings), run_folder(run.id),
                state_name(finished.state), number(r.mean_level_db), number(r.max_level_db),
                number(r.noise_level_db), number(r.first_return_m), number(r.labelled_px),
                r.instances ? fmt::format("{}", *r.instances) : "", number(r.contrast),
                number(r.contrast_se)});
  return fmt::format("{}\n", fmt::join(cells, ","));
}

}  // namespace

Result<RunResults> read_results(const fs::path& dir) {
  const auto dataset = open_dataset(dir);
  if (!dataset) return dataset.error();
  return without_exceptions("reading " + dir.string(), [&]() -> Result<RunResults> {
    Sums sums;
    for (const StoredSequenceRow& row : dataset->sequences) {
      RunPlace place{dir / layout::sequence_folder(row.sequence), row, {}};
      auto head = read_head(place.folder / layout::kSequenceJson);
      if (!head) return head.error();
      place.head = std::move(*head);
      if (Status added = add_sequence(place, sums); !added) return added.error();
    }
    return results_of(sums);
  });
}

std::string runs_csv(const Plan& plan, const std::vector<FinishedRun>& runs) {
  std::vector<std::string> columns(std::begin(kBefore), std::end(kBefore));
  if (!plan.empty()) {
    for (const auto& [axis, value] : plan.front().values)
      columns.push_back(column_of(axis, plan.front()));
  }
  columns.insert(columns.end(), std::begin(kAfter), std::end(kAfter));
  std::string text = fmt::format("{}\n", fmt::join(columns, ","));
  for (std::size_t i = 0; i < plan.size(); ++i) text += row_of(plan[i], runs[i]);
  return text;
}

std::string index_json(const SweepHead& head, const Plan& plan,
                       const std::vector<FinishedRun>& runs) {
  Json listed = Json::array(), failed = Json::array();
  std::size_t done = 0;
  for (std::size_t i = 0; i < plan.size(); ++i) {
    const FinishedRun& run = runs[i];
    const bool whole = run.state == RunState::done;
    done += whole;
    listed.push_back({{"run", plan[i].id},
                      {"name", plan[i].name},
                      {"status", state_name(run.state)},
                      {"folder", run_folder(plan[i].id)},
                      {"dataset_sha256", whole ? Json(run.dataset_sha256) : Json()}});
    if (!run.failure) continue;
    failed.push_back({{"run", plan[i].id},
                      {"name", plan[i].name},
                      {"kind", run.failure->kind},
                      {"message", run.failure->message}});
  }
  const Json json = {
      {"ensonify_sweep_index", 1},
      {"name", head.name},
      {"program", {{"version", head.program_version}, {"commit", head.program_commit}}},
      {"plan_sha256", sha256_hex(to_jsonl(plan))},
      {"complete", done == plan.size()},
      {"runs", std::move(listed)},
      {"failed", std::move(failed)}};
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

bool has_whole_tables(const fs::path& dir, const Plan& plan) {
  const auto text = read_file(dir / kIndexFile);
  if (!text || !fs::exists(dir / kRunsFile)) return false;
  const Json index = parse_shallow(*text);
  return index.is_object() && index.value("complete", Json()) == true &&
         index.value("plan_sha256", Json()) == sha256_hex(to_jsonl(plan));
}

}  // namespace ensonify
