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
  int beam = 0, sample = 0;

  double at(MomentRow moment) const { return moments.of(moment, beam)[sample]; }
  std::complex<double> at(MomentRow re, MomentRow im) const { return {at(re), at(im)}; }
  double degrees() const { return static_cast<double>(moments.count) - 1; }
  Ratios all() const {
    return ratios(at(MomentRow::mean_power), at(MomentRow::power_spread), moments.count);
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

Pixel next_bin(const Pixel& p) { return {p.moments, p.beam, p.sample + 1}; }
Pixel next_beam(const Pixel& p) { return {p.moments, p.beam + 1, p.sample}; }

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
}

NpyShape shape_of(const StatisticsArray& array, int beams, int samples) {
  return {static_cast<std::uint64_t>(samples - array.fewer_rows),
          static_cast<std::uint64_t>(beams - array.fewer_columns)};
}

template <class Value>
std::string encode(const StatisticsArray& array, const Moments& moments, Value value) {
  const int rows = moments.samples - array.fewer_rows;
  const int columns = moments.beams - array.fewer_columns;
  using Type = decltype(value(Pixel{moments}));
  std::string bytes = npy_header(array.descr, shape_of(array, moments.beams, moments.samples));
  const std::size_t header = bytes.size();
  bytes.resize(header +
               sizeof(Type) * static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns));
  char* out = bytes.data() + header;
  for (int sample = 0; sample < rows; ++sample) {
    for (int beam = 0; beam < columns; ++beam, out += sizeof(Type)) {
      const Type number = value(Pixel{moments, beam, sample});
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
  return fmt::format("ensonify moments 1 block {} first {} beams {} samples {} count {:020}\n",
                     kMomentBlock, info.first_ping, info.sonar.beam_count, info.record.samples,
                     count);
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
    arrays[array.name] = {
        {"dtype", std::string_view(array.descr).substr(1, std::strlen(array.descr) - 2)},
        {"shape", shape_of(array, info.sonar.beam_count, info.record.samples)},
        {"unit", array.unit},
        {"what", array.what}};
  }
  return {{"realisations", count},
          {"axes", "rows: samples, nearest first; columns: beams, 0 first"},
          {"standard_error",
           {{"of", "one pixel of fully developed speckle; the first two relative to the mean"},
            {"mean_intensity", 1 / std::sqrt(n)},
            {"intensity_variance", std::sqrt(8 / n)},
            {"contrast", 1 / std::sqrt(n)},
            {"fourth_moment", 2 / std::sqrt(n)},
            {"coherence", "(1 - |coherence|^2) / sqrt(2 realisations)"}}},
          {"arrays", std::move(arrays)}};
}

Result<std::vector<FileEntry>> write_statistics(const fs::path& dir, const SequenceInfo& info,
                                                const Moments& moments) {
  if (moments.count != info.last_ping - info.first_ping) {
    return Error{
        ErrorKind::bug,
        fmt::format("sequence {}: statistics of {}, not {}; please report this", info.sequence,
                    counted(moments.count, "ping"), info.last_ping - info.first_ping)};
  }
  std::vector<FileEntry> entries;
  Status written;
  for_each_array([&](const StatisticsArray& array, auto value) {
    if (!written) return;
    auto entry = write_file_atomically(dir, layout::in_sequence(info.sequence, array.name),
                                       encode(array, moments, value));
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
  Moments moments(info.sonar.beam_count, info.record.samples);
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
