#include <cmath>

#include <fmt/format.h>

#include "core/units.h"
#include "scenario/parse.h"

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

void parse_taylor(Faults& faults, const Value& options, BeamShading& shading) {
  if (!open_map(faults, options, {"side_lobe_db", "nbar"})) return;
  read_number(faults, options, "side_lobe_db", kSideLobe, shading.side_lobe_db);
  const int smallest = smallest_nbar(shading.side_lobe_db);
  if (shading.nbar < smallest) shading.nbar = smallest;
  if (!read_integer(faults, options, "nbar", 2, kMaxNbar, shading.nbar)) return;
  if (shading.nbar >= smallest) return;
  const Value nbar = *child(options, "nbar");
  add_fault(faults, nbar.place, nbar.path,
            fmt::format("nbar {} is too small for side lobes of {} dB, which would grow outwards; "
                        "accepted is {} or more",
                        shading.nbar, shading.side_lobe_db, smallest));
}

void parse_fan(Faults& faults, const Value& beams, Need need, bool counted, SonarSpec& sonar) {
  const bool either = child(beams, "spacing_deg") || child(beams, "fov_deg");
  if (!either) {
    if (need == Need::optional) return;
    add_fault(faults, beams.place, path_of(beams, "fov_deg"),
              fmt::format("missing, accepted is {}, or spacing_deg, which is that divided by count",
                          in_words(kAngle, "number")));
    return;
  }
  const auto key = only_key_of(faults, beams, {"spacing_deg", "fov_deg"},
                               "either alone: spacing_deg, or fov_deg, which is that times count");
  if (!key) return;
  double angle = 0;
  if (!read_number(faults, beams, *key, kAngle, angle)) return;
  if (*key == "fov_deg") {
    sonar.beam_fov_deg = angle;
    return;
  }
  const double fov = angle * sonar.beam_count;
  if (counted && fov > kAngle.high) {
    add_fault(faults, child(beams, "spacing_deg")->place, path_of(beams, "spacing_deg"),
              fmt::format("{} beams of {} degrees span {} degrees, at most 180 are accepted",
                          sonar.beam_count, angle, fov));
    return;
  }
  sonar.beam_fov_deg = fov;
}

}  // namespace

void parse_shading(Faults& faults, const Value& map, BeamShading& shading) {
  const auto kind = read_kind(faults, map, "shading", {"uniform", "hann", "taylor", "chebyshev"});
  if (!kind) return;
  if (kind->word == "taylor") {
    shading.kind = Shading::taylor;
    parse_taylor(faults, kind->options, shading);
  } else if (kind->word == "chebyshev") {
    shading.kind = Shading::chebyshev;
    if (!open_map(faults, kind->options, {"side_lobe_db"})) return;
    read_number(faults, kind->options, "side_lobe_db", kSideLobe, shading.side_lobe_db);
  } else {
    shading.kind = kind->word == "hann" ? Shading::hann : Shading::uniform;
    open_map(faults, kind->options, {});
  }
}

void parse_beams(Faults& faults, const Value& beams, Need need, SonarSpec& sonar) {
  if (!open_map(
          faults, beams,
          {"count", "spacing_deg", "fov_deg", "width_deg", "shading", "transmit_width_deg"})) {
    return;
  }
  const bool counted = read_integer(faults, beams, "count", 1, kMaxBeams, sonar.beam_count, need);
  read_number(faults, beams, "width_deg", kAngle, sonar.beam_width_deg, need);
  parse_fan(faults, beams, need, counted, sonar);
  parse_shading(faults, beams, sonar.shading);
  double transmit_width_deg = 0;
  if (read_number(faults, beams, "transmit_width_deg", kAngle, transmit_width_deg)) {
    sonar.transmit_width_deg = transmit_width_deg;
  }
}

}  // namespace ensonify
