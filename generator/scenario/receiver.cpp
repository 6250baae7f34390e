// The keys of the beams and the receiver of the sonar: fan, shading, array, ADC.
#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "core/units.h"
#include "scenario/sections.h"

namespace ensonify {
namespace {

constexpr int kMaxBeams = 65536;
// Unequal beams are mixed by a matrix [beams x beams].
constexpr int kMaxUnequal = 1024;
// Degrees by which rounding may move an edge.
constexpr double kRoundingDeg = 1e-9;
constexpr int kMaxNbar = 50;

// A line array without weights already has side lobes of -13.3 dB, and no array is built accurately
// enough for less than -80 dB.
constexpr NumberRange kSideLobe = from_to(-80, -14);

// The smallest nbar for which Taylor's sigma = nbar / sqrt(A^2 + (nbar - 1/2)^2) decreases with
// nbar, so that the near side lobes decrease outward: nbar/2 - 1/(8 nbar + 4) >= A^2. For real nbar
// this is Taylor's nbar >= 2 A^2 + 1/2 (IRE Trans. Antennas Propag. 3, 1955).
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
  f.number(
      {"side_lobe_db", "Side-lobe level", "Level of the near side lobes relative to the main lobe"},
      shading.side_lobe_db, kSideLobe);
  const int smallest = smallest_nbar(shading.side_lobe_db);
  if (!f.writing() && shading.nbar < smallest) shading.nbar = smallest;
  const bool read =
      f.integer({"nbar", "Near side lobes",
                 "Number of near side lobes, large enough for side_lobe_db; left out: 5, or more "
                 "where side_lobe_db requires it"},
                shading.nbar, 2, kMaxNbar, {.has_default = false});
  if (!read || shading.nbar >= smallest) return;
  f.fault("nbar", fmt::format("nbar {} is too small for side lobes of {} dB, which would increase "
                              "outward; expected {} or more",
                              shading.nbar, shading.side_lobe_db, smallest));
}

// In the order of Shading.
constexpr KindText kShadingTexts[] = {
    {"Uniform", "No weighting; highest side lobe at -13.3 dB"},
    {"Hann", "Highest side lobe at -31.5 dB; the others fall fast"},
    {"Taylor", "Near side lobes at about side_lobe_db; those beyond number nbar fall"},
    {"Chebyshev", "All side lobes at side_lobe_db"},
};

// Reads a list with one number for each beam. Returns whether it can be used.
bool beam_list(Fields& f, const KeyText& key, const NumberRange& range, std::vector<double>& values,
               const SonarSpec& sonar, bool counted) {
  const ReadWatch watch(f);
  const std::string accepted = fmt::format("2 to {} numbers, one for each beam", kMaxUnequal);
  const ListWords words{.missing = {}, .accepted = accepted, .least = 2, .most = kMaxUnequal};
  const bool read =
      f.list(key, values, words, written_if(!values.empty(), {.has_default = false}),
             [&](const std::string& at, double& value) { f.number(at, value, range, kRequired); });
  if (!read || !counted || !watch.is_well()) return false;
  if (std::cmp_equal(values.size(), sonar.beam_count)) return true;
  f.fault(key.key, fmt::format("the number of values is {}, but count is {}; expected one for each "
                               "beam",
                               values.size(), sonar.beam_count));
  return false;
}

// Azimuths must rise, and beam cells end halfway between them, within 90 degrees of the boresight.
void check_azimuths(FieldReader& reader, SonarSpec& sonar) {
  const std::vector<double>& a = sonar.azimuths_deg;
  const Value values = *child(reader.map(), "azimuths_deg");
  const auto fault_at = [&](std::size_t i, const std::string& text) {
    const Value wrong = item(values, i);
    add_fault(reader.faults(), wrong.place, wrong.path, text);
  };
  bool rises = true;
  for (std::size_t i = 1; i < a.size(); ++i) {
    if (a[i] > a[i - 1]) continue;
    rises = false;
    fault_at(i, fmt::format("{} is not above the {} before it; expected increasing azimuths, from "
                            "starboard to port",
                            a[i], a[i - 1]));
  }
  if (!rises) return;
  const std::size_t last = a.size() - 1;
  const double low = a[0] - (a[1] - a[0]) / 2, high = a[last] + (a[last] - a[last - 1]) / 2;
  sonar.beam_fov_deg = high - low;
  const auto beyond = [](double edge) {
    return fmt::format(
        "the beam cell, which ends as far beyond the beam as its other border, ends "
        "at {:.6g} degrees; expected at most 90 degrees to either side",
        edge);
  };
  if (low < -90 - kRoundingDeg) fault_at(0, beyond(low));
  if (high > 90 + kRoundingDeg) fault_at(last, beyond(high));
}

// A fan has fov_deg, or spacing_deg, which is fov_deg divided by count, or the azimuth of each
// beam.
void fan_fields(Fields& f, SonarSpec& sonar, Need need, bool counted) {
  constexpr std::string_view kKeys[] = {"spacing_deg", "fov_deg", "azimuths_deg"};
  const auto which =
      f.only_key(kKeys, sonar.azimuths_deg.empty() ? 1 : 2,
                 "one of spacing_deg, fov_deg, which is spacing_deg times count, and azimuths_deg",
                 Need::optional);
  const Rule given{.has_default = false};
  if (which == 2u &&
      beam_list(f,
                {kKeys[2], "Beam azimuths",
                 "Azimuth of each beam, positive to port, increasing from beam 0 to starboard, if "
                 "beams are not equally spaced; beam cells end halfway between them; in place of "
                 "fov_deg"},
                from_to(-90, 90), sonar.azimuths_deg, sonar, counted)) {
    check_azimuths(*f.reader(), sonar);
  }
  if (which == 1u) {
    f.number({kKeys[1], "Fan width",
              "Angle from the outer edge of the first beam cell to the outer edge of the last; in "
              "place of spacing_deg"},
             sonar.beam_fov_deg, kAngle, given);
  }
  if (which == 0u) {
    double spacing_deg = 0;
    const bool read =
        f.number({kKeys[0], "Beam spacing",
                  "Angle between neighboring beams, fov_deg / count; its product with count is at "
                  "most 180 degrees; in place of fov_deg"},
                 spacing_deg, kAngle, given);
    if (!read) return;
    const double fov = spacing_deg * sonar.beam_count;
    if (!counted || fov <= kAngle.high) {
      sonar.beam_fov_deg = fov;
      return;
    }
    f.fault("spacing_deg",
            fmt::format("{} beams of {} degrees span {} degrees; expected at most 180",
                        sonar.beam_count, spacing_deg, fov));
  }
  if (f.writing() || need == Need::optional) return;
  for (const std::string_view key : kKeys) {
    if (f.peek(key) != nullptr) return;
  }
  f.fault("fov_deg",
          fmt::format("missing; expected {}, or spacing_deg, which is fov_deg divided by count",
                      in_words(kAngle, "number")));
}

// Either one width for all beams or a list.
void width_fields(Fields& f, SonarSpec& sonar, Need need, bool counted) {
  f.renamed("width_deg", "receive_width_deg");
  constexpr std::string_view kKeys[] = {"receive_width_deg", "receive_widths_deg"};
  const auto which =
      f.only_key(kKeys, sonar.receive_widths_deg.empty() ? 0 : 1,
                 "either receive_width_deg, or receive_widths_deg with one width for each beam",
                 Need::optional);
  if (which == 0u) {
    f.number({kKeys[0], "Receive beam width", "-3 dB width of the receive pattern in azimuth"},
             sonar.beam_width_deg, kAngle, {.has_default = false});
  }
  if (which == 1u &&
      beam_list(f,
                {kKeys[1], "Receive beam widths",
                 "-3 dB width of the receive pattern of each beam, if beams are not equally wide; "
                 "in place of receive_width_deg"},
                kAngle, sonar.receive_widths_deg, sonar, counted)) {
    double sum = 0;
    for (const double width : sonar.receive_widths_deg) sum += width;
    sonar.beam_width_deg = sum / sonar.beam_count;
  }
  if (f.writing() || need == Need::optional || f.peek("width_deg") != nullptr) return;
  if (f.peek(kKeys[0]) != nullptr || f.peek(kKeys[1]) != nullptr) return;
  f.fault(kKeys[0], fmt::format("missing; expected {}", in_words(kAngle, "number")));
}

void element_fields(Fields& f, ArraySpec& array, const Rule& rule) {
  f.integer({"elements", "Elements",
             "Number of elements of the array; left out: as many as give the receive beam width"},
            array.elements, 1, kMaxElements, rule);
  f.number({"spacing_m", "Element spacing",
            "Distance from one element to the next; left out: half a wavelength"},
           array.spacing_m, above_up_to(0, kMaxElementM), rule);
  BeamShading shading = array.shading.value_or(BeamShading{});
  Rule shading_rule = written_if(array.shading.has_value(), rule);
  shading_rule.has_default = array.shading.has_value();
  if (shading_fields(f,
                     {"shading", "Element weights",
                      "Weights of the array's elements; left out: those of beams.shading"},
                     shading, shading_rule)) {
    array.shading = shading;
  }
  f.number({"element_width_m", "Element width",
            "Aperture of each element along the array; 0: the element is omnidirectional"},
           array.element_width_m, from_to(0, kMaxElementM), rule);
}

void array_fields(Fields& f, ArraySpec& array, const Rule& rule) {
  element_fields(f, array, rule);
  f.choice<Focus>({"focus", "Focus",
                   "dynamic: each sample is focused at the range of its echoes; none: the array is "
                   "focused at infinity"},
                  array.focus, words_to(Focus::dynamic), rule);
  f.choice<Steering>({"steering", "Steering",
                      "true_delay: beams are steered by delaying the whole signal; phase: by the "
                      "phase of the carrier alone"},
                     array.steering, words_to(Steering::phase), rule);
  f.number({"gain_error_db", "Gain error",
            "Standard deviation of the gain over the elements, sampled once for the data set"},
           array.gain_error_db, kGainErrorDb, rule);
  f.number({"phase_error_deg", "Phase error",
            "Standard deviation of the phase over the elements, sampled once for the data set"},
           array.phase_error_deg, kPhaseErrorDeg, rule);
  const ReadWatch watch(f);
  const bool listed = f.list(
      {"dead", "Dead elements",
       "Indices of the elements that receive nothing; element 0 is to starboard; left out: none"},
      array.dead, {}, rule,
      [&](const std::string& at, int& dead) { f.integer(at, dead, 0, kMaxElements - 1); });
  if (!listed || !watch.is_well()) return;
  // The number of elements may be known only once the sound speed is.
  const std::string trouble = dead_trouble(array.dead, array.elements.value_or(kMaxElements));
  if (!trouble.empty()) f.fault("dead", trouble);
}

void adc_fields(Fields& f, std::optional<Adc>& given) {
  const Rule rule = written_if(given.has_value(), {.has_default = given.has_value()});
  if (!f.begin({"adc", "ADC",
                "Analog-to-digital converter: the real and imaginary parts of each sample are "
                "rounded to its steps and clipped; left out: no ADC"},
               rule)) {
    return;
  }
  Adc adc = given.value_or(Adc{});
  f.integer({"bits", "Bits", "Bits of the ADC, which has 2^bits steps"}, adc.bits, 1, kMaxBits,
            kRequired);
  f.number({"full_scale_db", "Full scale", "Largest real or imaginary part that is not clipped",
            "dB re 1 µPa"},
           adc.full_scale_db, kLevelDb, kRequired);
  given = adc;
  f.end();
}

}  // namespace

