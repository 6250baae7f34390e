#include <algorithm>

#include <fmt/format.h>

#include "scenario/parse.h"

namespace ensonify {
namespace {

constexpr int kMaxBits = 24;
constexpr double kMaxElementM = 10;
constexpr NumberRange kGainErrorDb = from_to(0, 40);
constexpr NumberRange kPhaseErrorDeg = from_to(0, 360);

const std::vector<std::string_view> kArrayKeys = {
    "elements", "spacing_m",     "element_width_m", "shading", "focus",
    "steering", "gain_error_db", "phase_error_deg", "dead"};

void parse_adc(Faults& faults, const Value& receiver, SonarSpec& sonar) {
  const auto map = child(receiver, "adc");
  if (!map || !open_map(faults, *map, {"bits", "full_scale_db"})) return;
  Adc adc;
  read_integer(faults, *map, "bits", 1, kMaxBits, adc.bits, Need::required);
  read_number(faults, *map, "full_scale_db", kLevelDb, adc.full_scale_db, Need::required);
  sonar.adc = adc;
}

void parse_dead(Faults& faults, const Value& receiver, ArraySpec& array) {
  const auto list = child(receiver, "dead");
  if (!list || !open_list(faults, *list)) return;
  for (std::size_t i = 0; i < list->node->items.size(); ++i) {
    int element = 0;
    if (!read_integer_of(faults, item(*list, i), 0, kMaxElements - 1, element)) return;
    array.dead.push_back(element);
  }
  // How many there are may be known with the sound speed only.
  const std::string trouble = dead_trouble(array.dead, array.elements.value_or(kMaxElements));
  if (!trouble.empty()) add_fault(faults, list->place, list->path, trouble);
}

void parse_array(Faults& faults, const Value& receiver, ArraySpec& array) {
  int elements = 0;
  if (read_integer(faults, receiver, "elements", 1, kMaxElements, elements)) {
    array.elements = elements;
  }
  double spacing_m = 0;
  if (read_number(faults, receiver, "spacing_m", above_up_to(0, kMaxElementM), spacing_m)) {
    array.spacing_m = spacing_m;
  }
  read_number(faults, receiver, "element_width_m", from_to(0, kMaxElementM), array.element_width_m);
  if (child(receiver, "shading")) parse_shading(faults, receiver, array.shading.emplace());
  read_choice<Focus>(faults, receiver, "focus",
                     {{"none", Focus::none}, {"dynamic", Focus::dynamic}}, array.focus);
  read_choice<Steering>(faults, receiver, "steering",
                        {{"true_delay", Steering::true_delay}, {"phase", Steering::phase}},
                        array.steering);
  read_number(faults, receiver, "gain_error_db", kGainErrorDb, array.gain_error_db);
  read_number(faults, receiver, "phase_error_deg", kPhaseErrorDeg, array.phase_error_deg);
  parse_dead(faults, receiver, array);
}

}  // namespace

std::string dead_trouble(const std::vector<int>& dead, int elements) {
  std::vector<int> sorted = dead;
  std::sort(sorted.begin(), sorted.end());
  const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
  if (twice != sorted.end()) {
    return fmt::format("element {} is named twice, accepted is each once", *twice);
  }
  if (!sorted.empty() && sorted.back() >= elements) {
    return fmt::format("there is no element {}, accepted is 0 to {} with {} elements",
                       sorted.back(), elements - 1, elements);
  }
  if (std::cmp_less(sorted.size(), elements)) return "";
  return fmt::format("all {} elements are dead, accepted are fewer", elements);
}

void parse_receiver(Faults& faults, const Value& receiver, SonarSpec& sonar) {
  std::vector<std::string_view> keys = {"mode"};
  keys.insert(keys.end(), kArrayKeys.begin(), kArrayKeys.end());
  keys.push_back("adc");
  if (!open_map(faults, receiver, keys)) return;
  bool is_array = false;
  const bool read =
      read_choice<bool>(faults, receiver, "mode", {{"beams", false}, {"array", true}}, is_array);
  if (is_array) {
    parse_array(faults, receiver, sonar.array.emplace());
  } else if (read || !child(receiver, "mode")) {
    refuse_useless(faults, receiver, kArrayKeys,
                   "beside mode: beams (the default), accepted with mode: array");
  }
  parse_adc(faults, receiver, sonar);
}

void check_array(Faults& faults, const Value& root, const Scenario& scenario) {
  const auto at = [&](const char* section, const char* key) {
    const auto map = child(root, section);
    return map ? child(*map, key) : std::nullopt;
  };
  const bool is_array = scenario.sonar.array.has_value();
  if (is_array && scenario.scattering.normalization == Normalization::mean_square) {
    const Value value = *at("scattering", "normalization");
    add_fault(
        faults, value.place, value.path,
        "mean_square is a scale of beams mixed from sectors, which an array has not; accepted "
        "beside sonar.receiver.mode: array is calibrated");
  }
  if (is_array || !scenario.output.selection.channels) return;
  const Value value = *at("output", "channels");
  add_fault(faults, value.place, value.path,
            "there are no elements, accepted with sonar.receiver.mode: array");
}

}  // namespace ensonify
