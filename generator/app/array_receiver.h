// The receiving array of a session, with what its scenario leaves to be worked out.
#pragma once

#include <optional>

#include "core/error.h"
#include "core/sonar.h"
#include "scenario/scenario.h"

namespace ensonify {

// None with sonar.receiver.mode: beams. Left out: spacing_m is half a wavelength c/f_c, `shading`
// that of the beams, `elements` the aperture of the beam's width (make_shaded_line) over the
// spacing, rounded, at least 1. Errors are drawn by the seed alone, the same for all sequences:
// with xi(n) = complex_normal(stream_key(seed, Stream::array, 0), 0, n, 0), each part of variance
// 1/2, element n has the gain sqrt(2) Re(xi) gain_error_db in dB and the phase sqrt(2) Im(xi)
// phase_error_deg. Errors (usage): too many elements, or elements by samples; what is dead is not
// there, or all is.
Result<std::optional<ArrayReceiver>> array_receiver(const Scenario& scenario, const Sonar& sonar,
                                                    const Water& water, const Record& record);

}  // namespace ensonify
