#include "report/sweep_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/units.h"
#include "formats/csv.h"
#include "formats/files.h"
#include "formats/json.h"
#include "formats/output_place.h"
#include "report/page_text.h"
#include "report/small_picture.h"
#include "sweep/index.h"
#include "sweep/status.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t kMostPictures = 1000;  // sweeps with more runs show so many, evenly spaced
constexpr double kAllPixels = 14e6;            // of all images; a pixel takes about 0.7 bytes
constexpr double kLeastSide = 96, kMostSide = 360;

// What the page shows of a run besides its row in the table.
struct ShownRun {
  FinishedRun of;
  std::optional<SmallPicture> picture;
  std::string what;    // the picture shows: "ping 0 of sequence 0"
  std::string reason;  // why it has neither numbers nor an image
};

// Levels of the first ping, or of the mean over realizations; empty if there are none.
Result<std::vector<float>> levels_of_run(const StoredDataset& dataset, const ShownSequence& shown,
                                         const Workers& workers, std::string& what) {
  const StoredSequence& sequence = shown.stored;
  if (has_levels(sequence)) {
    what = fmt::format("ping {} of sequence {}", sequence.row.first_ping, sequence.row.sequence);
    return levels_of_ping(dataset, shown, sequence.row.first_ping, workers);
  }
  if (shown.facts.realisations == 0) return std::vector<float>();
  what = fmt::format("mean intensity of {} realizations", shown.facts.realisations);
  const auto intensity = read_statistics(dataset, sequence, "mean_intensity");
  if (!intensity) return intensity.error();
  std::vector<float> levels;
  for (const double pa2 : *intensity) levels.push_back(image_level_db(static_cast<float>(pa2)));
  return levels;
}

// The first ping of the first sequence, or the mean intensity of its statistics; none if the data
// set has neither. At most `side` rows and columns.
Result<std::optional<SmallPicture>> picture_of_run(const fs::path& dir, std::size_t side,
                                                   const Workers& workers, std::string& what) {
  std::optional<SmallPicture> picture;
  const auto dataset = open_dataset(dir);
  if (!dataset) return dataset.error();
  if (dataset->sequences.empty()) return picture;
  auto sequence = read_sequence(*dataset, dataset->sequences.front());
  if (!sequence) return sequence.error();
  auto facts = read_sequence_facts(*dataset, *sequence);
  if (!facts) return facts.error();
  const ShownSequence shown{std::move(*sequence), std::move(*facts), {}};
  const auto levels = levels_of_run(*dataset, shown, workers, what);
  if (!levels) return levels.error();
  if (!levels->empty()) picture = smaller(shown, *levels, side);
  return picture;
}

// Of a run that is done.
void look_at_run(const fs::path& folder, std::size_t side, bool is_shown, bool is_counted,
                 const Workers& workers, ShownRun& run) {
  const auto fail = [&](const Error& error) {
    run.of.state = RunState::damaged;
    run.reason = error.message;
  };
  if (is_counted) {
    const auto results = read_results(folder);
    if (!results) return fail(results.error());
    run.of.results = *results;
  }
  if (!is_shown) return;
  auto picture = picture_of_run(folder, side, workers, run.what);
  if (!picture) return fail(picture.error());
  run.picture = std::move(*picture);
}

struct SweepPage {
  const SweepHead& head;
  const Plan& plan;
  std::vector<ShownRun> runs;
  std::vector<std::vector<std::string>> table;  // runs.csv: names, then a row of each run
  PictureScale scale;
};

Result<SweepPage> look_at_sweep(const fs::path& dir, const SweepHead& head, const Plan& plan,
                                const Workers& workers, bool (*stop)()) {
  SweepPage page{head, plan, std::vector<ShownRun>(plan.size()), {}, {}};
  // The table of a finished sweep spares reading all files of all runs.
  const bool has_table = has_whole_tables(dir, plan);
  const auto shown = spread(plan.size(), kMostPictures);
  const auto side = static_cast<std::size_t>(
      std::clamp(std::sqrt(kAllPixels / static_cast<double>(shown.size())), kLeastSide, kMostSide));
  const Status done = for_each_picture(workers, stop, plan.size(), [&](std::size_t i) -> Status {
    RunStatus status = run_status(dir, plan[i], 0);
    ShownRun& run = page.runs[i];
    run.of.state = status.state;
    if (status.failure) run.reason = status.failure->message;
    if (status.state == RunState::done) {
      look_at_run(dir / run_folder(plan[i].id), side,
                  std::binary_search(shown.begin(), shown.end(), i), !has_table, workers, run);
    }
    return {};
  });
  if (!done) return done.error();
  std::string text;
  if (has_table) {
    auto read = read_file(dir / kRunsFile);
    if (!read) return read.error();
    text = std::move(*read);
  } else {
    std::vector<FinishedRun> finished;
    for (const ShownRun& run : page.runs) finished.push_back(run.of);
    text = runs_csv(plan, finished);
  }
  page.table = csv_rows(text);
  LevelCounts levels;
  for (const ShownRun& run : page.runs) {
    if (run.picture) levels.add(run.picture->level_db);
  }
  page.scale = scale_of(levels);
  return page;
}

Result<std::string> sweep_json(const SweepPage& page, Chunks& chunks) {
  Json runs = Json::array();
  for (const ShownRun& run : page.runs) {
    Json picture = nullptr;
    if (run.picture) {
      auto coded = picture_json(*run.picture, page.scale, chunks);
      if (!coded) return coded.error();
      picture = std::move(*coded);
      picture["what"] = run.what;
    }
    runs.push_back({{"reason", run.reason}, {"picture", std::move(picture)}});
  }
  const Json json = {{"page", 1},
                     {"program", fmt::format("ensonify {} ({})", page.head.program_version,
                                             page.head.program_commit)},
                     {"name", page.head.name},
                     {"axes", page.plan.front().values.size()},
                     {"scale",
                      {{"min_db", page.scale.min_db},
                       {"max_db", page.scale.max_db},
                       {"show_min_db", page.scale.show_min_db},
                       {"show_max_db", page.scale.show_max_db}}},
                     {"colour_maps", colour_maps_json()},
                     {"table", page.table},
                     {"runs", std::move(runs)}};
  return without_angles(json.dump(-1, ' ', false, Json::error_handler_t::replace));
}

}  // namespace

Result<WrittenSweep> write_sweep_page(const fs::path& sweep, const SweepHead& head,
                                      const fs::path& path, const Workers& workers,
                                      bool (*stop)()) {
  const auto plan = read_plan(sweep);
  if (!plan) return plan.error();
  if (!*plan) {
    return Error{ErrorKind::usage,
                 fmt::format("{}: is missing; repeat the command of the sweep, which writes it",
                             (sweep / kPlanFile).string())};
  }
  const auto page = look_at_sweep(sweep, head, **plan, workers, stop);
  if (!page) return page.error();
  Chunks chunks;
  const auto json = sweep_json(*page, chunks);
  if (!json) return json.error();
  const PageFrame frame = page_frame("sweep_page", "sweep_order");
  StreamedFile output(path);
  output.append(frame.before);
  append_data(*json, chunks, output);
  output.append(frame.after);
  if (const Status written = output.close(); !written) return written.error();
  const auto shown = std::count_if(page->runs.begin(), page->runs.end(),
                                   [](const ShownRun& run) { return run.picture.has_value(); });
  return WrittenSweep{(*plan)->size(), static_cast<std::uint64_t>(shown), output.bytes()};
}

}  // namespace ensonify
