#include "compare/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "compare/pings.h"
#include "compare/sum_measures.h"
#include "core/units.h"

namespace ensonify {
namespace {

using Measured = BlockStatistics;

constexpr double kQuantiles[] = {0.02, 0.05, 0.1, 0.2, 0.3,  0.4, 0.5,
                                 0.6,  0.7,  0.8, 0.9, 0.95, 0.98};
constexpr double kFloorQuantile = 0.1;
constexpr double kLeastPlain = 10;

// --- the list ---

Values level_by_range(const Measured&, const Sums& s) {
  return ratios(s.range_level, s.range_count, kLeastPixels);
}
Values level_by_azimuth(const Measured&, const Sums& s) {
  return ratios(s.azimuth_level, s.azimuth_count, kLeastPixels);
}
Values level_by_grazing(const Measured&, const Sums& s) {
  return ratios(s.grazing_level, s.grazing_count, kLeastPixels);
}
Values range_width(const Measured& m, const Sums& s) {
  return {cut_width(s.range_cut, s.maxima) * m.range_step * 1000};
}
Values azimuth_width(const Measured& m, const Sums& s) {
  return {degrees(cut_width(s.azimuth_cut, s.maxima) * m.azimuth_step)};
}
Values range_side_lobe(const Measured& m, const Sums& s) {
  return {side_lobe(s.range_cut, s.maxima, m.all.range_cut, m.all.maxima)};
}
Values azimuth_side_lobe(const Measured& m, const Sums& s) {
  return {side_lobe(s.azimuth_cut, s.maxima, m.all.azimuth_cut, m.all.maxima)};
}
Values range_cut(const Measured&, const Sums& s) { return cut_levels(s.range_cut, s.maxima); }
Values azimuth_cut(const Measured&, const Sums& s) { return cut_levels(s.azimuth_cut, s.maxima); }
Values shape(const Measured& m, const Sums& s) {
  return {inverse_shape(effective_pixels(m, s), s.x0, s.x1, s.x2)};
}
Values shape_by_range(const Measured& m, const Sums& s) {
  Values values;
  for (std::size_t i = 0; i < s.range_x0.size(); ++i) {
    values.push_back(
        inverse_shape(effective_pixels(m, s), s.range_x0[i], s.range_x1[i], s.range_x2[i]));
  }
  return values;
}
Values level_spread(const Measured&, const Sums& s) { return {log_moments(s).spread}; }
Values level_skewness(const Measured&, const Sums& s) { return {log_moments(s).skewness}; }
Values range_correlation(const Measured& m, const Sums& s) {
  return at_steps(correlations(s.range_products, s.range_pairs),
                  m.settings.range_lag / m.range_step);
}
Values azimuth_correlation(const Measured& m, const Sums& s) {
  return at_steps(correlations(s.azimuth_products, s.azimuth_pairs),
                  m.settings.azimuth_lag / m.azimuth_step);
}
Values range_length(const Measured& m, const Sums& s) {
  const double scale = m.settings.crops ? 1 : m.range_step * 1000;
  return {half_lag(correlations(s.range_products, s.range_pairs)) * scale};
}
Values azimuth_length(const Measured& m, const Sums& s) {
  const double lag = half_lag(correlations(s.azimuth_products, s.azimuth_pairs));
  return {m.settings.crops ? lag : degrees(lag * m.azimuth_step)};
}
Values ping_correlation(const Measured&, const Sums& s) {
  Values values = correlations(s.ping_products, s.ping_pairs);
  if (!values.empty()) values.erase(values.begin());
  return values;
}
Values dark_share(const Measured&, const Sums& s) {
  return {100 * ratio(s.dark, s.dark_of, kLeastPixels)};
}
Values dark_level(const Measured&, const Sums& s) {
  return {ratio(s.dark_level, s.dark, kLeastPixels)};
}
Values edge(const Measured& m, const Sums& s) { return {edge_width(s) * m.range_step * 1000}; }
Values distinct_levels(const Measured&, const Sums& s) {
  return {std::log2(std::max(1.0, ratio(s.distinct, s.images)))};
}
Values top_share(const Measured&, const Sums& s) { return {100 * ratio(s.top, s.pixels)}; }
Values empty_share(const Measured&, const Sums& s) { return {100 * ratio(s.empty, s.pixels)}; }
Values quantiles(const Measured&, const Sums& s) {
  Values values;
  for (const double q : kQuantiles) values.push_back(level_quantile(s.levels, 0, q));
  return values;
}
Values beam_gains(const Measured&, const Sums& s) {
  return {gain_variance(s.beam_level, s.beam_count)};
}
Values row_gains(const Measured&, const Sums& s) {
  return {gain_variance(s.row_level, s.row_count)};
}
Values streak(const Measured&, const Sums& s) {
  return {s.maxima < kLeastMaxima ? kNone : decibels(s.behind / s.before)};
}
Values cross_talk(const Measured&, const Sums& s) {
  return {s.maxima < kLeastMaxima ? kNone : decibels(s.beside / s.maxima)};
}
Values noise_floor(const Measured&, const Sums& s) {
  return {level_quantile(s.far_levels, s.far_empty, kFloorQuantile) - mean_level(s)};
}

Values plain_median(const Sums::Row& table, const PlainAxis& axis) {
  double patches = 0;
  for (const double n : table) patches += n;
  if (patches < kLeastPlain) return {kNone};
  return {level_quantile(table, 0, 0.5, axis.from, axis.step())};
}
Values plain_spread(const Measured&, const Sums& s) {
  return plain_median(s.plain_spread, kSpreadAxis);
}
Values plain_skewness(const Measured&, const Sums& s) {
  return plain_median(s.plain_skewness, kSkewnessAxis);
}
Values plain_beams(const Measured&, const Sums& s) {
  return plain_median(s.plain_beams, kCorrelationAxis);
}
Values plain_samples(const Measured&, const Sums& s) {
  return plain_median(s.plain_samples, kCorrelationAxis);
}
Values comb_share(const Measured&, const Sums& s) {
  return {100 * ratio(s.comb_hits, s.comb_images)};
}
Values comb_level(const Measured& m, const Sums& s) {
  return {comb_ripple(s, m.settings.comb_period)};
}
Values grays(const Measured&, const Sums& s) {
  return gray_shares(s.levels, s.empty, mean_level(s));
}
Values patterns(const Measured&, const Sums& s) {
  double pixels = 0;
  for (const double n : s.patterns) pixels += n;
  Values shares;
  for (const double n : s.patterns) shares.push_back(ratio(n, pixels, kLeastPixels));
  return shares;
}

// --- by classes of pixels ---

std::span<const double> levels_of(const Sums& s, PixelClass which) {
  if (s.class_levels.empty()) return {};
  return std::span(s.class_levels)
      .subspan(static_cast<std::size_t>(which) * kLevelSteps, kLevelSteps);
}
template <PixelClass which>
Values class_share(const Measured&, const Sums& s) {
  double all = 0;
  for (const double n : s.class_levels) all += n;
  return {100 * ratio(level_moments(levels_of(s, which)).pixels, all, kLeastPixels)};
}
template <PixelClass which>
Values class_spread(const Measured&, const Sums& s) {
  const LevelMoments of = level_moments(levels_of(s, which));
  return {of.pixels < kLeastPixels ? kNone : of.spread};
}
template <PixelClass which>
Values class_contrast(const Measured&, const Sums& s) {
  const LevelMoments of = level_moments(levels_of(s, which));
  const LevelMoments rest = level_moments(levels_of(s, PixelClass::background));
  return {std::min(of.pixels, rest.pixels) < kLeastPixels ? kNone : of.mean - rest.mean};
}
// Over the mean level of the background, so that the gain is free and contrasts count.
template <PixelClass which>
Values class_grays(const Measured&, const Sums& s) {
  return gray_shares(levels_of(s, which), 0,
                     level_moments(levels_of(s, PixelClass::background)).mean);
}

Values gray_centers(const Measured&) {
  return bin_centers(kDarkestGray, kDarkestGray + kGrays, kGrays);
}
Values pattern_codes(const Measured&) { return bin_centers(-0.5, kPatterns - 0.5, kPatterns); }

Values range_centers(const Measured& m) {
  return bin_centers(m.settings.range_from, m.settings.range_to, kLevelRangeBins);
}
Values azimuth_centers(const Measured& m) {
  return bin_centers(m.settings.azimuth_from, m.settings.azimuth_to, kLevelAzimuthBins, degrees(1));
}
Values shape_centers(const Measured& m) {
  return bin_centers(m.settings.range_from, m.settings.range_to, kShapeBins);
}
Values grazing_centers(const Measured&) { return bin_centers(0, 90, kGrazingBins); }
Values lags_by(double step) {
  Values lags;
  for (int k = 1; k <= kLags; ++k) lags.push_back(k * step);
  return lags;
}
Values range_lags(const Measured& m) {
  return lags_by(m.settings.crops ? 1 : m.settings.range_lag);
}
Values azimuth_lags(const Measured& m) {
  return lags_by(m.settings.crops ? 1 : degrees(m.settings.azimuth_lag));
}
Values ping_lags(const Measured&) { return {1, 2, 3, 4}; }
Values percents(const Measured&) {
  Values values;
  for (const double q : kQuantiles) values.push_back(100 * q);
  return values;
}
Values offsets(int half, double step) {
  Values values;
  for (int k = -half; k <= half; ++k) values.push_back(k * step);
  return values;
}
Values range_offsets(const Measured& m) { return offsets(m.half_rows, m.range_step); }
Values azimuth_offsets(const Measured& m) {
  return offsets(m.half_columns, degrees(m.azimuth_step));
}

using enum StatisticUse;
constexpr const char* kNoMaxima = "too few bright isolated maxima";
constexpr const char* kNoDark = "too few dark pixels";
constexpr const char* kNoGround = "too few homogeneous pixels";
constexpr const char* kNoPlain = "too few plain patches";
constexpr const char* kNoBeams = "too few beams for the comb";
constexpr const char* kNoClass = "too few pixels of the class";
constexpr const char* kPlain = "plain patches of 32 samples by 24 beams";
constexpr const char* kComb = "comb of beams that fire in groups";
constexpr const char* kGray = "distances of histograms of 8-bit images";
constexpr const char* kClasses = "objects, shadows and background apart";
constexpr const char* kGrayAxis = "level over the mean level, dB";
constexpr const char* kClassAxis = "level over the background's mean level, dB";
constexpr PixelClass kObject = PixelClass::object, kShadow = PixelClass::shadow,
                     kBackground = PixelClass::background;
constexpr Statistic kStatistics[] = {
    {"level", "level_range", "level against range", "dB", pings, true, "too few pixels",
     level_by_range, range_centers, "range, m"},
    {"level", "level_azimuth", "level against azimuth", "dB", pings, true, "too few pixels",
     level_by_azimuth, azimuth_centers, "azimuth, degrees"},
    {"point spread", "range_width", "-3 dB width in range", "mm", pings, false, kNoMaxima,
     range_width},
    {"point spread", "azimuth_width", "-3 dB width in azimuth", "degrees", pings, false, kNoMaxima,
     azimuth_width},
    {"point spread", "range_side_lobe", "side lobes in range", "dB", pings, false, kNoMaxima,
     range_side_lobe},
    {"point spread", "azimuth_side_lobe", "side lobes in azimuth", "dB", pings, false, kNoMaxima,
     azimuth_side_lobe},
    {"point spread", "range_cut", "cut through maxima in range", "dB", pings, false, kNoMaxima,
     range_cut, range_offsets, "offset in range, m"},
    {"point spread", "azimuth_cut", "cut through maxima in azimuth", "dB", pings, false, kNoMaxima,
     azimuth_cut, azimuth_offsets, "offset in azimuth, degrees"},
    {"amplitudes", "inverse_shape", "1 / K shape (0: Rayleigh)", "", all, false, kNoGround, shape},
    {"amplitudes", "shape_range", "1 / K shape against range", "", pings, false, kNoGround,
     shape_by_range, shape_centers, "range, m"},
    {"amplitudes", "level_spread", "standard deviation of the level", "dB", all, false, kNoGround,
     level_spread},
    {"amplitudes", "level_skewness", "skewness of the level", "", all, false, kNoGround,
     level_skewness},
    {"correlation", "range_correlation", "autocovariance in range", "", all, false, kNoGround,
     range_correlation, range_lags, "lag in range, m (crops: pixels)"},
    {"correlation", "azimuth_correlation", "autocovariance in azimuth", "", all, false, kNoGround,
     azimuth_correlation, azimuth_lags, "lag in azimuth, degrees (crops: pixels)"},
    {"correlation", "range_length", "correlation length in range", "mm", all, false, kNoGround,
     range_length},
    {"correlation", "azimuth_length", "correlation length in azimuth", "degrees", all, false,
     kNoGround, azimuth_length},
    {"correlation", "ping_correlation", "correlation from ping to ping", "", pings, false,
     "too few consecutive pings", ping_correlation, ping_lags, "lag, pings"},
    {"darkness", "dark_share", "share of dark pixels", "%", pings, false, kNoGround, dark_share},
    {"darkness", "dark_level", "level of dark pixels", "dB", pings, false, kNoDark, dark_level},
    {"darkness", "edge_width", "width of far edges", "mm", pings, false,
     "too few edges of dark regions", edge},
    {"ground", "level_grazing", "level against grazing angle", "dB", geometry, true,
     "too few pixels of the ground", level_by_grazing, grazing_centers, "grazing angle, degrees"},
    {"instrument", "distinct_levels", "distinct amplitudes in an image", "bits", all, false, "",
     distinct_levels},
    {"instrument", "top_share", "pixels at the highest amplitude", "%", all, false, "", top_share},
    {"instrument", "empty_share", "pixels without an echo", "%", all, false, "", empty_share},
    {"instrument", "quantiles", "quantiles of the level", "dB", all, true, "too few pixels",
     quantiles, percents, "pixels with a lower level, %"},
    {"instrument", "beam_gains", "variance of gains of beams", "dB²", pings, false, kNoGround,
     beam_gains},
    {"instrument", "row_gains", "variance of gains of samples", "dB²", pings, false, kNoGround,
     row_gains},
    {"instrument", "streak", "level behind maxima over that before", "dB", pings, false, kNoMaxima,
     streak},
    {"instrument", "cross_talk", "level beside maxima over background", "dB", pings, false,
     kNoMaxima, cross_talk},
    {"instrument", "noise_floor", "noise floor at far range over the mean level", "dB", pings,
     false, "far pixels have no echo", noise_floor},
    {kPlain, "plain_spread", "standard deviation of the level", "dB", all, false, kNoPlain,
     plain_spread},
    {kPlain, "plain_skewness", "skewness of the level", "", all, false, kNoPlain, plain_skewness},
    {kPlain, "plain_beams", "correlation of neighboring beams", "", all, false, kNoPlain,
     plain_beams},
    {kPlain, "plain_samples", "correlation of neighboring samples", "", all, false, kNoPlain,
     plain_samples},
    {kComb, "comb_share", "pings that show it", "%", pings, false, kNoBeams, comb_share},
    {kComb, "comb_level", "range of the level by beam of a group", "dB", pings, false, kNoBeams,
     comb_level},
    {kGray, "gray_kl", "KL divergence of gray levels", "nats", all, false, "", grays, gray_centers,
     kGrayAxis, Distance::kl},
    {kGray, "gray_js", "JS divergence of gray levels", "nats", all, false, "", grays, gray_centers,
     kGrayAxis, Distance::js},
    {kGray, "gray_emd", "earth mover's distance of gray levels", "dB", all, false, "", grays,
     gray_centers, kGrayAxis, Distance::emd},
    {kGray, "pattern_kl", "KL divergence of local patterns", "nats", all, false, "", patterns,
     pattern_codes, "local binary pattern", Distance::kl},
    {kClasses, "object_share", "pixels of objects", "%", classes, false, kNoClass,
     class_share<kObject>},
    {kClasses, "object_level", "level of objects over the background", "dB", classes, false,
     kNoClass, class_contrast<kObject>},
    {kClasses, "object_spread", "standard deviation, objects", "dB", classes, false, kNoClass,
     class_spread<kObject>},
    {kClasses, "object_emd", "earth mover's distance, objects", "dB", classes, false, kNoClass,
     class_grays<kObject>, gray_centers, kClassAxis, Distance::emd},
    {kClasses, "shadow_share", "pixels of shadows", "%", classes, false, kNoClass,
     class_share<kShadow>},
    {kClasses, "shadow_level", "level of shadows over the background", "dB", classes, false,
     kNoClass, class_contrast<kShadow>},
    {kClasses, "shadow_spread", "standard deviation, shadows", "dB", classes, false, kNoClass,
     class_spread<kShadow>},
    {kClasses, "shadow_emd", "earth mover's distance, shadows", "dB", classes, false, kNoClass,
     class_grays<kShadow>, gray_centers, kClassAxis, Distance::emd},
    {kClasses, "background_spread", "standard deviation, background", "dB", classes, false,
     kNoClass, class_spread<kBackground>},
    {kClasses, "background_emd", "earth mover's distance, background", "dB", classes, false,
     kNoClass, class_grays<kBackground>, gray_centers, kClassAxis, Distance::emd},
};

}  // namespace

double effective_pixels(const BlockStatistics& measured, const Sums& sums) {
  const double all = (2.0 * measured.half_rows + 1) * (2.0 * measured.half_columns + 1);
  const double range =
      cell_of(correlations(sums.range_products, sums.range_pairs), measured.half_rows);
  const double azimuth =
      cell_of(correlations(sums.azimuth_products, sums.azimuth_pairs), measured.half_columns);
  return std::max(2.0, all / (range * azimuth));
}

std::span<const Statistic> statistics() { return kStatistics; }

bool is_smooth(const Statistic& statistic) {
  const std::string_view group = statistic.group;
  return !std::string_view(statistic.id).ends_with("side_lobe") && group != kPlain &&
         group != kComb && group != kGray && group != kClasses;
}

std::vector<Estimate> estimates_of(const BlockStatistics& measured) {
  std::vector<Sums> without;
  for (const Sums& block : measured.blocks) {
    without.push_back(measured.all);
    subtract(without.back(), block);
  }
  std::vector<Estimate> estimates;
  for (const Statistic& statistic : statistics()) {
    std::vector<Values> values;
    for (const Sums& sums : without) values.push_back(statistic.values(measured, sums));
    estimates.push_back(jackknife(statistic.values(measured, measured.all), values));
  }
  return estimates;
}

}  // namespace ensonify
