// The tables of measurements that a scenario names: CSV with a line of column names; lines that
// start with # are comments.
//
//   load_pulse_table         frequency_hz, amplitude, phase_deg
//   load_backscatter_table   grazing_deg, strength_db
//   load_sound_profile       depth_m, sound_speed_m_s
#pragma once

#include <filesystem>
#include <vector>

#include "core/error.h"
#include "core/sonar.h"
#include "core/surface.h"

namespace ensonify {

// Errors (usage), as `file:line: what is wrong; expected what would be right`, all lines together:
// columns that are missing, unknown or given twice; fields that are missing, superfluous, or not
// finite numbers; frequencies that do not increase; amplitudes that are negative or all zero; fewer
// than two rows; no row in the sonar's band; phase steps of half a turn or more, which are
// ambiguous. Errors (io): the file cannot be read.
Result<std::vector<PulseTableRow>> load_pulse_table(const std::filesystem::path& file,
                                                    const Sonar& sonar);

// The same; grazing angles increase strictly from 0 to 90 degrees, both included, in steps of at
// most 10 degrees (gaps are not filled with invented values); strengths are from -200 to 100 dB.
Result<BackscatterTable> load_backscatter_table(const std::filesystem::path& file);

// The same; depths increase strictly, with at least one row. The surface is at z = 0.
Result<SoundProfile> load_sound_profile(const std::filesystem::path& file);

// Valid depths and sound speeds, in files and in scenarios.
inline constexpr double kMinDepthM = -12000, kMaxDepthM = 12000;
inline constexpr double kMinSoundSpeed = 100, kMaxSoundSpeed = 10000;

}  // namespace ensonify
