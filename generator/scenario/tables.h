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

// Errors (usage), as `file:line: what is wrong, what is accepted`, all lines at once: columns
// missing, unknown or given twice; a field that is missing, too many, or no finite number;
// frequencies that do not rise; amplitudes below zero, or all zero; fewer than two rows; no row
// inside the sonar's band; steps of phase of half a turn and more, which leave the way round open.
// Errors (io): cannot be read.
Result<std::vector<PulseTableRow>> load_pulse_table(const std::filesystem::path& file,
                                                    const Sonar& sonar);

// The same; grazing angles rise strictly from 0 to 90 degrees, both given, in steps of at most 10
// degrees (a gap is not filled with invented sea floor); strengths within -200 ... 100 dB.
Result<BackscatterTable> load_backscatter_table(const std::filesystem::path& file);

// The same; depths that rise strictly, one row and more. The surface lies at z = 0.
Result<SoundProfile> load_sound_profile(const std::filesystem::path& file);

// What a depth and a sound speed may be, in files as in scenarios.
inline constexpr double kMinDepthM = -12000, kMaxDepthM = 12000;
inline constexpr double kMinSoundSpeed = 100, kMaxSoundSpeed = 10000;

}  // namespace ensonify