bool shading_fields(Fields& f, const KeyText& key, BeamShading& shading, Rule rule) {
  if (!f.begin_kind(key, shading.kind, Shading::chebyshev, kShadingTexts, rule)) return false;
  if (shading.kind == Shading::taylor) taylor_fields(f, shading);
  if (shading.kind == Shading::chebyshev) {
    f.number(
        {"side_lobe_db", "Side-lobe level", "Level of all side lobes relative to the main lobe"},
        shading.side_lobe_db, kSideLobe);
  }
  f.end();
  return true;
}

void beam_fields(Fields& f, SonarSpec& sonar, Need need) {
  const Rule needed{.need = need, .unless = "preset"};
  const bool counted =
      f.integer({"count", "Number of beams", "Beams of the fan; beam 0 is to starboard"},
                sonar.beam_count, 1, kMaxBeams, needed);
  fan_fields(f, sonar, need, counted);
  width_fields(f, sonar, need, counted);
  shading_fields(f, {"shading", "Shading", "Weights of the receive array; the -3 dB width is kept"},
                 sonar.shading);
  f.number({"transmit_width_deg", "Transmit beam width",
            "-3 dB width of the transmit pattern in azimuth, centered on the boresight; left out: "
            "uniform over the fan"},
           sonar.transmit_width_deg, kAngle);
}

