#include "dataset/statistics.h"

#include <fmt/format.h>
#include <unistd.h>

#include <bit>
#include <cmath>
#include <complex>
#include <cstring>
#include <fstream>
#include <limits>

#include "core/counted.h"
#include "dataset/layout.h"
#include "formats/npy.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// A pixel's value, of moments at beam and sample.
struct Pixel {
  const Moments& moments;
  const PooledPixels& pool;
  int beam = 0, sample = 0;

  double at(MomentRow moment) const { return moments.of(moment, beam)[sample]; }
  std::complex<double> at(MomentRow re, MomentRow im) const { return {at(re), at(im)}; }
  double degrees() const { return static_cast<double>(moments.count) - 1; }
  Ratios all() const {
    return ratios(at(MomentRow::mean_power), at(MomentRow::power_spread), at(MomentRow::power_skew),
                  moments.count);
  }
};

double variance(double spread, const Pixel& p) {
  return p.moments.count > 1 ? spread / p.degrees() : kNone;
}

std::complex<double> covariance(std::complex<double> sum, const Pixel& p) {
  return {variance(sum.real(), p), variance(sum.imag(), p)};
}

std::complex<double> coherence(std::complex<double> sum, const Pixel& p, const Pixel& next) {
  const double spread = std::sqrt(p.at(MomentRow::spread)) * std::sqrt(next.at(MomentRow::spread));
  if (!(spread > 0)) return {kNone, kNone};
  return {sum.real() / spread, sum.imag() / spread};
}

Pixel next_bin(const Pixel& p) { return {p.moments, p.pool, p.beam, p.sample + 1}; }
Pixel next_beam(const Pixel& p) { return {p.moments, p.pool, p.beam + 1, p.sample}; }

double expected_of(const Pixel& p) {
  return p.pool.expected_pa2[static_cast<std::size_t>(p.beam) * p.moments.samples + p.sample];
}

// Pairs of pooled pixels that are some samples and beams apart.
double pairs_of(const Pixel& p, int samples, int beams) {
  const auto size = static_cast<std::size_t>(p.moments.samples);
  if (p.beam + beams >= p.moments.beams || samples >= p.moments.samples) return 0;
  const double* const here = &p.pool.weight[static_cast<std::size_t>(p.beam) * size];
  const double* const other = here + static_cast<std::size_t>(beams) * size + samples;
  double pairs = 0;
  for (int n = 0; n + samples < p.moments.samples; ++n) pairs += here[n] > 0 && other[n] > 0;
  return pairs;
}

// A sum over pairs of pixels and realizations as a mean; the lag is the pixel's `sample`.
double mean_over_pairs(PooledRow row, const Pixel& p) {
  const bool is_range = row <= PooledRow::bins_power;
  const double pairs = is_range ? pairs_of(p, p.sample, 0) : pairs_of(p, 0, p.sample);
  if (pairs == 0) return kNone;
  return p.moments.of(row, p.beam)[p.sample] / (pairs * static_cast<double>(p.moments.count));
}

// The arrays over pooled pixels: `sample` of their pixels is a row.
template <class Use>
void for_each_pooled_array(Use use) {
  using enum StatisticsRows;
  use(StatisticsArray{"statistics/intensity_histogram.npy", kNpyFloat64, "1",
                      "pooled pixels of all realizations by I divided by its expectation", 0, 0,
                      bins},
      [](const Pixel& p) { return p.moments.of(PooledRow::histogram, p.beam)[p.sample]; });
  use(StatisticsArray{"statistics/bin_lag_products.npy", kNpyComplex128, "1",
                      "mean of u' u*, u = p divided by the root of the expected intensity, over "
                      "pairs of pooled pixels; u' as many samples later as the row",
                      0, 0, lags},
      [](const Pixel& p) {
        return std::complex(mean_over_pairs(PooledRow::bins_re, p),
                            mean_over_pairs(PooledRow::bins_im, p));
      });
  use(StatisticsArray{"statistics/bin_lag_intensities.npy", kNpyFloat64, "1",
                      "the same of |u'|^2 |u|^2", 0, 0, lags},
      [](const Pixel& p) { return mean_over_pairs(PooledRow::bins_power, p); });
  use(StatisticsArray{"statistics/beam_lag_products.npy", kNpyComplex128, "1",
                      "mean of u' u*, u' as many beams on as the row", 0, 0, lags},
      [](const Pixel& p) {
        return std::complex(mean_over_pairs(PooledRow::beams_re, p),
                            mean_over_pairs(PooledRow::beams_im, p));
      });
  use(StatisticsArray{"statistics/beam_lag_intensities.npy", kNpyFloat64, "1",
                      "the same of |u'|^2 |u|^2", 0, 0, lags},
      [](const Pixel& p) { return mean_over_pairs(PooledRow::beams_power, p); });
}

