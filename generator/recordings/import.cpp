#include "recordings/import.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>

#include "core/parallel.h"
#include "dataset/finish.h"
#include "dataset/work.h"
#include "dataset/write_ping.h"
#include "formats/files.h"
#include "formats/json.h"
#include "recordings/open_log.h"
#include "recordings/sequences.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

struct Import {
  const ImportOptions& options;
  LogSource source;
  Log log;
  LogSurvey survey;
  std::string name;
  std::array<double, 2> limits_db{};
};

// What stands in place of a scenario.
std::string description(const Import& import) {
  const auto& sequences = import.survey.sequences;
  const auto& choices = import.options.choices;
  const std::string topic =
      choices.topic.empty() ? "" : "  topic: " + quoted_text(choices.topic) + "\n";
  const std::string db =
      choices.db ? fmt::format("  db: [{}, {}]\n", (*choices.db)[0], (*choices.db)[1]) : "";
  const std::string frequency =
      choices.frequency_hz ? fmt::format("  frequency_hz: {}\n", *choices.frequency_hz) : "";
  return fmt::format(
      "# A recording, made by `ensonify import`; there is no scenario to generate.\n"
      "recording:\n  format: {}\n  file: {}\n  sha256: {}\n  frames: [{}, {}]\n  split: {}\n"
      "  cartesian_height_px: {}\n{}{}{}",
      log_format_name(import.source.format), quoted_text(import.source.name), import.source.sha256,
      sequences.front().first_frame, sequences.back().last_frame, import.options.split,
      import.options.cartesian_height_px, topic, db, frequency);
}

WorkIdentity identity_of(const Import& import) {
  WorkIdentity identity;
  identity.name = import.name;
  identity.scenario_sha256 = sha256_hex(description(import));
  std::uint64_t most = 0;
  for (const LogSequence& sequence : import.survey.sequences) {
    most = std::max(most, sequence.frames());
  }
  identity.last_ping = static_cast<std::uint32_t>(most);
  identity.program_version = import.options.program_version;
  identity.program_commit = import.options.program_commit;
  identity.backend = "none";
  identity.simd = "none";
  identity.embree_isa = "none";
  return identity;
}

// The limits of the recorder, or those of the rule for data sets with the levels of the first ping.
std::array<double, 2> limits_of(const LogSurvey& survey) {
  const Recorder recorder = recorder_of(survey.sequences.front().settings);
  if (recorder.scale == GreyScale::db && recorder.db != kFloatLevelsDb) return recorder.db;
  return db_limits_from_levels(survey.first_level_db);
}

SequenceInfo info_of(const Import& import, std::uint32_t number) {
  SequenceInfo info = recording_info(import.source, import.survey.sequences[number], number,
                                     import.options.cartesian_height_px);
  info.split = import.options.split;
  info.png.limits_db = import.limits_db;
  return info;
}

// Writes pings of one sequence in blocks, whose frames are held at once.
class SequenceWriter {
 public:
  SequenceWriter(const Import& import, const Workers& workers, std::uint32_t number)
      : import_(import),
        workers_(workers),
        info_(info_of(import, number)),
        display_(recorded_display(info_)) {}

  Status add(std::uint64_t number, const LogFrame& frame) {
    if (frame.counts.empty()) return {};  // stored already
    block_.push_back({static_cast<std::uint32_t>(number - info_.recording->first_frame), frame});
    return block_.size() < static_cast<std::size_t>(workers_.threads()) ? Status() : write();
  }

  Status finish() {
    if (const Status written = write(); !written) return written;
    return finish_sequence(import_.options.output, info_, {.cartesian_map = display_.map});
  }

 private:
  Status write() {
    if (import_.options.stop && import_.options.stop()) {
      return Error{ErrorKind::interrupted,
                   "interrupted: finished work is kept; repeat the command to resume"};
    }
    std::vector<Status> statuses(block_.size());
    workers_.for_each(block_.size(), [&](std::size_t i) {
      const auto& [ping, frame] = block_[i];
      statuses[i] = write_ping(import_.options.output, info_,
                               recorded_result(info_, display_, frame, ping), Workers(1));
    });
    block_.clear();
    for (const Status& status : statuses) {
      if (!status) return status;
    }
    return {};
  }

  const Import& import_;
  const Workers& workers_;
  SequenceInfo info_;
  RecordedDisplay display_;
  std::vector<std::pair<std::uint32_t, LogFrame>> block_;
};

