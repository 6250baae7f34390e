#include "bench/report_whole.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <utility>

#include "core/counted.h"

namespace ensonify {
namespace {

using Json = nlohmann::ordered_json;

Json data_set_json(const DataSetReport& d) {
  Json kinds = Json::object();
  for (const FileKindReport& k : d.kinds) {
    kinds[k.name] = {
        {"pings_per_s", k.pings_per_s},           {"pings_per_s_least", k.least_pings_per_s},
        {"pings_per_s_most", k.most_pings_per_s}, {"core_ms_per_ping", k.core_ms_per_ping},
        {"mb_per_ping", k.mb_per_ping},           {"physics_share", k.physics_share},
        {"stages_ms", times_json(k.stages)}};
  }
  return {{"beams", d.beams},
          {"samples", d.samples},
          {"pings", d.pings},
          {"runs", d.runs},
          {"kinds", std::move(kinds)}};
}

std::string row_text(const DataSetReport& d, const FileKindReport& k) {
  return fmt::format(
      "  {:<16} {:<15} {:>15} {:>6} {:>8}  {:>15} {:>13} {:>9} {:>6.0f} %\n", d.name, k.name,
      fmt::format("{} x {}", d.beams, d.samples), d.pings, rounded_text(k.pings_per_s),
      fmt::format("{} to {}", rounded_text(k.least_pings_per_s), rounded_text(k.most_pings_per_s)),
      rounded_text(k.core_ms_per_ping), rounded_text(k.mb_per_ping), 100 * k.physics_share);
}

struct StageColumn {
  std::string head;
  const std::vector<Timing>* stages;
};

// Shorter times are dominated by reading the clock.
constexpr double kLeastStageMs = 1e-3;

// Omits stages that no column has.
std::string stages_text(std::span<const StageColumn> columns) {
  std::string text = fmt::format("\n  {:<13}", "core ms/ping");
  for (const StageColumn& c : columns) text += fmt::format(" {:>15}", c.head);
  text += "\n";
  for (std::size_t s = 0; s < columns.front().stages->size(); ++s) {
    std::string line = fmt::format("  {:<13}", (*columns.front().stages)[s].name);
    bool has_any = false;
    for (const StageColumn& c : columns) {
      const double ms = (*c.stages)[s].ms;
      line += fmt::format(" {:>15}", ms >= kLeastStageMs ? rounded_text(ms) : "-");
      has_any = has_any || ms >= kLeastStageMs;
    }
    if (has_any) text += line + "\n";
  }
  return text;
}

struct Exponents {
  std::optional<double> core, core_at_end, world, world_at_end;  // at the end: of the last two
};

Exponents exponents_of(const GrowthReport& growth) {
  std::vector<double> value, core, world;
  for (const GrowthPoint& p : growth.points) {
    value.push_back(p.value);
    core.push_back(p.core_ms_per_ping);
    world.push_back(p.world_core_ms);
  }
  const auto last_two = [](const std::vector<double>& all) {
    return std::vector<double>(all.end() - std::min<std::ptrdiff_t>(2, std::ssize(all)), all.end());
  };
  return {fitted_exponent(value, core), fitted_exponent(last_two(value), last_two(core)),
          fitted_exponent(value, world), fitted_exponent(last_two(value), last_two(world))};
}

Json optional_json(const std::optional<double>& value) {
  return value ? Json(*value) : Json(nullptr);
}

std::string exponent_text(const std::optional<double>& exponent) {
  return exponent ? fmt::format("{:.2f}", *exponent + 0.0) : "-";
}

}  // namespace

std::string rounded_text(double value) {
  return value >= 100 ? fmt::format("{:.0f}", value) : fmt::format("{:.3g}", value);
}

Json times_json(const std::vector<Timing>& timings) {
  Json json = Json::object();
  for (const Timing& t : timings) json[t.name] = t.ms;
  return json;
}

Json data_sets_json(const std::vector<DataSetReport>& data_sets) {
  Json json = Json::object();
  for (const DataSetReport& d : data_sets) json[d.name] = data_set_json(d);
  return json;
}

std::string data_sets_text(const std::vector<DataSetReport>& data_sets) {
  if (data_sets.empty()) return {};
  std::string text = fmt::format(
      "\nwhole data sets; medians of {}\n  {:<16} {:<15} {:>15} {:>6} {:>8}  {:>15} {:>13} "
      "{:>9} {:>8}\n",
      counted(static_cast<std::uint64_t>(data_sets.front().runs), "run"), "data set", "files",
      "beams x samples", "pings", "pings/s", "min to max", "core ms/ping", "MB/ping", "physics");
  std::vector<StageColumn> columns;
  for (const DataSetReport& d : data_sets) {
    for (const FileKindReport& k : d.kinds) {
      text += row_text(d, k);
      columns.push_back({d.kinds.size() > 1 ? k.name : d.name, &k.stages});
    }
  }
  constexpr std::size_t kColumns = 6;
  for (std::size_t i = 0; i < columns.size(); i += kColumns) {
    text += stages_text(std::span(columns).subspan(i, std::min(kColumns, columns.size() - i)));
  }
  return text;
}

Json growth_json(const std::vector<GrowthReport>& growth) {
  Json json = Json::object();
  for (const GrowthReport& g : growth) {
    Json points = Json::array();
    for (const GrowthPoint& p : g.points) {
      points.push_back({{"value", p.value},
                        {"pings", p.pings},
                        {"pings_per_s", p.pings_per_s},
                        {"core_ms_per_ping", p.core_ms_per_ping},
                        {"world_core_ms", p.world_core_ms}});
    }
    const Exponents exponents = exponents_of(g);
    json[g.name] = {{"runs", g.runs},
                    {"points", std::move(points)},
                    {"core_time_exponent", optional_json(exponents.core)},
                    {"core_time_exponent_at_end", optional_json(exponents.core_at_end)},
                    {"world_time_exponent", optional_json(exponents.world)},
                    {"world_time_exponent_at_end", optional_json(exponents.world_at_end)}};
  }
  return json;
}

std::string growth_text(const std::vector<GrowthReport>& growth) {
  if (growth.empty()) return {};
  std::string text = fmt::format(
      "\ngrowth of whole data sets; medians of {}; exponent: slope of log time over log size\n"
      "  {:<10} {:>10} {:>6} {:>9} {:>13} {:>14}\n",
      counted(static_cast<std::uint64_t>(growth.front().runs), "run"), "size", "", "pings",
      "pings/s", "core ms/ping", "world, core ms");
  for (const GrowthReport& g : growth) {
    for (const GrowthPoint& p : g.points) {
      text += fmt::format("  {:<10} {:>10.0f} {:>6} {:>9} {:>13} {:>14}\n", g.name, p.value,
                          p.pings, rounded_text(p.pings_per_s), rounded_text(p.core_ms_per_ping),
                          rounded_text(p.world_core_ms));
    }
    const Exponents exponents = exponents_of(g);
    text += fmt::format("  {:<10} {:>27} {:>13} {:>14}\n", "", "exponent",
                        exponent_text(exponents.core), exponent_text(exponents.world));
    text +=
        fmt::format("  {:<10} {:>27} {:>13} {:>14}\n", "", "of the last two",
                    exponent_text(exponents.core_at_end), exponent_text(exponents.world_at_end));
  }
  return text;
}

std::optional<double> fitted_exponent(const std::vector<double>& x, const std::vector<double>& y) {
  double mean_x = 0, mean_y = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    mean_x += std::log(x[i]) / static_cast<double>(x.size());
    mean_y += std::log(y[i]) / static_cast<double>(x.size());
  }
  double square = 0, product = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double dx = std::log(x[i]) - mean_x;
    square += dx * dx;
    product += dx * (std::log(y[i]) - mean_y);
  }
  // Equal sizes differ from their mean by rounding at most.
  if (square < 1e-12) return {};
  return product / square;
}

}  // namespace ensonify