std::string dead_trouble(const std::vector<int>& dead, int elements) {
  std::vector<int> sorted = dead;
  std::sort(sorted.begin(), sorted.end());
  const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
  if (twice != sorted.end()) {
    return fmt::format("element {} is listed twice; expected each element once", *twice);
  }
  if (!sorted.empty() && sorted.back() >= elements) {
    return fmt::format("there is no element {}; expected 0 to {} with {} elements", sorted.back(),
                       elements - 1, elements);
  }
  if (std::cmp_less(sorted.size(), elements)) return "";
  return fmt::format("all {} elements are dead; expected fewer", elements);
}

void receiver_fields(Fields& f, SonarSpec& sonar) {
  bool is_array = sonar.array.has_value();
  const bool read = f.choice<bool>(
      {"mode", "Mode",
       "beams: ideal beam cells combined by the beam pattern; array: a line of elements, each with "
       "its own path to every scatterer"},
      is_array, {{"beams", false}, {"array", true}}, written_if(is_array));
  const bool useless = !is_array && (f.writing() || read || f.peek("mode") == nullptr);
  ArraySpec array = sonar.array.value_or(ArraySpec{});
  array_fields(f, array,
               useless_if(useless, "with mode: beams (the default); expected mode: array"));
  if (is_array) sonar.array = std::move(array);
  adc_fields(f, sonar.adc);
}

