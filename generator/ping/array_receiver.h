// The receiving array of a session, including the values that its scenario leaves out.
#pragma once

#include <optional>

#include "core/error.h"
#include "core/sonar.h"
#include "scenario/scenario.h"

namespace ensonify {

// Empty with sonar.receiver.mode: beams. If the scenario leaves them out, spacing_m is half a
// wavelength c/f_c, `shading` is that of the beams, and `elements` is the aperture of the beam
// width (make_shaded_line) divided by the spacing, rounded, at least 1. Element errors are keyed by
// the seed alone and equal in all sequences: with xi(n) = complex_normal(stream_key(seed,
// Stream::array, 0), 0, n, 0), each part of variance 1/2, element n has the gain sqrt(2) Re(xi)
// gain_error_db in dB and the phase sqrt(2) Im(xi) phase_error_deg. Errors (usage): too many
// elements, or elements times samples; a dead element that does not exist; no working element.
Result<std::optional<ArrayReceiver>> array_receiver(const Scenario& scenario, const Sonar& sonar,
                                                    const Water& water, const Record& record);

}  // namespace ensonify
