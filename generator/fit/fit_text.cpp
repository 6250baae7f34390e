#include "fit/fit_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "formats/json.h"

namespace ensonify {
namespace {

std::optional<double> number_in(std::string_view text) {
  double value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = read.ec == std::errc() && read.ptr == text.data() + text.size();
  return whole && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

Error refused(const std::string& text, const char* why) {
  return {ErrorKind::usage,
          fmt::format("--key {}: {}; expected PATH=LOW:HIGH or PATH=LOW:HIGH:log, such as "
                      "sonar.beams.receive_width_deg=0.5:2",
                      text, why)};
}

}  // namespace

Result<FitKey> parse_key(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) return refused(text, "there is no path with =");
  std::string_view range = std::string_view(text).substr(equals + 1);
  FitKey key;
  key.path = text.substr(0, equals);
  if (range.ends_with(":log")) {
    key.log = true;
    range.remove_suffix(4);
  }
  const std::size_t colon = range.find(':');
  if (colon == std::string_view::npos) return refused(text, "the range has no colon");
  const auto low = number_in(range.substr(0, colon)), high = number_in(range.substr(colon + 1));
  if (!low || !high) return refused(text, "a bound is not a number");
  if (!(*low < *high)) return refused(text, "the first bound is not below the second");
  if (key.log && !(*low > 0)) return refused(text, "a logarithmic range must be above 0");
  key.low = *low;
  key.high = *high;
  return key;
}

std::string key_text(double value) { return fmt::format("{}", value); }

namespace {

const char* verdict(const FittedKey& key) {
  return key.identified ? "identified" : "not identified";
}

Json key_json(const FitKey& key, const FittedKey& fitted) {
  Json json = {{"path", key.path},
               {"range", {key.low, key.high}},
               {"log", key.log},
               {"value", fitted.value},
               {"standard_error", fitted.error},
               {"interval", {fitted.low, fitted.high}},
               {"identified", fitted.identified},
               {"profile", Json::array()}};
  for (const DeviancePoint& point : fitted.profile) {
    json["profile"].push_back({{"value", point.value}, {"deviance", point.deviance}});
  }
  return json;
}

std::vector<std::string> parts_of(const std::string& path) {
  std::vector<std::string> parts;
  std::size_t from = 0;
  for (std::size_t dot; (dot = path.find('.', from)) != std::string::npos; from = dot + 1) {
    parts.push_back(path.substr(from, dot - from));
  }
  parts.push_back(path.substr(from));
  return parts;
}

bool is_index(const std::string& part) {
  return !part.empty() && part.find_first_not_of("0123456789") == std::string::npos;
}

// Items of lists have no place in a map.
bool fits_in_maps(const std::vector<std::string>& parts) {
  return std::none_of(parts.begin(), parts.end(), is_index) && parts.front() != "objects" &&
         parts.front() != "point_targets" && parts.front() != "volumes";
}

}  // namespace

std::string fit_table(std::span<const FitKey> keys, const Fit& fit) {
  std::size_t width = 3;
  for (const FitKey& key : keys) width = std::max(width, key.path.size());
  std::string text = fmt::format("{:<{}} {:>12} {:>12} {:>25}\n", "key", width, "value", "error",
                                 "95 % interval");
  for (std::size_t k = 0; k < keys.size(); ++k) {
    const FittedKey& fitted = fit.keys[k];
    text += fmt::format("{:<{}} {:>12.5g} {:>12.3g} {:>25}  {}\n", keys[k].path, width,
                        fitted.value, fitted.error,
                        fmt::format("{:.5g} to {:.5g}", fitted.low, fitted.high), verdict(fitted));
  }
  text += fmt::format("{} statistics, {} simulations; the fit differs by {:.2f} standard errors "
                      "(rms){}\n",
                      fit.moments, fit.evaluations, fit.misfit,
                      fit.converged ? "" : "; the search ended before it converged");
  return text;
}

std::string fit_json(std::span<const FitKey> keys, const Fit& fit, const FitFacts& facts) {
  Json json = {{"ensonify_fit", 1},
               {"scenario", facts.scenario},
               {"recording", facts.recording},
               {"pings", facts.pings},
               {"blocks", facts.blocks},
               {"simulations", fit.evaluations},
               {"converged", fit.converged},
               {"rms_misfit", fit.misfit},
               {"keys", Json::array()},
               {"correlation", fit.correlation},
               {"statistics", Json::array()}};
  for (std::size_t k = 0; k < keys.size(); ++k) {
    json["keys"].push_back(key_json(keys[k], fit.keys[k]));
  }
  for (std::size_t m = 0; m < facts.moment_names.size(); ++m) {
    if (!fit.used[m]) continue;
    json["statistics"].push_back({{"name", facts.moment_names[m]},
                                  {"recording", number_or_null(facts.target.value[m])},
                                  {"standard_error", number_or_null(facts.target.error[m])},
                                  {"fit", number_or_null(fit.simulated[m])}});
  }
  return json_text(json);
}

std::string fit_card(std::span<const FitKey> keys, const Fit& fit, const FitFacts& facts) {
  std::string text = fmt::format(
      "# Keys of {} fitted to {}: {} pings in {} blocks, {} statistics, which the fit misses by {:.2f} "
      "standard errors (rms).\n# Behind each value: its 95 % interval.\n",
      facts.scenario, facts.recording, facts.pings, facts.blocks, fit.moments, fit.misfit);
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < keys.size(); ++k) order.push_back(k);
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return keys[a].path < keys[b].path; });
  std::string of_lists;
  std::vector<std::string> open;
  for (const std::size_t k : order) {
    const FittedKey& fitted = fit.keys[k];
    const std::string value = fmt::format("{:.6g}", fitted.value);
    const std::string remark =
        fmt::format("# {:.5g} to {:.5g}, {}", fitted.low, fitted.high, verdict(fitted));
    const std::vector<std::string> parts = parts_of(keys[k].path);
    if (!fits_in_maps(parts)) {
      of_lists += fmt::format("# --set {}={}  {}\n", keys[k].path, value, remark);
      continue;
    }
    std::size_t common = 0;
    while (common < open.size() && common + 1 < parts.size() && open[common] == parts[common]) {
      ++common;
    }
    for (std::size_t depth = common; depth + 1 < parts.size(); ++depth) {
      text += fmt::format("{:{}}{}:\n", "", 2 * depth, parts[depth]);
    }
    text += fmt::format("{:{}}{}: {}  {}\n", "", 2 * (parts.size() - 1), parts.back(), value,
                        remark);
    open.assign(parts.begin(), parts.end() - 1);
  }
  return text + of_lists;
}

}  // namespace ensonify