void check_array(Faults& faults, const Value& root, const Scenario& scenario) {
  const auto at = [&](const char* section, const char* key) {
    const auto map = child(root, section);
    return map ? child(*map, key) : std::nullopt;
  };
  const bool is_array = scenario.sonar.array.has_value();
  if (is_array && scenario.scattering.normalization == Normalization::mean_square) {
    const Value value = *at("scattering", "normalization");
    add_fault(faults, value.place, value.path,
              "mean_square scales beams that are mixed from beam cells, which an array does not "
              "have; expected calibrated with sonar.receiver.mode: array");
  }
  if (is_array && !scenario.sonar.receive_widths_deg.empty()) {
    const auto sonar = *child(root, "sonar");
    const auto beams = child(sonar, "beams");
    const auto widths = beams ? child(*beams, "receive_widths_deg") : std::nullopt;
    const Value& value = widths ? *widths : sonar;
    add_fault(faults, value.place, value.path,
              "the elements of an array give all its beams one width; expected receive_width_deg "
              "with sonar.receiver.mode: array");
  }
  if (is_array || !scenario.output.selection.channels) return;
  const Value value = *at("output", "channels");
  add_fault(faults, value.place, value.path,
            "there are no elements; expected only with sonar.receiver.mode: array");
}

}  // namespace ensonify