// Calls use(array, value of a pixel) for every array, in order.
template <class Use>
void for_each_array(Use use) {
  use(StatisticsArray{"statistics/mean_pressure.npy", kNpyComplex128, "Pa", "mean of p"},
      [](const Pixel& p) { return p.at(MomentRow::mean_re, MomentRow::mean_im); });
  use(StatisticsArray{"statistics/pressure_variance.npy", kNpyFloat64, "Pa^2",
                      "variance of p, <|p - <p>|^2>, unbiased"},
      [](const Pixel& p) { return variance(p.at(MomentRow::spread), p); });
  use(StatisticsArray{"statistics/mean_intensity.npy", kNpyFloat64, "Pa^2", "mean of I = |p|^2"},
      [](const Pixel& p) { return p.at(MomentRow::mean_power); });
  use(StatisticsArray{"statistics/intensity_variance.npy", kNpyFloat64, "Pa^4",
                      "variance of I, unbiased"},
      [](const Pixel& p) { return p.all().power_variance; });
  use(StatisticsArray{"statistics/contrast.npy", kNpyFloat64, "1",
                      "standard deviation of I divided by its mean; NaN without energy"},
      [](const Pixel& p) { return p.all().contrast; });
  use(StatisticsArray{"statistics/fourth_moment.npy", kNpyFloat64, "1",
                      "<|p|^4> / <|p|^2>^2; NaN without energy"},
      [](const Pixel& p) { return p.all().fourth_moment; });
  use(StatisticsArray{"statistics/bin_covariance.npy", kNpyComplex128, "Pa^2",
                      "covariance of the next sample and this one, <p' p*> - <p'><p>*, unbiased", 1,
                      0},
      [](const Pixel& p) { return covariance(p.at(MomentRow::bins_re, MomentRow::bins_im), p); });
  use(StatisticsArray{"statistics/bin_coherence.npy", kNpyComplex128, "1",
                      "the same divided by the root of both variances; NaN where one is 0", 1, 0},
      [](const Pixel& p) {
        return coherence(p.at(MomentRow::bins_re, MomentRow::bins_im), p, next_bin(p));
      });
  use(StatisticsArray{"statistics/beam_covariance.npy", kNpyComplex128, "Pa^2",
                      "covariance of the next beam and this one, <p' p*> - <p'><p>*, unbiased", 0,
                      1},
      [](const Pixel& p) { return covariance(p.at(MomentRow::beams_re, MomentRow::beams_im), p); });
  use(StatisticsArray{"statistics/beam_coherence.npy", kNpyComplex128, "1",
                      "the same divided by the root of both variances; NaN where one is 0", 0, 1},
      [](const Pixel& p) {
        return coherence(p.at(MomentRow::beams_re, MomentRow::beams_im), p, next_beam(p));
      });
  use(StatisticsArray{"statistics/third_moment.npy", kNpyFloat64, "1",
                      "<I^3> / <I>^3; NaN without energy"},
      [](const Pixel& p) { return p.all().third_moment; });
  use(StatisticsArray{"statistics/expected_intensity.npy", kNpyFloat64, "Pa^2",
                      "expected I of the scene, computed without realizations, with noise"},
      [](const Pixel& p) { return expected_of(p); });
  for_each_pooled_array(use);
}

bool is_there(const StatisticsArray& array, const OutputSelection& output) {
  return array.rows != StatisticsRows::lags || output.statistics_lags > 0;
}

