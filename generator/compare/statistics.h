// The statistics, each a function of sums. Private to compare/; docs/compare.md lists them.
//
//   Statistic  statistics        name, unit and formula of each
//   is_smooth                    whether a fit can follow it
//   estimate_of                  its value in a data set, by blocks
//
// K shape: for the intensity of a K distribution of shape nu, E I^2 / (E I)^2 = 2 (1 + 1/nu), and 2
// for Rayleigh amplitudes (Jakeman & Pusey 1976). With N effective pixels in the window of the
// normalization, 1/nu = m2 (N + 1) / (2 N) - 1 of the moment m2 of x.
//
// Effective pixels: N = n / (s_range s_azimuth) with s = 1 + 2 sum_l rho(l) (1 - l/w) over the lags
// up to the first with rho < 0.05, for the autocovariance rho and the window's width w, and n
// pixels in the window.
//
// Gains of beams: from mean levels y_j of the ground, sigma^2 = mean (y_j - (y_(j-1) +
// y_(j+1))/2)^2 / 1.5, which a linear trend does not change. Those of samples likewise.
#pragma once

#include <span>
#include <vector>

#include "compare/block_statistics.h"
#include "compare/jackknife.h"

namespace ensonify {

enum class StatisticUse { all, pings, geometry, classes };  // geometry: pings with known heights

struct Statistic {
  const char* group;
  const char* id;
  const char* title;
  const char* unit;
  StatisticUse use = StatisticUse::all;
  bool free_constant = false;  // of a curve
  const char* lacks = "";      // why it may be undefined
  // Values: one, or those of a curve. NaN: not defined.
  std::vector<double> (*values)(const BlockStatistics& measured, const Sums& sums);
  // Of a curve: where its values lie, and the axis' title; null for a single value.
  std::vector<double> (*positions)(const BlockStatistics& measured) = nullptr;
  const char* axis = "";
  // Of a histogram: how two of them are compared.
  Distance distance = Distance::none;
};

// Whether it changes little if a key of a simulation does, so that a search can follow it. Not so:
// side lobes, which are measured beyond 1.5 widths, so that a wider beam loses samples one at a
// time (the cuts hold the same); medians over patches that become plain one at a time; numbers of
// images; and distances, which are of two data sets.
bool is_smooth(const Statistic& statistic);

std::span<const Statistic> statistics();

// Needs 2 blocks or more.
std::vector<Estimate> estimates_of(const BlockStatistics& measured);

double effective_pixels(const BlockStatistics& measured, const Sums& sums);

}  // namespace ensonify
