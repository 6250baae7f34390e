// What is made of series on the device before anything comes down.
//
//   ConvertSeries   the receiver's converter
//   FormLevels      [beams][samples] of pressure -> [samples][beams] of level
#pragma once

#include <cstdint>

#include "core/levels.h"
#include "synthesis/adc.h"
#include "synthesis/cuda/records.h"

namespace ensonify {

struct ConvertSeries {
  Converter converter;
  Complex32* series;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    series[i] = {converted(converter, series[i].re), converted(converter, series[i].im)};
  }
};

struct FormLevels {
  const Complex32* series;
  int beams, samples;
  float* level_db;

  ENSONIFY_HD void operator()(std::int64_t i) const {
    const std::int64_t beam = i % beams, sample = i / beams;
    const Complex32 p = series[beam * samples + sample];
    level_db[i] = image_level_db(p.re * p.re + p.im * p.im);
  }
};

}  // namespace ensonify
