#include "report/pictures.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "formats/bytes.h"
#include "formats/webp.h"

namespace ensonify {
namespace {

constexpr int kBestQuality = 90, kLeastQuality = 1;
constexpr int kCleanQuality = 15;                 // more than of levels: what is smooth is small
constexpr std::uint64_t kTried = 12;              // pings that the quality is chosen by
constexpr std::uint64_t kHeldPixels = 8'000'000;  // of 17 bytes each, while it is chosen
constexpr double kElevationShare = 0.12;          // of the budget, at most
constexpr int kMostElevationStep = 4;
constexpr int kElevationCodes = 84;  // of a fan of 20 degrees a quarter of a degree each
constexpr double kSlack = 1.02;      // beyond the budget
constexpr std::int16_t kNoLevel = -32768;

struct Quality {
  int lossy = kBestQuality, elevation_step = 1;
};

// The chunks of a ping, empty where there is none.
struct PingBytes {
  std::string level, clean, elevation, labels, shadow, multipath, beam_level, beam_clean;
  std::size_t beam = 0;

  std::uint64_t bytes() const {
    std::uint64_t sum = 0;
    for (const std::string* s :
         {&level, &clean, &elevation, &labels, &shadow, &multipath, &beam_level, &beam_clean}) {
      sum += base64_bytes(s->size());
    }
    return sum;
  }
};

// Every n-th row and column of an image, so that it has at most the allowed size.
class Grid {
 public:
  Grid(std::uint64_t rows, std::uint64_t columns, std::size_t step) : all_(rows), across_(columns) {
    const std::size_t side = std::max(all_, across_);
    step_ = std::max<std::size_t>(step, (side + kWebpMostPixels - 1) / kWebpMostPixels);
    rows_ = (all_ + step_ - 1) / step_;
    columns_ = (across_ + step_ - 1) / step_;
  }
  int width() const { return static_cast<int>(columns_); }
  int height() const { return static_cast<int>(rows_); }

  // code(i) of the kept pixels, where i is the index in the image.
  template <class Code, class Make>
  std::vector<Code> codes(Make code) const {
    std::vector<Code> made(rows_ * columns_);
    for (std::size_t row = 0; row < rows_; ++row) {
      for (std::size_t column = 0; column < columns_; ++column) {
        // The middle one of the pixels that it represents.
        const std::size_t r = std::min(row * step_ + step_ / 2, all_ - 1);
        const std::size_t c = std::min(column * step_ + step_ / 2, across_ - 1);
        made[row * columns_ + column] = code(r * across_ + c);
      }
    }
    return made;
  }

