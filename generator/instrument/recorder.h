// From the levels of a polar image to the counts that an instrument stores.
//
//   record_ping     counts and row gains
//   recorded_level_db  recorded_amplitude   what a count stands for
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/electronics.h"
#include "core/ping.h"

namespace ensonify {

// `level_db` [rows x columns], kNoEnergyDb where there is none; row n is at range n range_step_m,
// and row 0 has the gain of row 1. The formulas are those of Recorder; absorption_db_m is alpha.
RecordedPing record_ping(const Recorder& recorder, std::span<const float> level_db,
                         std::size_t columns, double range_step_m, double absorption_db_m);

// The inverse up to rounding, with the time-varied gain left in: lo + count (hi - lo)/m, or
// hi + 20/gamma log10(count/m) - 10 log10(row_gain); kNoEnergyDb for a count of 0 without lo,
// and for a row gain of 0, which logs can have.
double recorded_level_db(const Recorder& recorder, double count, double row_gain);

// The same as an amplitude relative to that of hi; 0 for a count of 0 without lo, or a gain of 0.
float recorded_amplitude(const Recorder& recorder, double count, double row_gain);

}  // namespace ensonify
