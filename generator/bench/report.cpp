#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include "bench/bench.h"
#include "bench/report_whole.h"
#include "core/counted.h"

namespace ensonify {
namespace {

using Json = nlohmann::ordered_json;

Json parts_of(const std::vector<Timing>& timings) {
  Json json = Json::object();
  for (const Timing& t : timings) {
    if (t.part < 1) json[t.name] = t.part;
  }
  return json;
}

Json shares_of(const CaseReport& c) {
  Json json = Json::object();
  for (const auto* timings : {&c.stages, &c.references}) {
    for (const Timing& t : *timings) {
      if (t.share > 0) json[t.name] = {{"of", t.share_of}, {"share", t.share}};
    }
  }
  return json;
}

Json json_of(const CaseReport& c) {
  return {{"beams", c.beams},
          {"rays_per_beam", c.rays_per_beam},
          {"samples", c.samples},
          {"transform", c.transform},
          {"scatterers", c.scatterers},
          {"pings_per_s", c.pings_per_s},
          {"pings_per_s_1_thread", c.pings_per_s_1_thread},
          {"pings_per_s_with_clean", c.clean_pings_per_s},
          {"error", c.error},
          {"error_worst_tenth", c.worst_tenth_error},
          {"speedup_over_direct", c.pings_per_s / c.direct_pings_per_s},
          {"speedup_over_recurrence", c.pings_per_s / c.recurrence_pings_per_s},
          {"direct_pings_per_s", c.direct_pings_per_s},
          {"recurrence_pings_per_s", c.recurrence_pings_per_s},
          {"direct_error", c.direct_error},
          {"recurrence_error", c.recurrence_error},
          {"stages_ms", times_json(c.stages)},
          {"references_ms", times_json(c.references)},
          {"references_timed_part", parts_of(c.references)},
          {"shares_of_peak", shares_of(c)}};
}

// Which plain references stand next to a stage.
struct Beside {
  const char* stage;
  std::vector<const char*> references;
};

const Beside kBeside[] = {{"trace", {"trace_one_ray"}},
                          {"speckle", {"speckle_scalar"}},
                          {"ray_sum_and_fft", {"ray_sum_direct", "ray_sum_recurrence", "fft_rows"}},
                          {"mixing", {"mixing_full"}}};

std::string share_text(const Timing& t) {
  return t.share > 0 ? fmt::format("{:.0f} % of {}", 100 * t.share, t.share_of) : "";
}

void add_row(std::string& text, const std::string& name, const Timing& t, double stage_ms) {
  std::string notes = share_text(t);
  if (t.part < 1) {
    notes += fmt::format("{}{:.2g} % timed, scaled", notes.empty() ? "" : ", ", 100 * t.part);
  }
  const std::string ratio = stage_ms > 0 ? "x " + rounded_text(t.ms / stage_ms) : "";
  std::string line =
      fmt::format("  {:<24} {:>9}  {:>8}  {}", name, rounded_text(t.ms), ratio, notes);
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
      c.name, c.beams, c.rays_per_beam, c.scatterers, c.samples, c.transform,
      rounded_text(c.pings_per_s), rounded_text(c.pings_per_s_1_thread),
      rounded_text(c.clean_pings_per_s), c.error, c.worst_tenth_error,
      rounded_text(c.pings_per_s / c.direct_pings_per_s), rounded_text(c.direct_pings_per_s),
      error_text(c.direct_error), rounded_text(c.pings_per_s / c.recurrence_pings_per_s),
      rounded_text(c.recurrence_pings_per_s), error_text(c.recurrence_error), "one thread", "ms",
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

}  // namespace

std::string bench_json(const BenchReport& report) {
  Json cases = Json::object();
  for (const CaseReport& c : report.cases) cases[c.name] = json_of(c);
  const MachineReport& m = report.machine;
  const Json json = {{"cases", std::move(cases)},
                     {"data_sets", data_sets_json(report.data_sets)},
                     {"growth", growth_json(report.growth)},
                     {"machine",
                      {{"fma_gflops", m.fma_gflops},
                       {"copy_gb_s", m.copy_gb_s},
                       {"disk_mb_s", m.disk_mb_s},
                       {"disk_is_memory", m.disk_is_memory},
                       {"disk_is_direct", m.disk_is_direct},
                       {"threads", m.threads},
                       {"simd", m.simd}}}};
  return json.dump(2) + "\n";
}

std::string bench_text(const BenchReport& report) {
  const MachineReport& m = report.machine;
  std::string text = fmt::format(
      "machine: {}, {}; one core: {:.0f} GFlop/s, copies {:.1f} GB/s; disk {:.0f} MB/s{}\n",
      counted(static_cast<std::uint64_t>(m.threads), "thread"), m.simd, m.fma_gflops, m.copy_gb_s,
      m.disk_mb_s,
      m.disk_is_memory   ? " (a file system in memory; name another folder with --disk)"
      : m.disk_is_direct ? ""
                         : " (through the page cache, synchronized)");
  for (const CaseReport& c : report.cases) text += case_text(c);
  text += data_sets_text(report.data_sets) + growth_text(report.growth);
  if (report.cases.empty()) return text;
  text +=
      "\nMedians. Stages and references run on one thread. direct, recurrence: a sine and cosine, "
      "or "
      "one rotation, for each\nscatterer and bin; full product over beams; one transform per "
      "beam.\n"
      "All compute the time series; pings with images also need the expected power.\n";
  return text;
}

}  // namespace ensonify