 private:
  std::size_t all_, across_;  // rows and columns of the image
  std::size_t rows_ = 0, columns_ = 0, step_ = 1;
};

Status put(Result<std::string> made, std::string& bytes) {
  if (!made) return made.error();
  bytes = std::move(*made);
  return {};
}

Status encode_level(const StoredPixels& pixels, const std::vector<float>& level_db,
                    const PictureScale& scale, int quality, std::string& bytes) {
  if (level_db.empty()) return {};
  const Grid grid(pixels.rows, pixels.columns, 1);
  const auto grey = grid.codes<std::uint8_t>([&](std::size_t i) -> std::uint8_t {
    if (!(level_db[i] > kNoEnergyDb)) return 0;
    return grey_code(level_db[i], scale.min_db, scale.max_db);
  });
  return put(lossy_grey(grey, grid.width(), grid.height(), quality), bytes);
}

Status encode_elevation(const StoredPixels& pixels, const PictureScale& scale, int step,
                        std::string& bytes) {
  if (pixels.elevation_rad.empty() || !scale.min_rad) return {};
  const Grid grid(pixels.rows, pixels.columns, static_cast<std::size_t>(step));
  // Fewer codes take fewer bytes; they are spread over the 255 so that the first and last stay.
  constexpr double kStep = 254.0 / kElevationCodes;
  const auto grey = grid.codes<std::uint8_t>([&](std::size_t i) -> std::uint8_t {
    const int code = grey_code(pixels.elevation_rad[i], *scale.min_rad, *scale.max_rad);
    if (code == 0) return 0;
    return static_cast<std::uint8_t>(1 + std::lround(std::lround((code - 1) / kStep) * kStep));
  });
  return put(lossless_grey(grey, grid.width(), grid.height()), bytes);
}

std::uint32_t rgb(std::uint16_t id, std::uint8_t blue) {
  return (id & 0xffu) << 16 | (id & 0xff00u) | blue;
}

Status encode_ids(const StoredPixels& pixels, PingBytes& ping) {
  const Grid grid(pixels.rows, pixels.columns, 1);
  const bool instances = !pixels.instance.empty(), classes = !pixels.semantic.empty();
  Status done;
  if (instances || classes) {
    const auto labels = grid.codes<std::uint32_t>([&](std::size_t i) {
      return rgb(instances ? pixels.instance[i] : std::uint16_t{0},
                 classes ? pixels.semantic[i] : std::uint8_t{0});
    });
    done = put(lossless_rgb(labels, grid.width(), grid.height()), ping.labels);
  }
  const auto put_mask = [&](const std::vector<std::uint16_t>& ids, std::string& bytes) {
    if (!done || ids.empty()) return;
    const auto mask = grid.codes<std::uint32_t>([&](std::size_t i) { return rgb(ids[i], 0); });
    done = put(lossless_rgb(mask, grid.width(), grid.height()), bytes);
  };
  put_mask(pixels.shadow, ping.shadow);
  put_mask(pixels.multipath, ping.multipath);
  return done;
}

// The strongest expected echo of the visible instance with the fewest pixels; without masks the
// strongest of all.
std::size_t telling_beam(const StoredPixels& pixels) {
  const auto& level_db = pixels.clean_db.empty() ? pixels.level_db : pixels.clean_db;
  std::vector<std::uint64_t> sizes;
  for (const std::uint16_t id : pixels.instance) {
    if (id >= sizes.size()) sizes.resize(id + std::size_t{1});
    ++sizes[id];
  }
  std::size_t smallest = 0;
  for (std::size_t id = 1; id < sizes.size(); ++id) {
    if (sizes[id] > 0 && (smallest == 0 || sizes[id] < sizes[smallest])) smallest = id;
  }
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < level_db.size(); ++i) {
    if (smallest > 0 && pixels.instance[i] != smallest) continue;
    if (!best || level_db[i] > level_db[*best]) best = i;
  }
  return best.value_or(0) % pixels.columns;
}

// Int16, little-endian, hundredths of a dB.
std::string beam_levels(const StoredPixels& pixels, const std::vector<float>& level_db,
                        std::size_t beam) {
  std::string bytes;
  for (std::size_t i = beam; i < level_db.size(); i += pixels.columns) {
    const bool heard = level_db[i] > kNoEnergyDb;
    const auto hundredths =
        heard ? static_cast<std::int16_t>(std::lround(std::clamp(level_db[i], -300.f, 300.f) * 100))
              : kNoLevel;
    const auto bits = static_cast<std::uint16_t>(hundredths);
    bytes += static_cast<char>(bits & 0xff);
    bytes += static_cast<char>(bits >> 8);
  }
  return bytes;
}

Status encode_levels(const StoredPixels& pixels, const PictureScale& scale, int quality,
                     PingBytes& ping) {
  const Status done = encode_level(pixels, pixels.level_db, scale, quality, ping.level);
  if (!done) return done;
  const int clean = std::min(quality + kCleanQuality, kBestQuality);
  return encode_level(pixels, pixels.clean_db, scale, clean, ping.clean);
}

Result<PingBytes> encode_ping_pictures(const StoredPixels& pixels, const PictureScale& scale,
                                       Quality quality) {
  PingBytes ping;
  Status done = encode_levels(pixels, scale, quality.lossy, ping);
  if (done) done = encode_elevation(pixels, scale, quality.elevation_step, ping.elevation);
  if (done) done = encode_ids(pixels, ping);
  if (!done) return done.error();
  if (pixels.level_db.empty()) return ping;
  ping.beam = telling_beam(pixels);
  ping.beam_level = beam_levels(pixels, pixels.level_db, ping.beam);
  ping.beam_clean = beam_levels(pixels, pixels.clean_db, ping.beam);
  return ping;
}

// Estimates the bytes of all pings from a held sample.
class Trial {
 public:
  Trial(const PictureJob& job, const PictureScale& scale) : job_(job), scale_(scale) {}

