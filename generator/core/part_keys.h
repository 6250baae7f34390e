// The keys of a recorder and of a thin wall, which scenarios and sequence.json share (core/keys.h).
//
//   count_keys  gamma_key  row_gain_key  tvg_keys   of a Recorder; files have no map `tvg`
//   wall_keys                                       of a Wall, without what is behind it
#pragma once

#include "core/electronics.h"
#include "core/surface.h"

namespace ensonify {

template <class Io, class Values>
void count_keys(Io& io, Values& recorder) {
  io.integer({"bits", "Bits", "Bits of a count, which is between 0 and 2^bits - 1; 8 or 16"},
             recorder.bits, 8, 16);
  io.template choice<GreyScale>(
      {"scale", "Scale",
       "db: counts are linear in dB between the limits; amplitude: they are proportional to a "
       "power of the amplitude"},
      recorder.scale, {{"db", GreyScale::db}, {"amplitude", GreyScale::amplitude}});
  io.numbers({"db", "Limits",
              "[low, high]: levels with gain of count 0 and of the largest count; low has no "
              "effect with scale amplitude",
              kPressure},
             recorder.db, kLevelDb, kRequired);
}

template <class Io, class Values>
void gamma_key(Io& io, Values& recorder, Rule rule = {}) {
  io.number({"gamma", "Gamma", "Power of the amplitude that counts are proportional to"},
            recorder.gamma, above_up_to(0, 20), rule);
}

template <class Io, class Values>
void row_gain_key(Io& io, Values& recorder, Rule rule = {}) {
  io.number({"row_gain_db", "Row gain",
             "Largest gain that brings the strongest echo of a sample, over all beams, to the "
             "largest count; it is stored; 0: none"},
            recorder.row_gain_db, kGainDb, rule);
}

template <class Io, class Values>
void tvg_keys(Io& io, Values& recorder) {
  io.number({"spreading", "Spreading", "Gain for each tenfold of range", "dB per tenfold of range"},
            recorder.spreading, from_to(0, 100));
  io.boolean({"absorption", "Absorption",
              "Whether the gain compensates the two-way absorption of the water"},
             recorder.absorption);
  io.number({"step_db", "Step", "Step to which the gain is rounded; 0: not rounded"},
            recorder.step_db, kGainDb);
}

template <class Io, class Values>
void wall_keys(Io& io, Values& wall) {
  io.number({"thickness_m", "Thickness", "Thickness of the wall"}, wall.thickness_m,
            from_to(1e-5, 0.05), kRequired);
  io.number({"density_kg_m3", "Density", "Density of the wall"}, wall.density_kg_m3,
            from_to(1, 30000), kRequired);
  io.number({"speed_m_s", "Compressional speed", "Speed of compressional waves in the wall"},
            wall.speed_m_s, from_to(100, 20000), kRequired);
  io.number({"shear_speed_m_s", "Shear speed",
             "Speed of shear waves in the wall; 0: a fluid, which soft rubber nearly is"},
            wall.shear_speed_m_s, from_to(0, 20000));
  io.number(
      {"loss", "Loss factor", "Imaginary part of the elastic moduli divided by the real part", "1"},
      wall.loss, from_to(0, 1));
}

}  // namespace ensonify
