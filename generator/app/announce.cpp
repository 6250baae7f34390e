#include "app/announce.h"

#include "app/disk_room.h"
#include "app/sweep_parts.h"
#include "app/terminal.h"
#include "core/counted.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

void announce_disk(const fs::path& output, double bytes) {
  answer("# disk: about {}\n", bytes_text(static_cast<std::uint64_t>(bytes)));
  const auto free = free_bytes(output);
  if (!free) return;
  answer("# free disk space in {}: {}{}\n", output.empty() ? "this folder" : output.string(),
         bytes_text(*free), bytes > static_cast<double>(*free) ? ", which is too little" : "");
}

Remaining all_of(const MeasureJob& job) {
  Remaining all;
  all.pings = all.sequence_pings = all.listed_pings = std::uint64_t{job.count()} * job.pings_each;
  all.sequences = all.listed_sequences = job.count();
  return all;
}

}  // namespace

Status announce_run(const CheckOptions& options, const Session& session, const Cost& cost,
                    const MeasureJob& job, const RunTime& start) {
  const std::string threads = counted(static_cast<std::uint64_t>(job.threads), "thread");
  const auto announce_memory = [&] {
    answer("# peak memory: about {} with {}\n", bytes_text(cost.peak_bytes), threads);
  };
  answer("# files: {}\n", cost.files);
  if (const std::uint64_t available = available_memory(); cost.peak_bytes > available) {
    announce_disk(options.output, static_cast<double>(cost.disk_bytes));
    announce_memory();
    answer("# pings measured for disk and time: 0, because only {} of memory is available\n",
           bytes_text(available));
    return {};
  }
  SharedParts first;
  const Result<Measured> measured = measure_pings(job, first);
  if (!measured) return measured.error();
  announce_disk(options.output, disk_bytes(*measured, session, all_of(job)));
  announce_memory();
  const RunTime time = start + time_of(*measured, job);
  answer("# time: about {} with {}, {} of one core\n", seconds_text(time.wall_s), threads,
         seconds_text(time.core_s));
  answer("# pings measured for disk and time: {} (sequences: {})\n", measured->pings,
         measured->sequences);
  return {};
}

}  // namespace ensonify
