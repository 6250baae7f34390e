#include "report/survey.h"

#include <algorithm>
#include <cmath>

#include "dataset/layout.h"

namespace ensonify {
namespace {

constexpr std::size_t kRangeSteps = 24;
constexpr std::size_t kPathPoints = 1000, kAllPathPoints = 20'000;
constexpr std::uint64_t kMostStatistics = 50;  // sequences whose statistics are shown
constexpr std::size_t kBatch = 256;            // pings whose lines are held at once

// Values kept for one mask.
struct MaskSum {
  std::uint16_t instance = 0;
  std::uint64_t pixels = 0;
  double rows = 0;  // sum over pixels
  std::optional<double> occlusion;
};

struct PingSums {
  Status status;
  std::string view;
  std::vector<MaskSum> masks;
  std::vector<std::uint16_t> hidden;
};

// Runs go down the columns.
MaskSum sum_of(const StoredAnnotation& annotation, std::uint64_t height) {
  MaskSum sum{annotation.instance, 0, 0, annotation.occlusion};
  const auto rows = static_cast<std::int64_t>(height);
  std::int64_t at = 0;
  for (std::size_t i = 0; i < annotation.runs.size(); ++i) {
    const std::int64_t run = annotation.runs[i];
    if (i % 2 == 1) {
      sum.pixels += static_cast<std::uint64_t>(run);
      for (std::int64_t left = run, from = at; left > 0;) {
        const std::int64_t row = from % rows, part = std::min(left, rows - row);
        const auto first = static_cast<double>(row), length = static_cast<double>(part);
        sum.rows += length * (first + (length - 1) / 2);
        from += part;
        left -= part;
      }
    }
    at += run;
  }
  return sum;
}

// The polar image's masks where it has any, else the other's.
PingSums sums_of(const StoredDataset& dataset, const StoredSequence& sequence,
                 const StoredPing& ping) {
  PingSums sums;
  const auto pictures = pictures_of(dataset, sequence, ping);
  if (!pictures) {
    sums.status = pictures.error();
    return sums;
  }
  const StoredPicture* chosen = nullptr;
  for (const StoredPicture& picture : *pictures) {
    if (chosen == nullptr || picture.view == "polar") chosen = &picture;
  }
  if (chosen == nullptr) return sums;
  sums.view = chosen->view;
  sums.hidden = chosen->hidden;
  for (const StoredAnnotation& annotation : chosen->annotations) {
    sums.masks.push_back(sum_of(annotation, chosen->height));
  }
  return sums;
}

class Surveyor {
 public:
  Surveyor(const StoredDataset& dataset, std::uint64_t most, const Workers& workers, bool (*stop)())
      : dataset_(dataset), workers_(workers), stop_(stop) {
    for (const StoredSequenceRow& row : dataset.sequences) survey_.pings += row.pings();
    shown_ = spread(survey_.pings, most);
    with_statistics_ = spread(dataset.sequences.size(), std::min(most, kMostStatistics));
    survey_.classes.resize(dataset.classes.size());
    for (ClassCount& count : survey_.classes) count.ranges.resize(kRangeSteps);
    count_splits();
  }

  Result<Survey> run() {
    for (std::size_t i = 0; i < dataset_.sequences.size(); ++i) {
      if (const Status added = add_sequence(i); !added) return added.error();
    }
    for (std::size_t i = 0; i <= kRangeSteps; ++i) {
      survey_.range_edges_m.push_back(range_end_m_ * static_cast<double>(i) / kRangeSteps);
    }
    thin_paths();
    return std::move(survey_);
  }

 private:
  void count_splits() {
    for (const char* name : layout::kSplits) {
      SplitCount count{name, 0, 0};
      for (const StoredSequenceRow& row : dataset_.sequences) {
        if (row.split != name) continue;
        ++count.sequences;
        count.pings += row.pings();
      }
      if (count.sequences > 0) survey_.splits.push_back(std::move(count));
    }
  }

  // All sequences share the range steps. For a longer record the steps double, merging pairs.
  void reach(double range_m) {
    if (!(range_end_m_ > 0)) range_end_m_ = range_m;
    for (; range_end_m_ < range_m; range_end_m_ *= 2) {
      for (ClassCount& count : survey_.classes) {
        for (std::size_t i = 0; i < kRangeSteps; ++i) {
          const bool lower = i < kRangeSteps / 2;
          count.ranges[i] = lower ? count.ranges[2 * i] + count.ranges[2 * i + 1] : 0;
        }
      }
    }
  }

  Status add_sequence(std::size_t place) {
    const StoredSequenceRow& row = dataset_.sequences[place];
    const auto sequence = read_sequence(dataset_, row);
    if (!sequence) return sequence.error();
    reach(sequence->first_range_m +
          static_cast<double>(sequence->samples) * sequence->range_step_m);
    for (const StoredInstance& instance : sequence->instances) {
      ++survey_.classes[instance.class_id - 1].instances;
    }
    const bool has_files =
        sequence->packed ? !sequence->arrays.empty() : !sequence->each_ping.empty();
    const std::uint64_t end = first_ + row.pings();
    const auto begin = std::lower_bound(shown_.begin(), shown_.end(), first_);
    const bool shown = has_files && begin != shown_.end() && *begin < end;
    const bool statistics = std::binary_search(with_statistics_.begin(), with_statistics_.end(),
                                               static_cast<std::uint64_t>(place));
    std::optional<SequenceFacts> facts;
    if (shown || statistics) {
      auto read = read_sequence_facts(dataset_, *sequence);
      if (!read) return read.error();
      facts = std::move(*read);
    }
    const bool listed = shown || (facts && facts->realisations > 0);
    if (listed) survey_.sequences.push_back({*sequence, std::move(*facts), {}});
    const Status read = read_pings(*sequence, listed, shown);
    first_ = end;
    return read;
  }

