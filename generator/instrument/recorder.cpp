#include "instrument/recorder.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/units.h"

namespace ensonify {
namespace {

double most_of(const Recorder& recorder) { return std::ldexp(1.0, recorder.bits) - 1; }

double range_gain_db(const Recorder& recorder, double range_m, double absorption_db_m) {
  double gain = recorder.spreading * std::log10(range_m);
  if (recorder.absorption) gain += 2 * absorption_db_m * range_m;
  return recorder.step_db > 0 ? recorder.step_db * std::round(gain / recorder.step_db) : gain;
}

double power_of(float level_db) {
  return level_db == kNoEnergyDb ? 0 : std::pow(10.0, level_db / 10.0);
}

// Adds to `gain_db` [rows] what brings the mean power of each row to the level.
void follow(const RangeGain& range_gain, std::span<const float> level_db, std::size_t columns,
            double range_step_m, std::vector<double>& gain_db) {
  double smooth = 0;
  for (std::size_t row = 0; row < gain_db.size(); ++row) {
    double power = 0;
    for (const float level : level_db.subspan(row * columns, columns)) power += power_of(level);
    power *= std::pow(10.0, gain_db[row] / 10) / static_cast<double>(columns);
    const double length_m = power > smooth ? range_gain.attack_m : range_gain.release_m;
    smooth += (1 - std::exp(-range_step_m / length_m)) * (power - smooth);
    const double wanted =
        smooth > 0 ? range_gain.level_db - 10 * std::log10(smooth) : range_gain.max_gain_db;
    gain_db[row] += std::min(wanted, range_gain.max_gain_db);
  }
}

// The power gain that brings the strongest pixel of the row to full scale.
double row_gain_of(const Recorder& recorder, std::span<const float> row_db, double gain_db) {
  const double peak_db = *std::max_element(row_db.begin(), row_db.end()) + gain_db;
  return std::pow(10.0, std::clamp(recorder.db[1] - peak_db, 0.0, recorder.row_gain_db) / 10);
}

double count_of(const Recorder& recorder, float level_db, double gain_db) {
  if (level_db == kNoEnergyDb) return 0;
  const double s = level_db + gain_db;
  const auto [lo, hi] = recorder.db;
  const double share = recorder.scale == GreyScale::db
                           ? (s - lo) / (hi - lo)
                           : std::pow(10.0, recorder.gamma * (s - hi) / 20);
  return std::round(most_of(recorder) * std::clamp(share, 0.0, 1.0));
}

}  // namespace

RecordedPing record_ping(const Recorder& recorder, std::span<const float> level_db,
                         std::size_t columns, double range_step_m, double absorption_db_m) {
  ENSONIFY_ASSERT(columns > 0 && level_db.size() % columns == 0);
  std::vector<double> gain_db(level_db.size() / columns);
  for (std::size_t row = 0; row < gain_db.size(); ++row) {
    const double range_m = static_cast<double>(std::max<std::size_t>(row, 1)) * range_step_m;
    gain_db[row] = range_gain_db(recorder, range_m, absorption_db_m);
  }
  if (recorder.range_gain) {
    follow(*recorder.range_gain, level_db, columns, range_step_m, gain_db);
  }
  RecordedPing recorded;
  recorded.counts_8.resize(recorder.bits == 8 ? level_db.size() : 0);
  recorded.counts_16.resize(recorder.bits == 8 ? 0 : level_db.size());
  for (std::size_t row = 0; row < gain_db.size(); ++row) {
    const auto row_db = level_db.subspan(row * columns, columns);
    if (recorder.row_gain_db > 0) {
      recorded.row_gain.push_back(static_cast<float>(row_gain_of(recorder, row_db, gain_db[row])));
      gain_db[row] += 10 * std::log10(recorded.row_gain.back());
    }
    for (std::size_t column = 0; column < columns; ++column) {
      const double count = count_of(recorder, row_db[column], gain_db[row]);
      const std::size_t at = row * columns + column;
      if (recorder.bits == 8) {
        recorded.counts_8[at] = static_cast<std::uint8_t>(count);
      } else {
        recorded.counts_16[at] = static_cast<std::uint16_t>(count);
      }
    }
  }
  return recorded;
}

double recorded_level_db(const Recorder& recorder, double count, double row_gain) {
  const double share = count / most_of(recorder);
  const auto [lo, hi] = recorder.db;
  if (recorder.scale == GreyScale::db) return lo + share * (hi - lo);
  if (count <= 0 || !(row_gain > 0)) return kNoEnergyDb;
  return hi + 20 / recorder.gamma * std::log10(share) - 10 * std::log10(row_gain);
}

float recorded_amplitude(const Recorder& recorder, double count, double row_gain) {
  const double level_db = recorded_level_db(recorder, count, row_gain);
  const bool silent = recorder.scale == GreyScale::amplitude && !(count > 0 && row_gain > 0);
  return silent ? 0 : static_cast<float>(std::pow(10.0, (level_db - recorder.db[1]) / 20));
}

}  // namespace ensonify
