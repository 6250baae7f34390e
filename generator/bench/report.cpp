#include "bench/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/counted.h"

namespace ensonify {
namespace {

using Json = nlohmann::ordered_json;

// Three digits, or all before the point.
std::string rounded_text(double value) {
  return value >= 100 ? fmt::format("{:.0f}", value) : fmt::format("{:.3g}", value);
}

struct Exponents {
  std::optional<double> all, last_two;
};

Exponents exponents_of(const BenchTable& table, double BenchRow::*time) {
  std::vector<double> size, ms;
  for (const BenchRow& row : table.rows) {
    size.push_back(row.sizes.*table.grows);
    ms.push_back(row.*time);
  }
  const auto last_two = [](const std::vector<double>& values) {
    return std::vector<double>(values.end() - std::min<std::ptrdiff_t>(2, std::ssize(values)),
                               values.end());
  };
  return {fitted_exponent(size, ms), fitted_exponent(last_two(size), last_two(ms))};
}

Json json_of(const Exponents& exponents) {
  const auto number = [](const std::optional<double>& value) {
    return value ? Json(*value) : Json(nullptr);
  };
  return {{"all", number(exponents.all)}, {"last_two", number(exponents.last_two)}};
}

Json json_of(const BenchRow& row) {
  const BenchSizes& sizes = row.sizes;
  Json json = {{"threads", sizes.threads},
               {"beams", sizes.beams},
               {"samples", sizes.samples},
               {"rays", sizes.rays},
               {"objects", sizes.objects},
               {"triangles", sizes.triangles},
               {"pings", row.pings},
               {"pings_per_s", row.pings_per_s},
               {"pings_per_s_least", row.least_pings_per_s},
               {"pings_per_s_most", row.most_pings_per_s},
               {"core_ms_per_ping", row.core_ms_per_ping},
               {"mb_per_ping", row.mb_per_ping},
               {"world_core_ms", row.world_core_ms},
               {"physics_share", row.physics_share},
               {"stages_ms", Json::object()}};
  for (const StageMs& stage : row.stages) json["stages_ms"][stage.name] = stage.ms;
  if (!row.error) return json;
  json["error"] = row.error->relative;
  json["error_worst_tenth"] = row.error->worst_tenth;
  return json;
}

Json json_of(const BenchTable& table) {
  Json rows = Json::object();
  for (const BenchRow& row : table.rows) rows[row.name] = json_of(row);
  Json json = {{"runs", table.runs}, {"rows", std::move(rows)}};
  if (table.grows == nullptr) return json;
  json["exponents"] = {{"core", json_of(exponents_of(table, &BenchRow::core_ms_per_ping))},
                       {"world", json_of(exponents_of(table, &BenchRow::world_core_ms))}};
  return json;
}

constexpr char kColumns[] =
    "  {:<16} {:>15} {:>8} {:>6} {:>8}  {:>15} {:>12} {:>14} {:>8} {:>8}{}\n";

std::string row_text(const BenchRow& row, const std::string& error) {
  return fmt::format(
      kColumns, row.name, fmt::format("{:.0f} x {:.0f}", row.sizes.beams, row.sizes.samples),
      fmt::format("{:.0f}", row.sizes.rays), row.pings, rounded_text(row.pings_per_s),
      fmt::format("{} to {}", rounded_text(row.least_pings_per_s),
                  rounded_text(row.most_pings_per_s)),
      rounded_text(row.core_ms_per_ping), rounded_text(row.world_core_ms),
      rounded_text(row.mb_per_ping), fmt::format("{:.0f} %", 100 * row.physics_share), error);
}

std::string exponents_text(const BenchTable& table) {
  const Exponents core = exponents_of(table, &BenchRow::core_ms_per_ping);
  const Exponents world = exponents_of(table, &BenchRow::world_core_ms);
  const auto text = [](const std::optional<double>& exponent) {
    return exponent ? fmt::format("{:.2f}", *exponent + 0.0) : "-";
  };
  const auto line = [&](const char* name, const auto& in_core, const auto& in_world) {
    return fmt::format("  {:<74} {:>12} {:>14}\n", name, text(in_core), text(in_world));
  };
  return line("exponent: slope of log time over log size", core.all, world.all) +
         line("... of the last two", core.last_two, world.last_two);
}

// Shorter times are dominated by reading the clock.
constexpr double kLeastStageMs = 1e-3;

// Omits stages that no row has.
std::string stages_text(std::span<const BenchRow> rows) {
  std::string text = fmt::format("\n  {:<13}", "core ms/ping");
  for (const BenchRow& row : rows) text += fmt::format(" {:>15}", row.name);
  text += "\n";
  for (std::size_t s = 0; s < rows.front().stages.size(); ++s) {
    std::string line = fmt::format("  {:<13}", rows.front().stages[s].name);
    bool has_any = false;
    for (const BenchRow& row : rows) {
      const double ms = row.stages[s].ms;
      line += fmt::format(" {:>15}", ms >= kLeastStageMs ? rounded_text(ms) : "-");
      has_any = has_any || ms >= kLeastStageMs;
    }
    if (has_any) text += line + "\n";
  }
  return text;
}

std::string table_text(const BenchTable& table) {
  std::string text = fmt::format("\n{}: {}; medians of {}\n", table.name, table.title,
                                 counted(static_cast<std::uint64_t>(table.runs), "run"));
  const bool has_errors = std::any_of(table.rows.begin(), table.rows.end(),
                                      [](const BenchRow& row) { return row.error.has_value(); });
  text += fmt::format(kColumns, "", "beams x samples", "rays", "pings", "pings/s", "min to max",
                      "core ms/ping", "world, core ms", "MB/ping", "physics",
                      has_errors ? "  error, worst tenth" : "");
  for (const BenchRow& row : table.rows) {
    text += row_text(row, row.error ? fmt::format("  {:.1e}, {:.1e}", row.error->relative,
                                                  row.error->worst_tenth)
                                    : "");
  }
  if (table.grows != nullptr) return text + exponents_text(table);
  constexpr std::size_t kSideBySide = 6;
  for (std::size_t i = 0; i < table.rows.size(); i += kSideBySide) {
    text +=
        stages_text(std::span(table.rows).subspan(i, std::min(kSideBySide, table.rows.size() - i)));
  }
  return text;
}

}  // namespace

std::string bench_json(const BenchReport& report) {
  const MachineReport& m = report.machine;
  Json json = {{"machine",
                {{"copy_gb_s", m.copy_gb_s},
                 {"disk_mb_s", m.disk_mb_s},
                 {"disk_is_memory", m.disk_is_memory},
                 {"disk_is_direct", m.disk_is_direct},
                 {"threads", m.threads},
                 {"simd", m.simd}}},
               {"tables", Json::object()}};
  for (const BenchTable& table : report.tables) json["tables"][table.name] = json_of(table);
  return json.dump(2) + "\n";
}

std::string bench_text(const BenchReport& report) {
  const MachineReport& m = report.machine;
  std::string text = fmt::format(
      "machine: {}, {}; one core copies {:.1f} GB/s; disk {:.0f} MB/s{}\n",
      counted(static_cast<std::uint64_t>(m.threads), "thread"), m.simd, m.copy_gb_s, m.disk_mb_s,
      m.disk_is_memory   ? " (a file system in memory; name another folder with --disk)"
      : m.disk_is_direct ? ""
                         : " (through the page cache, synchronized)");
  for (const BenchTable& table : report.tables) text += table_text(table);
  return text;
}

SeriesError series_error(std::span<const std::complex<float>> series,
                         std::span<const std::complex<float>> exact, int beams) {
  constexpr int kTenths = 10;
  constexpr double kFaintTenth = 1e-6;
  const std::size_t samples = exact.size() / static_cast<std::size_t>(beams);
  double wrong[kTenths] = {}, whole[kTenths] = {};
  for (std::size_t cell = 0; cell < exact.size(); ++cell) {
    const std::size_t tenth = cell % samples * kTenths / samples;
    const std::complex<double> expected = exact[cell];
    wrong[tenth] += std::norm(std::complex<double>(series[cell]) - expected);
    whole[tenth] += std::norm(expected);
  }
  double all_wrong = 0, all = 0;
  for (int t = 0; t < kTenths; ++t) {
    all_wrong += wrong[t];
    all += whole[t];
  }
  SeriesError error{std::sqrt(all_wrong / all), 0};
  for (int t = 0; t < kTenths; ++t) {
    if (whole[t] < kFaintTenth * kFaintTenth * all) continue;
    error.worst_tenth = std::max(error.worst_tenth, std::sqrt(wrong[t] / whole[t]));
  }
  return error;
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