int rows_of(const StatisticsArray& array, int samples, int lags) {
  if (array.rows == StatisticsRows::bins) return kHistogramBins;
  return array.rows == StatisticsRows::lags ? lags + 1 : samples - array.fewer_rows;
}

NpyShape shape_of(const StatisticsArray& array, int beams, int samples, int lags) {
  return {static_cast<std::uint64_t>(rows_of(array, samples, lags)),
          static_cast<std::uint64_t>(beams - array.fewer_columns)};
}

template <class Value>
std::string encode(const StatisticsArray& array, const Moments& moments, const PooledPixels& pool,
                   Value value) {
  const int rows = rows_of(array, moments.samples, moments.lags);
  const int columns = moments.beams - array.fewer_columns;
  using Type = decltype(value(Pixel{moments, pool}));
  std::string bytes =
      npy_header(array.descr, shape_of(array, moments.beams, moments.samples, moments.lags));
  const std::size_t header = bytes.size();
  bytes.resize(header +
               sizeof(Type) * static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns));
  char* out = bytes.data() + header;
  for (int row = 0; row < rows; ++row) {
    for (int beam = 0; beam < columns; ++beam, out += sizeof(Type)) {
      const Type number = value(Pixel{moments, pool, beam, row});
      std::memcpy(out, &number, sizeof number);
    }
  }
  return bytes;
}

std::string checkpoint_path(std::uint32_t sequence) {
  return fmt::format("{}/sequences/{:06}/{}", layout::kWorkFolder, sequence, layout::kMoments);
}

// Distinguishes checkpoints of other sequences or block sizes.
std::string checkpoint_head(const SequenceInfo& info, std::uint64_t count) {
  return fmt::format(
      "ensonify moments 2 block {} first {} beams {} samples {} lags {} count {:020}\n",
      kMomentBlock, info.first_ping, info.sonar.beam_count, info.record.samples,
      info.output.statistics_lags, count);
}

constexpr std::uint64_t kCheckStart = 0xcbf29ce484222325;

// Checksum of a sequence of words: changes if any word changes or moves.
std::uint64_t check_of(std::span<const double> values, std::uint64_t check) {
  for (const double value : values) {
    check = std::rotl(check ^ std::bit_cast<std::uint64_t>(value), 23) * 0x9E3779B97F4A7C15;
  }
  return check;
}

std::string_view bytes_of(std::span<const double> values) {
  return {reinterpret_cast<const char*>(values.data()), values.size_bytes()};
}

}  // namespace

std::vector<StatisticsArray> statistics_arrays() {
  std::vector<StatisticsArray> arrays;
  for_each_array([&](const StatisticsArray& array, auto) { arrays.push_back(array); });
  return arrays;
}

Json statistics_json(const SequenceInfo& info) {
  const std::uint64_t count = info.last_ping - info.first_ping;
  const auto n = static_cast<double>(count);
  Json arrays = Json::object();
  for (const StatisticsArray& array : statistics_arrays()) {
    if (!is_there(array, info.output)) continue;
    arrays[array.name] = {
        {"dtype", std::string_view(array.descr).substr(1, std::strlen(array.descr) - 2)},
        {"shape",
         shape_of(array, info.sonar.beam_count, info.record.samples, info.output.statistics_lags)},
        {"unit", array.unit},
        {"what", array.what}};
  }
  Json json = {{"realisations", count}};
  Json errors = {{"of", "one pixel of fully developed speckle; the first two relative to the mean"},
                 {"mean_intensity", 1 / std::sqrt(n)},
                 {"intensity_variance", std::sqrt(8 / n)},
                 {"contrast", 1 / std::sqrt(n)},
                 {"fourth_moment", 2 / std::sqrt(n)},
                 {"coherence", "(1 - |coherence|^2) / sqrt(2 realisations)"}};
  // Earlier versions have none of these.
  if (!info.scene_sha256.empty()) {
    json["scene_sha256"] = info.scene_sha256;
    json["scenario_sha256"] = info.scenario_sha256;
    json["lags"] = info.output.statistics_lags;
    json["within_db"] = info.output.statistics_within_db;
    json["histogram_step"] = kHistogramStep;
    errors["third_moment"] = std::sqrt(360 / n);
  }
  json["axes"] = "rows: samples, nearest first; columns: beams, 0 first";
  json["standard_error"] = std::move(errors);
  json["arrays"] = std::move(arrays);
  return json;
}

