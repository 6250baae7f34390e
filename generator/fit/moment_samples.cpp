#include "fit/moment_samples.h"

#include <fmt/format.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <utility>

#include "compare/statistics.h"
#include "formats/json.h"
#include "formats/output_place.h"

namespace ensonify {
namespace {

// Subtracts from every block the mean over the values that are defined.
void center(std::vector<std::vector<double>>& pseudo) {
  for (std::size_t b = 0; !pseudo.empty() && b < pseudo.front().size(); ++b) {
    double sum = 0, count = 0;
    for (const auto& value : pseudo) {
      if (std::isnan(value[b])) continue;
      sum += value[b];
      count += 1;
    }
    for (auto& value : pseudo) value[b] -= sum / count;
  }
}

void add_moment(std::vector<double> pseudo, MomentSample& sample) {
  const auto blocks = static_cast<double>(pseudo.size());
  double sum = 0, square = 0;
  for (const double p : pseudo) sum += p;
  const double mean = sum / blocks;
  for (const double p : pseudo) square += (p - mean) * (p - mean);
  sample.value.push_back(mean);
  sample.error.push_back(std::sqrt(square / (blocks * (blocks - 1))));
  sample.pseudo.push_back(std::move(pseudo));
}

}  // namespace

MomentSample moments_of(const BlockStatistics& measured) {
  const std::vector<Estimate> estimates = estimates_of(measured);
  MomentSample sample;
  for (std::size_t s = 0; s < estimates.size(); ++s) {
    const Statistic& statistic = statistics()[s];
    if (!is_smooth(statistic)) continue;
    std::vector<std::vector<double>> pseudo = estimates[s].pseudo;
    if (statistic.positions != nullptr && statistic.free_constant) center(pseudo);
    for (auto& values : pseudo) add_moment(std::move(values), sample);
  }
  return sample;
}

std::vector<std::string> moment_names(const BlockStatistics& measured) {
  std::vector<std::string> names;
  for (const Statistic& statistic : statistics()) {
    if (!is_smooth(statistic)) continue;
    if (statistic.positions == nullptr) {
      names.emplace_back(statistic.id);
      continue;
    }
    for (const double position : statistic.positions(measured)) {
      names.push_back(fmt::format("{} {:.4g}", statistic.id, position));
    }
  }
  return names;
}

namespace {

Json numbers_json(std::span<const double> values) {
  Json json = Json::array();
  for (const double value : values) json.push_back(number_or_null(value));
  return json;
}

std::optional<std::vector<double>> numbers_in(const Json* json) {
  if (json == nullptr || !json->is_array()) return std::nullopt;
  std::vector<double> values;
  for (const Json& value : *json) {
    if (!value.is_number() && !value.is_null()) return std::nullopt;
    values.push_back(value.is_null() ? std::numeric_limits<double>::quiet_NaN()
                                     : value.get<double>());
  }
  return values;
}

std::optional<std::pair<std::vector<double>, MomentSample>> sample_in(const std::string& line) {
  const auto json = parse_json(line);
  if (!json) return std::nullopt;
  const auto keys = numbers_in(member(*json, "keys"));
  const auto value = numbers_in(member(*json, "value")), error = numbers_in(member(*json, "error"));
  const Json* pseudo = member(*json, "pseudo");
  if (!keys || !value || !error || error->size() != value->size() || pseudo == nullptr ||
      !pseudo->is_array() || pseudo->size() != value->size()) {
    return std::nullopt;
  }
  MomentSample sample{*value, *error, {}};
  for (const Json& blocks : *pseudo) {
    auto of_moment = numbers_in(&blocks);
    if (!of_moment) return std::nullopt;
    sample.pseudo.push_back(std::move(*of_moment));
  }
  return std::pair{*keys, std::move(sample)};
}

Error failed(const std::filesystem::path& file) {
  return {ErrorKind::io, file.string() + ": " + std::strerror(errno)};
}

}  // namespace

Result<Evaluations> Evaluations::open(std::filesystem::path file, std::string identity) {
  Evaluations evaluations;
  evaluations.file_ = std::move(file);
  const std::string head = json_line(Json{{"ensonify_fit", 1}, {"identity", identity}});
  std::string text = head + "\n";
  if (std::ifstream in(evaluations.file_); in) {
    std::string line;
    if (!std::getline(in, line) || line != head) {
      return Error{ErrorKind::usage,
                   fmt::format("{}: is of another fit (other keys, scenario, recording, options or "
                               "program); expected another folder, or --overwrite",
                               evaluations.file_.string())};
    }
    while (std::getline(in, line)) {
      auto sample = sample_in(line);
      if (!sample) continue;
      text += line + "\n";
      evaluations.of_values_.insert(std::move(*sample));
    }
  }
  // Written again without a cut line, to which others would be appended.
  if (const Status written = write_whole(evaluations.file_, text); !written) return written.error();
  return evaluations;
}

const MomentSample* Evaluations::find(std::span<const double> values) const {
  const auto found = of_values_.find({values.begin(), values.end()});
  return found == of_values_.end() ? nullptr : &found->second;
}

Status Evaluations::add(std::span<const double> values, const MomentSample& sample) {
  Json json = {{"keys", numbers_json(values)},
               {"value", numbers_json(sample.value)},
               {"error", numbers_json(sample.error)},
               {"pseudo", Json::array()}};
  for (const auto& blocks : sample.pseudo) json["pseudo"].push_back(numbers_json(blocks));
  std::ofstream out(file_, std::ios::app);
  if (!(out << json_line(json) << "\n" << std::flush)) return failed(file_);
  of_values_[{values.begin(), values.end()}] = sample;
  return {};
}

}  // namespace ensonify