// Writes the missing pings, frame by frame.
class LogWriter {
 public:
  LogWriter(const Import& import, const Workers& workers) : import_(import), workers_(workers) {}

  // The sequence of a frame that is to be written; none if it is stored or not asked for.
  std::optional<std::uint32_t> wanted(std::uint64_t frame) {
    const auto& sequences = import_.survey.sequences;
    while (at_ < sequences.size() && frame >= sequences[at_].last_frame) {
      ++at_;
      whole_.reset();
    }
    if (at_ == sequences.size() || frame < sequences[at_].first_frame) return std::nullopt;
    const auto number = static_cast<std::uint32_t>(at_);
    if (!whole_) whole_ = sequence_is_finished(import_.options.output, number);
    if (*whole_) return std::nullopt;
    SequenceInfo range;
    range.last_ping = static_cast<std::uint32_t>(sequences[at_].frames());
    const auto ping = static_cast<std::uint32_t>(frame - sequences[at_].first_frame);
    const bool stored = ping_is_finished(import_.options.output, number, ping, range);
    return stored ? std::nullopt : std::optional(number);
  }

  Status add(std::uint64_t number, const LogFrame& frame) {
    const auto& sequences = import_.survey.sequences;
    if (at_ == sequences.size() || number < sequences[at_].first_frame || *whole_) return {};
    if (!writer_) writer_.emplace(import_, workers_, static_cast<std::uint32_t>(at_));
    if (Status added = writer_->add(number, frame); !added) return added;
    if (number + 1 < sequences[at_].last_frame) return {};
    Status finished = writer_->finish();
    writer_.reset();
    return finished;
  }

 private:
  const Import& import_;
  const Workers& workers_;
  std::size_t at_ = 0;         // the sequence of the current frame
  std::optional<bool> whole_;  // whether it is finished
  std::optional<SequenceWriter> writer_;
};

Result<Import> open_import(const ImportOptions& options) {
  auto log = open_log(options.log, options.choices);
  if (!log) return log.error();
  auto survey = survey_log(*log, options.pings, options.stop);
  if (!survey) return survey.error();
  auto hash = log->sha256();
  if (!hash) return hash.error();
  const LogSource source{log->format, log->name, std::move(*hash)};
  Import import{options,
                source,
                std::move(*log),
                std::move(*survey),
                options.name.empty() ? fs::path(source.name).stem().string() : options.name,
                {}};
  import.limits_db = limits_of(import.survey);
  return import;
}

Status write_sequences(const Import& import, const Workers& workers) {
  LogWriter writer(import, workers);
  const auto end = import.log.read(
      {[&](std::uint64_t frame) { return writer.wanted(frame).has_value(); },
       [&](std::uint64_t frame, const LogFrame& of) { return writer.add(frame, of); }});
  return end ? Status() : Status(end.error());
}

DatasetInfo dataset_of(const Import& import, int threads, double seconds) {
  DatasetInfo dataset;
  dataset.identity = identity_of(import);
  dataset.scenario_yaml = description(import);
  dataset.first = info_of(import, 0);
  for (std::uint32_t i = 0; i < import.survey.sequences.size(); ++i) {
    dataset.sequences.push_back(i);
  }
  dataset.sequences_in_all = dataset.sequences.size();
  dataset.host = import.options.host;
  dataset.threads = threads;
  dataset.wall_seconds = seconds;
  return dataset;
}

Result<ImportReport> import_into(const ImportOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  const auto import = open_import(options);
  if (!import) return import.error();
  const LogSurvey& survey = import->survey;
  ImportReport report;
  report.sequences = survey.sequences.size();
  for (const LogSequence& sequence : survey.sequences) report.pings += sequence.frames();
  report.instrument = survey.sequences.front().settings.instrument;
  report.warnings = survey.warnings;
  FolderUse use;
  const auto state =
      open_work(options.output, identity_of(*import), static_cast<std::uint32_t>(report.sequences),
                options.overwrite, false, &use);
  if (!state) return state.error();
  report.complete = *state == FolderState::complete;
  if (report.complete) return report;
  if (options.listen) options.listen();
  const Workers workers(options.threads);
  if (const Status written = write_sequences(*import, workers); !written) return written.error();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  const auto finished =
      finish_dataset(options.output, dataset_of(*import, workers.threads(), took.count()));
  if (!finished) return finished.error();
  return report;
}

}  // namespace

Result<ImportReport> import_log(const ImportOptions& options) {
  return without_exceptions("importing " + options.log.string(),
                            [&] { return import_into(options); });
}

}  // namespace ensonify
