#include "compare/comparison_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "formats/json.h"

namespace ensonify {
namespace {

std::string with_unit(const ComparedStatistic& s) {
  return s.unit.empty() ? s.title : fmt::format("{}, {}", s.title, s.unit);
}

std::string interval_text(double low, double high) {
  return fmt::format("{} to {}", short_number(low), short_number(high));
}

std::string line(const std::string& title, const std::string& real, const std::string& simulated,
                 const std::string& difference, const std::string& interval,
                 const std::string& verdict) {
  return fmt::format("{:<50} {:>9} {:>9} {:>10}  {:<18} {}\n", title, real, simulated, difference,
                     interval, verdict);
}

std::string statistic_line(const ComparedStatistic& s) {
  const std::string title = with_unit(s);
  if (s.verdict == Verdict::left_out) {
    return line(title, "-", "-", "-", "-", fmt::format("left out: {}", s.reason));
  }
  if (s.is_curve()) {
    const char* const both = s.is_histogram ? "histogram" : "curve";
    return line(title, both, both, short_number(s.difference), interval_text(s.low, s.high),
                verdict_word(s.verdict));
  }
  return line(title, short_number(s.real[0]), short_number(s.simulated[0]),
              short_number(s.difference), interval_text(s.low, s.high), verdict_word(s.verdict));
}

Json numbers_json(const std::vector<double>& values) {
  Json json = Json::array();
  for (const double value : values) json.push_back(number_or_null(value));
  return json;
}

Json side_json(const std::vector<double>& values, const std::vector<double>& errors,
               const std::vector<double>& positions, bool is_curve) {
  if (!is_curve) {
    return {{"value", number_or_null(values.empty() ? NAN : values[0])},
            {"standard_error", number_or_null(errors.empty() ? NAN : errors[0])}};
  }
  return {{"positions", numbers_json(positions)},
          {"values", numbers_json(values)},
          {"standard_errors", numbers_json(errors)}};
}

Json statistic_json(const ComparedStatistic& s) {
  Json json = {{"id", s.id}, {"group", s.group}, {"title", s.title}, {"unit", s.unit}};
  json["verdict"] = verdict_word(s.verdict);
  if (s.verdict == Verdict::left_out) {
    json["reason"] = s.reason;
  } else {
    json["difference"] = number_or_null(s.difference);
    json["interval"] = {number_or_null(s.low), number_or_null(s.high)};
    if (s.share) json["permutations"] = *s.share;
  }
  if (s.is_curve()) json["axis"] = s.axis;
  json["real"] = side_json(s.real, s.real_error, s.real_positions, s.is_curve());
  json["simulated"] =
      side_json(s.simulated, s.simulated_error, s.simulated_positions, s.is_curve());
  return json;
}

Json auc_json(const Auc& auc) {
  return {{"auc", auc.value}, {"standard_error", auc.error}, {"interval", {auc.low, auc.high}}};
}

Json classifier_json(const ClassifierResult& result) {
  Json json = auc_json(result.all);
  json["verdict"] = verdict_word(result.all.differs ? Verdict::differs : Verdict::agrees);
  json["real_patches"] = result.real_patches;
  json["simulated_patches"] = result.simulated_patches;
  const auto names = feature_names();
  for (std::size_t k = 0; k < names.size(); ++k) {
    Json single = {{"feature", names[k]}};
    single.update(auc_json(result.single[k]));
    json["features"].push_back(std::move(single));
  }
  return json;
}

std::string classifier_text(const ClassifierResult& result) {
  const auto auc_line = [](const std::string& title, const Auc& auc) {
    return line(title, "", "", short_number(auc.value), interval_text(auc.low, auc.high),
                verdict_word(auc.differs ? Verdict::differs : Verdict::agrees));
  };
  std::string text = "classifier\n" + auc_line("  AUC on patches, 0.5 if alike", result.all);
  const auto names = feature_names();
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (result.single[k].differs) order.push_back(k);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::abs(result.single[a].value - 0.5) > std::abs(result.single[b].value - 0.5);
  });
  for (const std::size_t k : order) {
    text += auc_line(fmt::format("  by {} alone", names[k]), result.single[k]);
  }
  return text;
}

}  // namespace

std::string short_number(double value) {
  if (!std::isfinite(value)) return "-";
  if (value != 0 && std::abs(value) < 0.0005) return fmt::format("{:.1e}", value);
  return std::abs(value) >= 100 ? fmt::format("{:.0f}", value) : fmt::format("{:.3g}", value);
}

std::string comparison_table(const Comparison& comparison) {
  const char* const images = comparison.crops ? "crops" : "pings";
  std::string text = fmt::format("real: {} {} in {} blocks; simulated: {} {} in {} blocks\n",
                                 comparison.real_images, images, comparison.real_blocks,
                                 comparison.simulated_images, images, comparison.simulated_blocks);
  if (!comparison.crops) {
    text += fmt::format("mean level, real less simulated: {:.2f} dB (free)\n", comparison.gain_db);
  }
  text += "\n" + line("", "real", "simulated", "difference", "95 % interval", "");
  std::string group;
  std::size_t compared = 0, differs = 0;
  for (const ComparedStatistic& s : comparison.statistics) {
    if (s.group != group) text += (group = s.group) + "\n";
    ComparedStatistic indented = s;
    indented.title = "  " + s.title;
    text += statistic_line(indented);
    if (s.verdict != Verdict::left_out) ++compared;
    if (s.verdict == Verdict::differs) ++differs;
  }
  if (comparison.classifier) {
    text += classifier_text(*comparison.classifier);
  } else {
    text += "classifier\n  left out: too few patches of the ground\n";
  }
  text += fmt::format(
      "\n{} of {} statistics differ; of equal data sets about one in 20 does by chance\n", differs,
      compared);
  for (const std::string& note : comparison.notes) text += "note: " + note + "\n";
  return text;
}

std::string comparison_json(const Comparison& comparison, const std::string& real,
                            const std::string& simulated) {
  Json json;
  json["real"] = {
      {"folder", real}, {"images", comparison.real_images}, {"blocks", comparison.real_blocks}};
  json["simulated"] = {{"folder", simulated},
                       {"images", comparison.simulated_images},
                       {"blocks", comparison.simulated_blocks}};
  json["crops"] = comparison.crops;
  json["gain_db"] = comparison.gain_db;
  json["statistics"] = Json::array();
  for (const ComparedStatistic& s : comparison.statistics) {
    json["statistics"].push_back(statistic_json(s));
  }
  json["classifier"] = comparison.classifier ? classifier_json(*comparison.classifier) : Json();
  json["notes"] = comparison.notes;
  return json_text(json);
}

}  // namespace ensonify
