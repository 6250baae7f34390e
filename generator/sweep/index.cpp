#include "sweep/index.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <iterator>
#include <set>
#include <utility>
#include <vector>

#include "core/units.h"
#include "dataset/layout.h"
#include "dataset/read_dataset.h"
#include "dataset/read_pictures.h"
#include "formats/bytes.h"
#include "formats/csv.h"
#include "formats/files.h"
#include "formats/json.h"
#include "formats/npy.h"
#include "formats/sha256.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

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

// What is read: a sequence of a finished run.
struct RunSequence {
  const StoredDataset& dataset;
  StoredSequence stored;

  Result<NpyArray> array(const char* name, const char* type, const NpyShape& shape) const {
    const auto path = stored_file(dataset, stored.row.sequence, name);
    if (!path) return path.error();
    return read_npy(*path, type, shape);
  }
};

Status add_series(const RunSequence& run, std::uint32_t ping, Sums& sums) {
  const auto series = read_series(run.dataset, run.stored, ping);
  if (!series) return series.error();
  for (const std::complex<float>& p : *series) {
    sums.add_intensity(double{p.real()} * p.real() + double{p.imag()} * p.imag());
  }
  return {};
}

Status add_image(const RunSequence& run, std::uint32_t ping, Sums& sums) {
  const auto image = read_picture(run.dataset, run.stored, ImageView::polar, ping, {"level_db"});
  if (!image) return image.error();
  for (const float level_db : image->level_db) {
    sums.add_intensity(std::isfinite(level_db) ? mean_square_pa2(level_db) : 0);
  }
  return {};
}

Status add_levels(const RunSequence& run, Sums& sums) {
  // A file that the sequence should have but does not is an error, not a gap.
  const bool series = run.stored.has(*find_file(FileScope::ping, layout::kTimeseries));
  if (!series && !run.stored.has(layout::kPolarExr)) return {};
  const StoredSequenceRow& row = run.stored.row;
  for (std::uint32_t ping = row.first_ping; ping < row.last_ping; ++ping) {
    const Status added = series ? add_series(run, ping, sums) : add_image(run, ping, sums);
    if (!added) return added;
  }
  return {};
}

Status add_first_returns(const RunSequence& run, Sums& sums) {
  if (!is_sonar(run.stored.manifest.info)) return {};
  const auto ranges =
      run.array("first_return_m.npy", kNpyFloat32, {run.stored.row.pings(), run.stored.beams});
  if (!ranges) return ranges.error();
  for (const float range_m : values_in<float>(ranges->data())) {
    if (std::isnan(range_m)) continue;
    sums.first_return_m += range_m;
    sums.returns += 1;
  }
  return {};
}

// Runs of a mask alternate between pixels outside and inside.
double pixels_of(const StoredAnnotation& annotation) {
  double sum = 0;
  for (std::size_t i = 1; i < annotation.runs.size(); i += 2) {
    sum += static_cast<double>(annotation.runs[i]);
  }
  return sum;
}

Status add_labels(const RunSequence& run, Sums& sums) {
  return for_each_ping(run.dataset, run.stored, [&](const StoredPing& ping) -> Status {
    const auto pictures = pictures_of(run.dataset, run.stored, ping);
    if (!pictures) return pictures.error();
    for (const StoredPicture& picture : *pictures) {
      for (const StoredAnnotation& annotation : picture.annotations) {
        sums.instances.insert(annotation.instance);
      }
    }
    if (pictures->empty()) return {};
    sums.imaged_pings += 1;
    for (const StoredAnnotation& annotation : pictures->front().annotations) {
      sums.labelled_px += pixels_of(annotation);
    }
    return {};
  });
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

Result<Coherences> read_coherences(const RunSequence& run) {
  const std::uint64_t rows = run.stored.samples, columns = run.stored.beams;
  const auto bins = run.array("statistics/bin_coherence.npy", kNpyComplex128, {rows - 1, columns});
  if (!bins) return bins.error();
  const auto beams =
      run.array("statistics/beam_coherence.npy", kNpyComplex128, {rows, columns - 1});
  if (!beams) return beams.error();
  return Coherences{values_in<std::complex<double>>(bins->data()),
                    values_in<std::complex<double>>(beams->data())};
}

// From the mean over pixels of the squared contrast over n realizations. Its expectation is
// n / (n / C^2 + 1) if intensities have a gamma distribution (docs/physics/4_speckle.md).
double unbiased_squared_contrast(double mean_square, double n) {
  return mean_square / (1 - mean_square / n);
}

// With `levels`, for a sequence that keeps no levels itself.
Status add_statistics(const RunSequence& run, bool levels, Sums& sums) {
  const auto intensity = read_statistics(run.dataset, run.stored, "mean_intensity");
  if (!intensity) return intensity.error();
  const auto contrast = read_statistics(run.dataset, run.stored, "contrast");
  if (!contrast) return contrast.error();
  const auto coherences = read_coherences(run);
  if (!coherences) return coherences.error();
  double highest = 0, sum = 0, count = 0;
  for (const double value : *intensity) highest = std::max(highest, value);
  std::vector<bool> mask(intensity->size());
  for (std::size_t i = 0; i < mask.size(); ++i) {
    mask[i] = (*intensity)[i] > 0.01 * highest && std::isfinite((*contrast)[i]);
    if (mask[i]) sum += (*contrast)[i] * (*contrast)[i];
    count += mask[i];
  }
  for (const double value : *intensity) {
    if (levels) sums.add_intensity(value);
  }
  if (count == 0) return {};
  const double many = correlated_pixels(*coherences, mask, run.stored.samples, run.stored.beams);
  const auto n = static_cast<double>(run.stored.manifest.realisations);
  const double squared = unbiased_squared_contrast(sum / count, n);
  sums.contrast += std::sqrt(squared);
  sums.variance += squared * n * n / ((n - 1) * (n + 2) * (n + 3)) * many / count;
  sums.ensembles += 1;
  return {};
}

Status add_sequence(const RunSequence& run, Sums& sums) {
  const double noise_pa2 = run.stored.manifest.info.noise_power_pa2;
  if (noise_pa2 > 0) {
    const auto pings = static_cast<double>(run.stored.row.pings());
    sums.noise_pa2 += pings * noise_pa2;
    sums.noisy_pings += pings;
  }
  const double pixels_before = sums.pixels;
  if (Status added = add_levels(run, sums); !added) return added;
  const bool has_levels = sums.pixels > pixels_before;
  if (Status added = add_first_returns(run, sums); !added) return added;
  if (Status added = add_labels(run, sums); !added) return added;
  if (run.stored.manifest.realisations == 0) return {};
  return add_statistics(run, !has_levels, sums);
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
      auto sequence = read_sequence(*dataset, row);
      if (!sequence) return sequence.error();
      const Status added = add_sequence({*dataset, std::move(*sequence)}, sums);
      if (!added) return added.error();
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
