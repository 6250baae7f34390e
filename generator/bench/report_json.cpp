#include <nlohmann/json.hpp>

#include "bench/bench.h"

namespace ensonify {
namespace {

using Json = nlohmann::ordered_json;

Json times_of(const std::vector<Timing>& timings) {
  Json json = Json::object();
  for (const Timing& t : timings) json[t.name] = t.ms;
  return json;
}

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
          {"stages_ms", times_of(c.stages)},
          {"references_ms", times_of(c.references)},
          {"references_timed_part", parts_of(c.references)},
          {"shares_of_peak", shares_of(c)}};
}

Json json_of(const DataSetReport& d) {
  Json kinds = Json::object();
  for (const FileKindReport& k : d.kinds) {
    kinds[k.name] = {{"pings_per_s", k.pings_per_s},
                     {"pings_per_s_least", k.least_pings_per_s},
                     {"pings_per_s_most", k.most_pings_per_s},
                     {"core_ms_per_ping", k.core_ms_per_ping},
                     {"mb_per_ping", k.mb_per_ping}};
  }
  return {{"beams", d.beams},
          {"samples", d.samples},
          {"pings", d.pings},
          {"runs", d.runs},
          {"kinds", std::move(kinds)}};
}

}  // namespace

std::string bench_json(const BenchReport& report) {
  Json cases = Json::object();
  for (const CaseReport& c : report.cases) cases[c.name] = json_of(c);
  Json data_sets = Json::object();
  for (const DataSetReport& d : report.data_sets) data_sets[d.name] = json_of(d);
  const MachineReport& m = report.machine;
  const Json json = {{"cases", std::move(cases)},
                     {"data_sets", std::move(data_sets)},
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

}  // namespace ensonify