  Status read() {
    const std::vector<ShownPing>& shown = job_.survey.shown;
    std::uint64_t largest = 1;
    for (const ShownSequence& sequence : job_.survey.sequences) {
      largest = std::max(largest, sequence.stored.beams * sequence.stored.samples);
    }
    const std::uint64_t most = std::clamp<std::uint64_t>(kHeldPixels / largest, 1, kTried);
    const auto some = spread(shown.size(), most);
    pixels_.resize(some.size());
    return for_each_picture(job_.workers, job_.stop, some.size(), [&](std::size_t i) -> Status {
      auto pixels = pixels_of(job_, shown[some[i]]);
      if (!pixels) return pixels.error();
      pixels_[i] = std::move(*pixels);
      return {};
    });
  }

  // `what` gives a ping's chunks.
  Result<double> bytes(const std::function<Status(const StoredPixels&, PingBytes&)>& what) const {
    std::vector<PingBytes> tried(pixels_.size());
    const Status done = for_each_picture(job_.workers, job_.stop, tried.size(),
                                         [&](std::size_t i) { return what(pixels_[i], tried[i]); });
    if (!done) return done.error();
    double sum = 0;
    for (const PingBytes& ping : tried) sum += static_cast<double>(ping.bytes());
    const auto all = static_cast<double>(job_.survey.shown.size());
    return sum * all / static_cast<double>(std::max<std::size_t>(tried.size(), 1));
  }
  Result<double> elevations(int step) const {
    return bytes([&](const StoredPixels& pixels, PingBytes& ping) {
      return encode_elevation(pixels, scale_, step, ping.elevation);
    });
  }
  Result<double> levels(int quality) const {
    return bytes([&](const StoredPixels& pixels, PingBytes& ping) {
      return encode_levels(pixels, scale_, quality, ping);
    });
  }
  // Parts without a quality setting.
  Result<double> others() const {
    return bytes([&](const StoredPixels& pixels, PingBytes& ping) {
      ping.beam_level = beam_levels(pixels, pixels.level_db, 0);
      ping.beam_clean = beam_levels(pixels, pixels.clean_db, 0);
      return encode_ids(pixels, ping);
    });
  }

 private:
  const PictureJob& job_;
  const PictureScale& scale_;
  std::vector<StoredPixels> pixels_;
};

Result<Quality> choose_quality(const PictureJob& job, const PictureScale& scale, double budget) {
  Trial trial(job, scale);
  if (const Status read = trial.read(); !read) return read.error();
  Quality quality;
  auto elevations = trial.elevations(1);
  while (elevations && *elevations > kElevationShare * budget &&
         quality.elevation_step < kMostElevationStep) {
    quality.elevation_step *= 2;
    elevations = trial.elevations(quality.elevation_step);
  }
  if (!elevations) return elevations.error();
  const auto others = trial.others();
  if (!others) return others.error();
  const double left = budget - *elevations - *others;
  int low = kLeastQuality, high = kBestQuality + 1;  // low fits, or nothing does; high does not
  auto best = trial.levels(kBestQuality);
  if (!best) return best.error();
  if (*best <= left) low = kBestQuality;
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    const auto bytes = trial.levels(middle);
    if (!bytes) return bytes.error();
    (*bytes <= left ? low : high) = middle;
  }
  quality.lossy = low;
  return quality;
}

Result<std::vector<PingBytes>> encode_all(const PictureJob& job, const PictureScale& scale,
                                          Quality quality) {
  const std::vector<ShownPing>& shown = job.survey.shown;
  std::vector<PingBytes> pings(shown.size());
  const Status done =
      for_each_picture(job.workers, job.stop, shown.size(), [&](std::size_t i) -> Status {
        const auto pixels = pixels_of(job, shown[i]);
        if (!pixels) return pixels.error();
        auto bytes = encode_ping_pictures(*pixels, scale, quality);
        if (!bytes) return bytes.error();
        pings[i] = std::move(*bytes);
        return {};
      });
  if (!done) return done.error();
  return pings;
}