Moments no_moments(const SequenceInfo& info) {
  return Moments(info.sonar.beam_count, info.record.samples, info.output.statistics_lags);
}

Result<std::vector<FileEntry>> write_statistics(const fs::path& dir, const SequenceInfo& info,
                                                const Moments& moments, const PooledPixels& pool) {
  if (moments.count != info.last_ping - info.first_ping) {
    return Error{
        ErrorKind::bug,
        fmt::format("sequence {}: statistics of {}, not {}; please report this", info.sequence,
                    counted(moments.count, "ping"), info.last_ping - info.first_ping)};
  }
  std::vector<FileEntry> entries;
  Status written;
  for_each_array([&](const StatisticsArray& array, auto value) {
    if (!written || !is_there(array, info.output)) return;
    auto entry = write_file_atomically(dir, layout::in_sequence(info.sequence, array.name),
                                       encode(array, moments, pool, value));
    if (entry) {
      entries.push_back(std::move(*entry));
    } else {
      written = entry.error();
    }
  });
  if (!written) return written.error();
  return entries;
}

MomentsFile::MomentsFile(const fs::path& dir, const SequenceInfo& info, std::uint64_t count)
    : file_(dir, checkpoint_path(info.sequence), false), check_(kCheckStart ^ count) {
  file_.append(checkpoint_head(info, count));
}

void MomentsFile::append(const Moments& moments, int first, int last) {
  const auto values = std::span(moments.values)
                          .subspan(static_cast<std::size_t>(first) * moments.row_values(),
                                   static_cast<std::size_t>(last - first) * moments.row_values());
  check_ = check_of(values, check_);
  file_.append(bytes_of(values));
}

Status MomentsFile::commit() {
  file_.append({reinterpret_cast<const char*>(&check_), sizeof check_});
  const auto committed = file_.commit();
  return committed ? Status() : Status(committed.error());
}

std::optional<Moments> load_moments(const fs::path& dir, const SequenceInfo& info) {
  const std::string path = checkpoint_path(info.sequence);
  const auto size = listed_file_size(dir, path);
  if (!size) return std::nullopt;
  Moments moments = no_moments(info);
  std::string head = checkpoint_head(info, 0);
  const std::size_t bytes = moments.values.size() * sizeof(double);
  if (*size != head.size() + bytes + sizeof(std::uint64_t)) return std::nullopt;
  std::ifstream file(dir / path, std::ios::binary);
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  const std::size_t digits = head.size() - 21;
  for (const char c : head.substr(digits, 20)) {
    if (c < '0' || c > '9') return std::nullopt;
    moments.count = 10 * moments.count + static_cast<std::uint64_t>(c - '0');
  }
  if (head != checkpoint_head(info, moments.count)) return std::nullopt;
  std::uint64_t check = 0;
  file.read(reinterpret_cast<char*>(moments.values.data()), static_cast<std::streamsize>(bytes));
  file.read(reinterpret_cast<char*>(&check), sizeof check);
  const std::uint64_t pings = info.last_ping - info.first_ping;
  const bool whole_blocks = moments.count == pings || moments.count % kMomentBlock == 0;
  if (!file || moments.count > pings || !whole_blocks ||
      check != check_of(moments.values, kCheckStart ^ moments.count)) {
    return std::nullopt;
  }
  return moments;
}

std::uint64_t realizations_in(const fs::path& checkpoint) {
  std::ifstream file(checkpoint, std::ios::binary);
  std::uint64_t count = 0;
  for (std::string word; word != "count" && file.tellg() < 200 && file >> word;) {
  }
  return file >> count ? count : 0;
}

void remove_moments(const fs::path& dir, std::uint32_t sequence) {
  ::unlink((dir / checkpoint_path(sequence)).c_str());
}

}  // namespace ensonify
