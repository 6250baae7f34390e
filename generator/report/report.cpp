#include "report/report.h"

#include <algorithm>
#include <fstream>

#include "dataset/rig_file.h"
#include "formats/files.h"
#include "formats/output_place.h"
#include "report/page_text.h"
#include "report/rig_page.h"
#include "report/sweep_page.h"
#include "sweep/folder.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

constexpr int kMostPings = 200, kMostRows = 50;
constexpr std::uint64_t kPageBytes = 14'500'000;  // what pages of images are made to fit
constexpr std::uint64_t kLeastPictureBytes = 4'000'000;

Error refused(const fs::path& path, const std::string& what) {
  return {ErrorKind::usage, path.string() + ": " + what};
}

// The folder's name as given or, if that has none, its real name.
fs::path named(const fs::path& folder) {
  fs::path plain = folder.lexically_normal();
  if (!plain.has_filename()) plain = plain.parent_path();
  const fs::path name = plain.filename();
  return name.empty() || name == "." || name == ".." ? fs::weakly_canonical(folder) : plain;
}

bool is_page(const fs::path& path) {
  std::string head(kPageMark.size(), '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  return file.gcount() == static_cast<std::streamsize>(head.size()) && head == kPageMark;
}

// The path of the page. `output` empty: DIR_report.html next to the data set. Replaces a page of
// ensonify, other files only with `overwrite`. Error (usage): another file exists there, or the
// path would damage the data set.
Result<fs::path> page_path(const fs::path& output, const fs::path& dataset, bool overwrite,
                           std::string_view what = "data set") {
  const fs::path folder = named(dataset);
  const fs::path path = output.empty()
                            ? folder.parent_path() / (folder.filename().string() + "_report.html")
                            : output.lexically_normal();
  std::error_code error;
  if (!path.has_filename() || fs::is_directory(path, error)) {
    return refused(path, "is a folder; name the file to write");
  }
  if (lies_in(path, folder)) {
    return refused(
        path, what == "data set"
                  ? "lies in the data set, where `ensonify verify` would report it as a file "
                    "that no manifest lists; name a place outside it"
                  : "lies in the folder of the " + std::string(what) + "; name a place outside it");
  }
  const auto there = fs::status(path, error);
  if (fs::exists(there) && !overwrite) {
    if (!fs::is_regular_file(there) || !is_page(path)) {
      return refused(path,
                     "already exists and is not a report of ensonify; name another file, or give "
                     "--overwrite to replace it");
    }
  }
  return path;
}

// Approximate size of JSON and the page's own files.
std::uint64_t other_bytes(const Survey& survey, const DatasetFacts& facts, const PageFrame& frame) {
  constexpr std::uint64_t kHead = 20'000, kPing = 900, kRow = 90, kNumber = 11;
  std::uint64_t sum = kHead + frame.before.size() + frame.after.size() + facts.scenario.size();
  for (const ShownSequence& sequence : survey.sequences) {
    sum += kNumber * (sequence.facts.azimuth_rad.size() + 3 * sequence.path.size()) +
           kRow * (sequence.facts.draws.size() + 2 * sequence.stored.instances.size());
  }
  for (const ShownPing& ping : survey.shown) {
    sum += kPing + kRow * (ping.boxes.size() + ping.seen.size() / 4);
  }
  return sum;
}

// A preview's data set numbers its pings from 0; the page shows the numbers of the scenario.
Survey numbered_as_in_sequence(Survey survey, const PreviewOf& preview) {
  if (survey.sequences.empty() || survey.shown.size() != preview.pings.size()) return survey;
  for (std::size_t i = 0; i < preview.pings.size(); ++i) survey.shown[i].ping = preview.pings[i];
  for (SplitCount& split : survey.splits) split.pings = preview.all_pings;
  survey.pings = preview.all_pings;
  ShownSequence& sequence = survey.sequences.front();
  sequence.stored.row.last_ping =
      sequence.stored.row.first_ping + static_cast<std::uint32_t>(preview.all_pings);
  sequence.path = preview.path_m;
  return survey;
}

Result<ReportSummary> make_sweep_page(const ReportOptions& options, const SweepHead& sweep) {
  if (options.max_pings) {
    return Error{ErrorKind::usage,
                 "--pings: a report over the runs of a sweep shows one ping of each; expected "
                 "the folder of a run"};
  }
  const auto page = page_path(options.output, options.dataset, options.overwrite, "sweep");
  if (!page) return page.error();
  const auto written =
      write_sweep_page(options.dataset, sweep, *page, Workers(options.threads), options.stop);
  if (!written) return written.error();
  return ReportSummary{*page, 0, written->shown, written->bytes, written->runs};
}

Result<ReportSummary> make_page(const ReportOptions& options);

// Whether the data set of an instrument has beams, which a page of its own shows.
Result<bool> has_beams(const fs::path& dir) {
  const auto dataset = open_dataset(dir);
  if (!dataset) return dataset.error();
  if (dataset->sequences.empty()) return true;
  const auto sequence = read_sequence(*dataset, dataset->sequences.front());
  return sequence ? Result<bool>(sequence->beams > 0) : sequence.error();
}

// The page of the rig, and next to it PAGE_NAME.html of each sonar.
Result<ReportSummary> make_rig_pages(const ReportOptions& options, const RigFile& rig) {
  const auto path = page_path(options.output, options.dataset, options.overwrite, "rig");
  if (!path) return path.error();
  RigPage page{
      options.dataset, rig, {}, static_cast<std::uint64_t>(options.max_pings.value_or(kMostRows))};
  for (const RigInstrument& instrument : rig.instruments) {
    ReportOptions part = options;
    part.dataset = options.dataset / instrument.name;
    part.output = path->parent_path() / (path->stem().string() + "_" + instrument.name + ".html");
    const auto beams = has_beams(part.dataset);
    if (!beams) return beams.error();
    page.reports.push_back(*beams ? part.output.filename().string() : "");
    if (!*beams) continue;
    if (const auto made = make_page(part); !made) return made.error();
  }
  const auto written = write_rig_page(page, *path, Workers(options.threads), options.stop);
  if (!written) return written.error();
  return ReportSummary{*path, written->pings, written->shown, written->bytes};
}

Result<ReportSummary> make_page(const ReportOptions& options) {
  const auto sweep = read_sweep_head(options.dataset);
  if (!sweep) return sweep.error();
  if (*sweep) return make_sweep_page(options, **sweep);
  const auto rig = read_rig(options.dataset);
  if (!rig) return rig.error();
  if (*rig) return make_rig_pages(options, **rig);
  const auto dataset = open_dataset(options.dataset);
  if (!dataset) return dataset.error();
  const auto path = page_path(options.output, options.dataset, options.overwrite);
  if (!path) return path.error();
  const auto facts = read_facts(*dataset);
  if (!facts) return facts.error();
  const Workers workers(options.threads);
  const auto tables = survey(
      *dataset, static_cast<std::uint64_t>(std::max(options.max_pings.value_or(kMostPings), 0)),
      workers, options.stop);
  if (!tables) return tables.error();
  const PictureJob job{*dataset, *tables, workers, options.stop};
  const auto look = look_at(job);
  if (!look) return look.error();
  const PageFrame frame = page_frame("page", "order");
  const std::uint64_t others = other_bytes(*tables, *facts, frame);
  Chunks chunks;
  const auto statistics = encode_statistics(job, chunks);
  if (!statistics) return statistics.error();
  const std::uint64_t budget =
      others + kLeastPictureBytes < kPageBytes ? kPageBytes - others : kLeastPictureBytes;
  const auto pictures = encode_pictures(job, look->scale, budget, chunks);
  if (!pictures) return pictures.error();
  StreamedFile output(*path);
  output.append(frame.before);
  const Survey shown =
      options.preview ? numbered_as_in_sequence(*tables, options.preview_of) : *tables;
  append_data(page_json({*dataset, *facts, shown, *look, *pictures, *statistics, options.preview}),
              chunks, output);
  output.append(frame.after);
  if (const Status written = output.close(); !written) return written.error();
  return ReportSummary{*path, tables->pings, tables->shown.size(), output.bytes()};
}

}  // namespace

Result<ReportSummary> write_report(const ReportOptions& options) {
  return without_exceptions("writing the page", [&] { return make_page(options); });
}

}  // namespace ensonify