CodedPing code_of(PingBytes& ping, Chunks& chunks) {
  const auto add = [&](std::string& bytes) {
    return bytes.empty() ? std::nullopt : std::optional(chunks.add(std::move(bytes)));
  };
  CodedPing coded;
  coded.level = add(ping.level);
  coded.clean = add(ping.clean);
  coded.elevation = add(ping.elevation);
  coded.labels = add(ping.labels);
  coded.shadow = add(ping.shadow);
  coded.multipath = add(ping.multipath);
  coded.beam = ping.beam;
  coded.beam_level = add(ping.beam_level);
  coded.beam_clean = add(ping.beam_clean);
  return coded;
}

constexpr double kMeanSpan_db = 80;  // of mean levels, below the highest

// An array of statistics: its values [samples x beams], NaN for none, as codes from `min` to `max`;
// what lies beyond them has theirs.
Result<CodedArray> code_of(CodedArray array, const std::vector<double>& values,
                           const StoredSequence& sequence, Chunks& chunks) {
  const Grid grid(sequence.samples, sequence.beams, 1);
  const auto grey = grid.codes<std::uint8_t>(
      [&](std::size_t i) { return grey_code(values[i], array.min, array.max); });
  auto picture = lossless_grey(grey, grid.width(), grid.height());
  if (!picture) return picture.error();
  array.chunk = chunks.add(std::move(*picture));
  return array;
}

Result<CodedArray> contrast_of(const PictureJob& job, const StoredSequence& sequence,
                               Chunks& chunks) {
  const auto values = read_statistics(job.dataset, sequence, "contrast");
  if (!values) return values.error();
  return code_of(
      {"contrast", "", "standard deviation of the intensity divided by its mean", 0, 2, 0}, *values,
      sequence, chunks);
}

Result<CodedArray> level_of(const PictureJob& job, const StoredSequence& sequence, Chunks& chunks) {
  auto values = read_statistics(job.dataset, sequence, "mean_intensity");
  if (!values) return values.error();
  double highest_db = kNoEnergyDb;
  for (double& value : *values) {
    const double db = level_db(value);
    value = db > kNoEnergyDb ? db : std::nan("");
    highest_db = std::max(highest_db, db);
  }
  const double most_db = std::ceil(highest_db);
  return code_of({"mean_intensity", "dB", "level of the mean intensity, dB re 1 uPa",
                  most_db - kMeanSpan_db, most_db, 0},
                 *values, sequence, chunks);
}

}  // namespace

Result<PictureBook> encode_pictures(const PictureJob& job, const PictureScale& scale,
                                    std::uint64_t budget, Chunks& chunks) {
  const auto left = static_cast<double>(budget);
  auto quality = choose_quality(job, scale, left);
  if (!quality) return quality.error();
  auto pings = encode_all(job, scale, *quality);
  if (!pings) return pings.error();
  std::uint64_t sum = 0;
  for (const PingBytes& ping : *pings) sum += ping.bytes();
  // The tried pings may be smaller than the others.
  if (static_cast<double>(sum) > kSlack * left && quality->lossy > kLeastQuality) {
    quality = choose_quality(job, scale, left * left / static_cast<double>(sum));
    if (!quality) return quality.error();
    pings = encode_all(job, scale, *quality);
    if (!pings) return pings.error();
  }
  PictureBook book{{}, quality->lossy, quality->elevation_step};
  for (PingBytes& ping : *pings) book.pings.push_back(code_of(ping, chunks));
  return book;
}

Result<std::vector<CodedStatistics>> encode_statistics(const PictureJob& job, Chunks& chunks) {
  std::vector<CodedStatistics> all;
  for (std::size_t i = 0; i < job.survey.sequences.size(); ++i) {
    const ShownSequence& sequence = job.survey.sequences[i];
    if (sequence.facts.realisations == 0) continue;
    CodedStatistics statistics{i, sequence.facts.realisations, {}};
    for (const auto make : {level_of, contrast_of}) {
      auto array = make(job, sequence.stored, chunks);
      if (!array) return array.error();
      statistics.arrays.push_back(std::move(*array));
    }
    all.push_back(std::move(statistics));
  }
  return all;
}

}  // namespace ensonify
