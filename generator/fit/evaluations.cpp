#include "fit/evaluations.h"

#include <fmt/format.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <utility>

#include "formats/json.h"
#include "formats/output_place.h"

namespace ensonify {
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
