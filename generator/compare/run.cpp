#include "compare/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <system_error>
#include <utility>

#include "compare/comparison_text.h"
#include "compare/page_text.h"
#include "compare/read_pings.h"
#include "formats/files.h"
#include "formats/json.h"
#include "formats/output_place.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

Error wrong(const std::string& what) { return {ErrorKind::usage, what}; }

void take_notes(std::vector<std::string>& notes, std::vector<std::string> more) {
  notes.insert(notes.end(), std::make_move_iterator(more.begin()),
               std::make_move_iterator(more.end()));
}

bool is_own_page(const fs::path& path) {
  std::string head(kComparePageMark.size(), '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  return file.gcount() == static_cast<std::streamsize>(head.size()) && head == kComparePageMark;
}

bool is_own_json(const fs::path& path) {
  const auto text = read_file(path, kMaxManifestBytes);
  const auto json = text ? parse_json(*text) : std::nullopt;
  return json && json->is_object() && json->contains("statistics") && json->contains("simulated");
}

Status check_outputs(const CompareOptions& options) {
  for (const auto* path : {&options.json, &options.page}) {
    if (path->empty()) continue;
    std::error_code error;
    if (!path->has_filename() || fs::is_directory(*path, error)) {
      return wrong(path->string() + ": is a folder; name the file to write");
    }
    for (const auto* folder : {&options.real, &options.simulated}) {
      if (lies_in(*path, *folder)) {
        return wrong(fmt::format("{}: lies in {}; name a place outside it", path->string(),
                                 folder->string()));
      }
    }
  }
  if (!options.json.empty() && !options.page.empty() && lies_in(options.json, options.page)) {
    return wrong("--json and --report: name two files");
  }
  const auto is_replaceable = [&](const fs::path& path, bool (*is_own)(const fs::path&)) {
    std::error_code error;
    return path.empty() || options.overwrite || !fs::exists(path, error) || is_own(path);
  };
  for (const auto& [path, is_own] :
       {std::pair(&options.json, &is_own_json), std::pair(&options.page, &is_own_page)}) {
    if (is_replaceable(*path, is_own)) continue;
    return wrong(path->string() +
                 ": already exists and was not written by ensonify compare; name another file, or "
                 "give --overwrite to replace it");
  }
  return {};
}

bool has_classes(const CompareOptions& options) {
  return !options.classes_real.empty() || !options.classes_simulated.empty() ||
         !options.objects.empty();
}

int comb_period_of(const CompareOptions& options, const PolarPings& real,
                   const PolarPings& simulated) {
  if (options.comb_period > 0) return options.comb_period;
  for (const PolarPings* pings : {&real, &simulated}) {
    if (pings->transmit_groups > 1) return pings->transmit_groups;
  }
  for (const int beams : {48, 64, 96, 128}) {
    if (real.beams() == beams) return beams / 16;
  }
  return 8;
}

struct Compared {
  Comparison comparison;
  std::vector<ExampleImage> real, simulated;
};

Result<Compared> compare_pings(const CompareOptions& options, const Workers& workers) {
  const bool classes = has_classes(options);
  const auto real =
      read_pings({options.real, options.amount, options.mask_real, options.bottom_real_m,
                  options.stop, ClassSource{classes, options.classes_real, options.objects}},
                 workers);
  if (!real) return real.error();
  const auto simulated = read_pings(
      {options.simulated, options.amount, options.mask_simulated, options.bottom_simulated_m,
       options.stop, ClassSource{classes, options.classes_simulated, options.objects}},
      workers);
  if (!simulated) return simulated.error();
  MeasureSettings settings = common_settings(real->pings, simulated->pings, workers);
  settings.comb_period = comb_period_of(options, real->pings, simulated->pings);
  if (!(settings.range_to > settings.range_from) ||
      !(settings.azimuth_to > settings.azimuth_from)) {
    return wrong(fmt::format("{} and {} have no ranges or no azimuths in common",
                             options.real.string(), options.simulated.string()));
  }
  const BlockStatistics a = measure_pings(real->pings, settings, workers);
  const BlockStatistics b = measure_pings(simulated->pings, settings, workers);
  Compared compared{compare_statistics(a, b, options.seed, workers), example_pings(real->pings),
                    example_pings(simulated->pings)};
  if (real->pings.from_counts != simulated->pings.from_counts) {
    compared.comparison.notes.push_back(fmt::format(
        "only {} has counts of a recorder (sonar.recorder); steps and limits of the other's levels "
        "are not those of an instrument",
        (real->pings.from_counts ? options.real : options.simulated).string()));
  }
  take_notes(compared.comparison.notes, real->notes);
  take_notes(compared.comparison.notes, simulated->notes);
  return compared;
}

Result<Compared> compare_crops(const CompareOptions& options, const Workers& workers) {
  if (!options.mask_real.empty() || !options.mask_simulated.empty()) {
    return wrong("--mask-real and --mask-simulated: are of polar images; crops have none");
  }
  if (has_classes(options)) {
    return wrong("--classes-real, --classes-simulated and --objects: crops have no masks");
  }
  if (options.bottom_real_m || options.bottom_simulated_m) {
    return wrong("--bottom-real and --bottom-simulated: crops have no poses");
  }
  const auto real =
      read_crops({options.real, options.amount, options.gamma, options.stop}, workers);
  if (!real) return real.error();
  const auto simulated =
      read_crops({options.simulated, options.amount, options.gamma, options.stop}, workers);
  if (!simulated) return simulated.error();
  const MeasureSettings settings = crop_settings();
  const BlockStatistics a = measure_crops(real->crops, settings, workers);
  const BlockStatistics b = measure_crops(simulated->crops, settings, workers);
  Compared compared{compare_statistics(a, b, options.seed, workers), example_crops(real->crops),
                    example_crops(simulated->crops)};
  take_notes(compared.comparison.notes, real->notes);
  take_notes(compared.comparison.notes, simulated->notes);
  return compared;
}

Result<Comparison> compare_both(const CompareOptions& options) {
  if (const Status fit = check_outputs(options); !fit) return fit.error();
  const Workers workers(options.threads);
  const bool real_set = is_dataset(options.real), simulated_set = is_dataset(options.simulated);
  if (real_set != simulated_set) {
    return wrong(
        fmt::format("{} is a data set and {} is not; compare two data sets or two folders "
                    "of crops (ensonify export --format crops makes them)",
                    (real_set ? options.real : options.simulated).string(),
                    (real_set ? options.simulated : options.real).string()));
  }
  if (real_set && options.gamma != 1) {
    return wrong("--gamma: is of the gray levels of crops; data sets hold levels in dB");
  }
  if (options.bottom_real_m.has_value() != options.bottom_simulated_m.has_value()) {
    return wrong("--bottom-real and --bottom-simulated: give both or neither");
  }
  auto compared = real_set ? compare_pings(options, workers) : compare_crops(options, workers);
  if (!compared) return compared.error();
  const std::string real = options.real.string(), simulated = options.simulated.string();
  if (!options.json.empty()) {
    const Status written =
        write_whole(options.json, comparison_json(compared->comparison, real, simulated));
    if (!written) return written.error();
  }
  if (!options.page.empty()) {
    const auto page = comparison_page(
        {compared->comparison, real, simulated, compared->real, compared->simulated});
    if (!page) return page.error();
    if (const Status written = write_whole(options.page, *page); !written) return written.error();
  }
  return std::move(compared->comparison);
}

}  // namespace

Result<Comparison> compare_folders(const CompareOptions& options) {
  return without_exceptions("comparing", [&] { return compare_both(options); });
}

}  // namespace ensonify
