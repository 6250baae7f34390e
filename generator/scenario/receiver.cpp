// The beams and the receiver of the sonar: fan, shading, array, converter.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/units.h"
#include "scenario/sections.h"

namespace ensonify {
namespace {

constexpr int kMaxBeams = 65536;
constexpr int kMaxNbar = 50;

// At -13.3 dB a line without weights is there already; at -80 dB no array is built well enough.
constexpr NumberRange kSideLobe = from_to(-80, -14);

// The smallest nbar from which on Taylor's sigma = nbar / sqrt(A^2 + (nbar - 1/2)^2) falls with
// nbar, so that his near side lobes fall outwards: nbar/2 - 1/(8 nbar + 4) >= A^2. For nbar that
// need not be whole this is his nbar >= 2 A^2 + 1/2 (IRE Trans. Antennas Propag. 3, 1955).
int smallest_nbar(double side_lobe_db) {
  const double a = std::acosh(std::pow(10.0, -side_lobe_db / 20)) / kPi;
  int nbar = 2;
  while (nbar / 2.0 - 1 / (8.0 * nbar + 4) < a * a) ++nbar;
  return nbar;
}

constexpr int kMaxBits = 24;
constexpr double kMaxElementM = 10;
constexpr NumberRange kGainErrorDb = from_to(0, 40);
constexpr NumberRange kPhaseErrorDeg = from_to(0, 360);

void taylor_fields(Fields& f, BeamShading& shading) {
  f.number("side_lobe_db", shading.side_lobe_db, kSideLobe);
  const int smallest = smallest_nbar(shading.side_lobe_db);
  if (!f.writing() && shading.nbar < smallest) shading.nbar = smallest;
  if (!f.integer("nbar", shading.nbar, 2, kMaxNbar) || shading.nbar >= smallest) return;
  f.fault("nbar",
          fmt::format("nbar {} is too small for side lobes of {} dB, which would grow outwards; "
                      "accepted is {} or more",
                      shading.nbar, shading.side_lobe_db, smallest));
}

// Whether a kind of shading was read or written.
bool shading_fields(Fields& f, BeamShading& shading, Rule rule = {}) {
  if (!f.begin_kind("shading", shading.kind, Shading::chebyshev, rule)) return false;
  if (shading.kind == Shading::taylor) taylor_fields(f, shading);
  if (shading.kind == Shading::chebyshev) {
    f.number("side_lobe_db", shading.side_lobe_db, kSideLobe);
  }
  f.end();
  return true;
}

// fov_deg, or spacing_deg, which is that divided by the count.
void fan_fields(Fields& f, SonarSpec& sonar, Need need, bool counted) {
  constexpr std::string_view kKeys[] = {"spacing_deg", "fov_deg"};
  const auto which = f.only_key(
      kKeys, 1, "either alone: spacing_deg, or fov_deg, which is that times count", Need::optional);
  if (which == 1u) f.number("fov_deg", sonar.beam_fov_deg, kAngle);
  if (which == 0u) {
    double spacing_deg = 0;
    if (!f.number("spacing_deg", spacing_deg, kAngle)) return;
    const double fov = spacing_deg * sonar.beam_count;
    if (!counted || fov <= kAngle.high) {
      sonar.beam_fov_deg = fov;
      return;
    }
    f.fault("spacing_deg",
            fmt::format("{} beams of {} degrees span {} degrees, at most 180 are accepted",
                        sonar.beam_count, spacing_deg, fov));
  }
  const bool either = f.peek("spacing_deg") != nullptr || f.peek("fov_deg") != nullptr;
  if (f.writing() || either || need == Need::optional) return;
  f.fault("fov_deg",
          fmt::format("missing, accepted is {}, or spacing_deg, which is that divided by count",
                      in_words(kAngle, "number")));
}

void array_fields(Fields& f, ArraySpec& array, const Rule& rule) {
  f.integer("elements", array.elements, 1, kMaxElements, rule);
  f.number("spacing_m", array.spacing_m, above_up_to(0, kMaxElementM), rule);
  BeamShading shading = array.shading.value_or(BeamShading{});
  const Rule shading_rule = written_if(array.shading.has_value(), rule);
  if (shading_fields(f, shading, shading_rule)) array.shading = shading;
  f.number("element_width_m", array.element_width_m, from_to(0, kMaxElementM), rule);
  f.choice<Focus>("focus", array.focus, words_to(Focus::dynamic), rule);
  f.choice<Steering>("steering", array.steering, words_to(Steering::phase), rule);
  f.number("gain_error_db", array.gain_error_db, kGainErrorDb, rule);
  f.number("phase_error_deg", array.phase_error_deg, kPhaseErrorDeg, rule);
  const ReadWatch watch(f);
  const bool listed = f.list("dead", array.dead, {}, rule, [&](const std::string& at, int& dead) {
    f.integer(at, dead, 0, kMaxElements - 1);
  });
  if (!listed || !watch.is_well()) return;
  // How many there are may be known with the sound speed only.
  const std::string trouble = dead_trouble(array.dead, array.elements.value_or(kMaxElements));
  if (!trouble.empty()) f.fault("dead", trouble);
}

}  // namespace

void beam_fields(Fields& f, SonarSpec& sonar, Need need) {
  const bool counted = f.integer("count", sonar.beam_count, 1, kMaxBeams, {.need = need});
  fan_fields(f, sonar, need, counted);
  f.number("width_deg", sonar.beam_width_deg, kAngle, {.need = need});
  shading_fields(f, sonar.shading);
  f.number("transmit_width_deg", sonar.transmit_width_deg, kAngle);
}

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

void receiver_fields(Fields& f, SonarSpec& sonar) {
  bool is_array = sonar.array.has_value();
  const bool read =
      f.choice<bool>("mode", is_array, {{"beams", false}, {"array", true}}, written_if(is_array));
  const bool useless = !is_array && (f.writing() || read || f.peek("mode") == nullptr);
  ArraySpec array = sonar.array.value_or(ArraySpec{});
  array_fields(f, array,
               useless_if(useless, "beside mode: beams (the default), accepted with mode: array"));
  if (is_array) sonar.array = std::move(array);
  if (!f.begin("adc", written_if(sonar.adc.has_value()))) return;
  Adc adc = sonar.adc.value_or(Adc{});
  f.integer("bits", adc.bits, 1, kMaxBits, kRequired);
  f.number("full_scale_db", adc.full_scale_db, kLevelDb, kRequired);
  sonar.adc = adc;
  f.end();
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
