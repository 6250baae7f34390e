#include "report/report.h"

#include <algorithm>

#include "dataset/files.h"
#include "report/page_json.h"
#include "report/page_output.h"
#include "report/page_text.h"

namespace ensonify {
namespace {

constexpr std::uint64_t kPageBytes = 14'500'000;  // what pages of pictures are made to fit
constexpr std::uint64_t kLeastPictureBytes = 4'000'000;

// JSON and the page's own files, roughly.
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

void append_data(const std::string& json, const Chunks& chunks, PageOutput& output) {
  output.append("<script type=\"application/json\" id=\"report\">");
  output.append(json);
  output.append("</script>\n");
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    output.append("<script type=\"text/plain\" id=\"chunk-" + std::to_string(i) + "\">" +
                  base64(chunks[i]) + "</script>\n");
  }
}

Result<ReportSummary> make_page(const ReportOptions& options) {
  const auto dataset = open_dataset(options.dataset);
  if (!dataset) return dataset.error();
  auto output = PageOutput::open(options.output, options.dataset, options.overwrite);
  if (!output) return output.error();
  const auto facts = read_facts(*dataset);
  if (!facts) return facts.error();
  const Workers workers(options.threads);
  const auto tables = survey(*dataset, options, workers);
  if (!tables) return tables.error();
  const PictureJob job{*dataset, *tables, workers, options.stop};
  const auto look = look_at(job);
  if (!look) return look.error();
  const PageFrame frame = page_frame();
  const std::uint64_t others = other_bytes(*tables, *facts, frame);
  Chunks chunks;
  const auto statistics = encode_statistics(job, chunks);
  if (!statistics) return statistics.error();
  const std::uint64_t budget =
      others + kLeastPictureBytes < kPageBytes ? kPageBytes - others : kLeastPictureBytes;
  const auto pictures = encode_pictures(job, look->scale, budget, chunks);
  if (!pictures) return pictures.error();
  output->append(frame.before);
  append_data(page_json({*dataset, *facts, *tables, *look, *pictures, *statistics,
                         options.preview ? &options.preview_of : nullptr}),
              chunks, *output);
  output->append(frame.after);
  if (const Status written = output->commit(); !written) return written.error();
  return ReportSummary{output->path(), tables->pings, tables->shown.size(), output->bytes()};
}

}  // namespace

Result<ReportSummary> write_report(const ReportOptions& options) {
  return without_exceptions("writing the page", [&] { return make_page(options); });
}

}  // namespace ensonify
