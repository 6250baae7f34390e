// SEQUENCE.mcap: the topics of mcap_topics.h, one file per sequence, because the times of sequences
// overlap; or with --one-file all of them in dataset.mcap, one after another.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "dataset/layout.h"
#include "dataset/rig_file.h"
#include "export/job.h"
#include "export/mcap_navigation.h"
#include "export/mcap_topics.h"
#include "export/ping_values.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t kSecondNs = 1'000'000'000, kMostNs = 2147483647 * kSecondNs;

// A file, and where its clock stands.
struct Tape {
  explicit Tape(const fs::path& path) : file(path, "ros2", "ensonify"), channels(file) {}

  McapFile file;
  McapChannels channels;
  std::uint64_t last_ns = 0;  // of the messages so far
  bool begun = false;
};

// Whole seconds by which a sequence is later than its own times, so that it begins at least a
// second after the one before.
std::uint64_t shift_after(const Tape& tape, std::uint64_t first_ns) {
  if (!tape.begun || first_ns >= tape.last_ns + kSecondNs) return 0;
  const std::uint64_t least = tape.last_ns + kSecondNs - first_ns;
  return (least + kSecondNs - 1) / kSecondNs * kSecondNs;
}

void describe_sequence(const ExportJob& job, const StoredSequence& sequence, std::uint64_t shift_ns,
                       Tape& tape) {
  std::map<std::string, std::string> values = {
      {"dataset", job.dataset.name},
      {"sequence", std::to_string(sequence.row.sequence)},
      {"split", sequence.row.split},
      {"first_ping", std::to_string(sequence.row.first_ping)},
      {"pings", std::to_string(sequence.row.pings())},
      {"later_by_s", std::to_string(shift_ns / kSecondNs)}};
  const auto& recording = sequence.manifest.info.recording;
  if (recording) values["clock_at_0_us"] = std::to_string(recording->start_us);
  tape.file.add_metadata("sequence", values);
}

// A sonar of a rig is recorded with the sensors of the rig: their data set, and the sequence of the
// sonar with them.
struct Sensed {
  std::optional<StoredDataset> dataset = {};  // absent: that of the sequence
  StoredSequence sequence;
};

Result<Sensed> sensed_sequence(const ExportJob& job, const StoredSequence& sequence) {
  Sensed sensed{{}, sequence};
  SequenceInfo& info = sensed.sequence.manifest.info;
  if (!is_sonar(info) || !info.mount || info.navigation) return sensed;
  const auto folder = folder_of_kind(job.dataset.dir, InstrumentKind::navigation);
  if (!folder) return folder.error();
  if (!*folder) return sensed;
  auto dataset = open_dataset(**folder);
  if (!dataset) return dataset.error();
  const auto row =
      std::ranges::find(dataset->sequences, sequence.row.sequence, &StoredSequenceRow::sequence);
  if (row == dataset->sequences.end()) return sensed;
  auto sensors = read_sequence(*dataset, *row);
  if (!sensors) return sensors.error();
  info.navigation = sensors->manifest.info.navigation;
  if (info.navigation) info.navigation->sonar_in_body = *info.mount;
  sensed.dataset = std::move(*dataset);
  return sensed;
}

Status record_sequence(const ExportJob& job, const StoredSequence& stored, Tape& tape) {
  const auto sensed = sensed_sequence(job, stored);
  if (!sensed) return sensed.error();
  const StoredSequence& sequence = sensed->sequence;
  SonarTopics topics(job, sequence);
  if (const Status started = topics.start(); !started) return started;
  SensorTopics sensors;
  const StoredDataset& dataset = sensed->dataset ? *sensed->dataset : job.dataset;
  if (const Status started = sensors.start(dataset, sequence); !started) return started;
  std::uint64_t shift_ns = 0;
  bool is_first = true;
  const auto sense_before = [&](std::uint64_t own_ns) -> Status {
    const auto last_ns = sensors.write_before(own_ns, shift_ns, tape.last_ns, tape.channels);
    if (last_ns) tape.last_ns = *last_ns;
    return last_ns ? Status() : Status(last_ns.error());
  };
  const Status pings = for_each_exported_ping(job, sequence, [&](const StoredPing& ping) -> Status {
    const auto own_ns = ping_ns(sequence, ping);
    if (!own_ns) return own_ns.error();
    if (std::exchange(is_first, false)) {
      shift_ns = shift_after(tape, std::min(*own_ns, sensors.first_ns().value_or(*own_ns)));
      describe_sequence(job, sequence, shift_ns, tape);
    } else if (*own_ns + shift_ns < tape.last_ns) {
      if (sequence.manifest.info.recording) {
        return refused_sequence(
            sequence,
            fmt::format("the time of ping {} is earlier than that of the ping before it, "
                        "but MCAP needs rising times; import a part of the log by --pings",
                        ping.ping));
      }
      return damaged(
          job.dataset.dir / layout::in_sequence(sequence.row.sequence, "poses.csv"),
          fmt::format("the time of ping {} is earlier than that of the ping before it", ping.ping));
    }
    if (const Status written = sense_before(*own_ns); !written) return written;
    tape.last_ns = *own_ns + shift_ns;
    tape.begun = true;
    if (tape.last_ns >= kMostNs) {
      return Error{ErrorKind::usage,
                   fmt::format("--one-file: sequence {} would end after 2147483647 s, the limit of "
                               "ROS; omit --one-file",
                               sequence.row.sequence)};
    }
    return topics.write(ping, tape.last_ns, tape.channels);
  });
  return pings ? sense_before(kMostNs) : pings;
}

}  // namespace

Status write_mcap(const ExportJob& job, const fs::path& target) {
  if (job.options.one_file) {
    Tape tape(target / "dataset.mcap");
    const Status read = for_each_sequence(
        job, [&](const StoredSequence& sequence) { return record_sequence(job, sequence, tape); });
    const Status closed = tape.file.close();
    return read ? closed : read;
  }
  return for_each_sequence(job, [&](const StoredSequence& sequence) -> Status {
    Tape tape(target / fmt::format("{:06}.mcap", sequence.row.sequence));
    const Status read = record_sequence(job, sequence, tape);
    const Status closed = tape.file.close();
    return read ? closed : read;
  });
}

}  // namespace ensonify
