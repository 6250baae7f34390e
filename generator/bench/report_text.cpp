#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "bench/bench.h"

namespace ensonify {
namespace {

// Which plain references stand beside a stage.
struct Beside {
  const char* stage;
  std::vector<const char*> references;
};

const Beside kBeside[] = {{"trace", {"trace_one_ray"}},
                          {"speckle", {"speckle_scalar"}},
                          {"ray_sum_and_fft", {"ray_sum_direct", "ray_sum_recurrence", "fft_rows"}},
                          {"mixing", {"mixing_full"}}};

std::string number(double value) {
  return value >= 100 ? fmt::format("{:.0f}", value) : fmt::format("{:.3g}", value);
}

std::string share_text(const Timing& t) {
  return t.share > 0 ? fmt::format("{:.0f} % of {}", 100 * t.share, t.share_of) : "";
}

void add_row(std::string& text, const std::string& name, const Timing& t, double stage_ms) {
  std::string notes = share_text(t);
  if (t.part < 1) {
    notes += fmt::format("{}{:.2g} % timed, scaled", notes.empty() ? "" : ", ", 100 * t.part);
  }
  const std::string ratio = stage_ms > 0 ? "x " + number(t.ms / stage_ms) : "";
  std::string line = fmt::format("  {:<24} {:>9}  {:>8}  {}", name, number(t.ms), ratio, notes);
  line.erase(line.find_last_not_of(' ') + 1);
  text += line + "\n";
}

// 0: not measured.
std::string error_text(double error) {
  return error > 0 ? fmt::format(", error {:.1e}", error) : "";
}

std::string case_text(const CaseReport& c) {
  std::string text = fmt::format(
      "\n{}: {} beams x {} rays, {} scatterers, {} samples, transforms of {}\n"
      "  pings/s: {} ({} on one thread; {} with expected power); error {:.1e}, worst tenth of the "
      "record {:.1e}\n"
      "  over direct     {:>6} x ({} pings/s{})\n"
      "  over recurrence {:>6} x ({} pings/s{})\n"
      "  {:<24} {:>9}  {:>8}\n",
      c.name, c.beams, c.rays_per_beam, c.scatterers, c.samples, c.transform, number(c.pings_per_s),
      number(c.pings_per_s_1_thread), number(c.clean_pings_per_s), c.error, c.worst_tenth_error,
      number(c.pings_per_s / c.direct_pings_per_s), number(c.direct_pings_per_s),
      error_text(c.direct_error), number(c.pings_per_s / c.recurrence_pings_per_s),
      number(c.recurrence_pings_per_s), error_text(c.recurrence_error), "one thread", "ms",
      "slower");
  for (const Timing& stage : c.stages) {
    add_row(text, stage.name, stage, 0);
    const auto beside = std::find_if(std::begin(kBeside), std::end(kBeside),
                                     [&](const Beside& b) { return stage.name == b.stage; });
    if (beside == std::end(kBeside)) continue;
    for (const char* name : beside->references) {
      for (const Timing& reference : c.references) {
        if (reference.name == name) add_row(text, "  " + reference.name, reference, stage.ms);
      }
    }
  }
  return text;
}

std::string data_set_text(const DataSetReport& d) {
  std::string text = fmt::format(
      "\nwhole data sets, {}: {} beams x {} samples; medians of {} runs of {} pings\n"
      "  {:<16} {:>9}  {:>15}  {:>13}  {:>8}\n",
      d.name, d.beams, d.samples, d.runs, d.pings, "files", "pings/s", "least to most",
      "core ms/ping", "MB/ping");
  for (const FileKindReport& k : d.kinds) {
    const std::string range =
        fmt::format("{} to {}", number(k.least_pings_per_s), number(k.most_pings_per_s));
    text += fmt::format("  {:<16} {:>9}  {:>15}  {:>13}  {:>8}\n", k.name, number(k.pings_per_s),
                        range, number(k.core_ms_per_ping), number(k.mb_per_ping));
  }
  return text;
}

}  // namespace

std::string bench_text(const BenchReport& report) {
  const MachineReport& m = report.machine;
  std::string text = fmt::format(
      "machine: {} threads, {}; one core: {:.0f} GFlop/s, copies {:.1f} GB/s; disk {:.0f} MB/s{}\n",
      m.threads, m.simd, m.fma_gflops, m.copy_gb_s, m.disk_mb_s,
      m.disk_is_memory   ? " (a file system in memory: give another folder by --disk)"
      : m.disk_is_direct ? ""
                         : " (through the page cache, synchronised)");
  for (const CaseReport& c : report.cases) text += case_text(c);
  for (const DataSetReport& d : report.data_sets) text += data_set_text(d);
  if (report.cases.empty()) return text;
  text +=
      "\nMedians. Stages and references: one thread. direct, recurrence: sine and cosine for each "
      "scatterer and bin, or one\nrotation; full product over beams; one transform a beam.\n"
      "All give the series; with expected power is what a ping with pictures takes.\n";
  return text;
}

}  // namespace ensonify