  Status read_pings(const StoredSequence& sequence, bool listed, bool shown) {
    const std::size_t before = survey_.shown.size();
    const std::uint64_t step = std::max<std::uint64_t>(1, sequence.row.pings() / kPathPoints);
    std::vector<StoredPing> batch;
    const Status read = for_each_ping(dataset_, sequence, [&](const StoredPing& ping) -> Status {
      if (stop_ != nullptr && stop_()) {
        return Error{ErrorKind::interrupted, "interrupted; the page was not written"};
      }
      const std::uint64_t number = ping.ping - sequence.row.first_ping;
      if (listed && (number % step == 0 || ping.ping + 1 == sequence.row.last_ping)) {
        survey_.sequences.back().path.push_back(ping.sonar_in_world.position_m);
      }
      batch.push_back(ping);
      return batch.size() < kBatch ? Status() : add_batch(sequence, batch, shown);
    });
    if (!read) return read;
    if (const Status added = add_batch(sequence, batch, shown); !added) return added;
    return shown ? add_boxes(sequence, before) : Status();
  }

  Status add_batch(const StoredSequence& sequence, std::vector<StoredPing>& batch, bool shown) {
    std::vector<PingSums> sums(batch.size());
    workers_.for_each(batch.size(),
                      [&](std::size_t i) { sums[i] = sums_of(dataset_, sequence, batch[i]); });
    for (std::size_t i = 0; i < batch.size(); ++i) {
      if (!sums[i].status) return sums[i].status;
      count(sequence, sums[i]);
      const std::uint64_t number = first_ + (batch[i].ping - sequence.row.first_ping);
      if (!shown || !std::binary_search(shown_.begin(), shown_.end(), number)) continue;
      ShownPing ping{survey_.sequences.size() - 1,
                     batch[i].ping,
                     batch[i].time_s,
                     batch[i].sonar_in_world,
                     {},
                     {}};
      for (const MaskSum& mask : sums[i].masks) {
        ping.seen.push_back({mask.instance, mask.pixels, mask.occlusion});
      }
      survey_.shown.push_back(std::move(ping));
    }
    batch.clear();
    return {};
  }

  void count(const StoredSequence& sequence, const PingSums& sums) {
    if (!sums.view.empty()) survey_.view = sums.view;
    std::vector<bool> in_picture(survey_.classes.size());
    for (const MaskSum& mask : sums.masks) {
      const std::size_t place = sequence.instances[mask.instance - 1].class_id - 1u;
      ClassCount& count = survey_.classes[place];
      count.pixels += mask.pixels;
      if (!in_picture[place]) ++count.images;
      in_picture[place] = true;
      if (mask.pixels == 0 || sums.view != "polar") continue;
      const double range_m = sequence.first_range_m +
                             mask.rows / static_cast<double>(mask.pixels) * sequence.range_step_m;
      const auto step = static_cast<std::size_t>(range_m / range_end_m_ * kRangeSteps);
      ++count.ranges[std::min(step, kRangeSteps - 1)];
    }
    for (const std::uint16_t instance : sums.hidden) {
      ++survey_.classes[sequence.instances[instance - 1].class_id - 1u].hidden;
    }
  }

  // Boxes of the shown pings from that place on, all of one sequence.
  Status add_boxes(const StoredSequence& sequence, std::size_t from) {
    std::vector<std::uint32_t> pings;
    for (std::size_t i = from; i < survey_.shown.size(); ++i) {
      pings.push_back(survey_.shown[i].ping);
    }
    const auto boxes = boxes_of(dataset_, sequence, pings);
    if (!boxes) return boxes.error();
    std::size_t at = from;
    for (const StoredBox& box : *boxes) {
      while (at < survey_.shown.size() && survey_.shown[at].ping != box.ping) ++at;
      if (at == survey_.shown.size()) break;
      survey_.shown[at].boxes.push_back(box);
    }
    return {};
  }

  // Paths of all sequences share a limited part of the page.
  void thin_paths() {
    if (survey_.sequences.empty()) return;
    const std::size_t share = kAllPathPoints / survey_.sequences.size();
    const std::size_t most = std::clamp<std::size_t>(share, 2, kPathPoints);
    for (ShownSequence& sequence : survey_.sequences) {
      std::vector<Vec3> path;
      for (const std::uint64_t i : spread(sequence.path.size(), most)) {
        path.push_back(sequence.path[i]);
      }
      sequence.path = std::move(path);
    }
  }

  const StoredDataset& dataset_;
  const Workers& workers_;
  bool (*stop_)();
  std::vector<std::uint64_t> shown_, with_statistics_;  // pings and sequences, all counted through
  std::uint64_t first_ = 0;  // number of the sequence's first ping, all counted through
  double range_end_m_ = 0;   // of the last step of ranges
  Survey survey_;
};

}  // namespace

std::vector<std::uint64_t> spread(std::uint64_t count, std::uint64_t most) {
  std::vector<std::uint64_t> taken;
  const std::uint64_t n = std::min(count, most);
  for (std::uint64_t i = 0; i < n; ++i) {
    taken.push_back(n == 1 ? 0 : (i * (count - 1) + (n - 1) / 2) / (n - 1));
  }
  return taken;
}

Result<Survey> survey(const StoredDataset& dataset, std::uint64_t most, const Workers& workers,
                      bool (*stop)()) {
  return Surveyor(dataset, most, workers, stop).run();
}

}  // namespace ensonify
