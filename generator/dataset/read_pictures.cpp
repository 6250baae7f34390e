#include "dataset/read_pictures.h"

#include <cstring>
#include <span>
#include <string>

#include "dataset/exr.h"
#include "dataset/files.h"
#include "dataset/half_floats.h"
#include "dataset/layout.h"
#include "dataset/npy_file.h"
#include "dataset/read_png.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

struct ViewFiles {
  std::string name;  // what packed arrays begin with
  const char *exr, *instance, *semantic, *shadow;
};

ViewFiles files_of(StoredView view) {
  using namespace layout;
  if (view == StoredView::polar) {
    return {"polar", kPolarExr, kPolarInstance, kPolarSemantic, kPolarShadow};
  }
  return {"cartesian", kCartesianExr, kCartesianInstance, kCartesianSemantic, kCartesianShadow};
}

// One ping's picture, from either kind of file.
class PictureReader {
 public:
  PictureReader(const StoredDataset& dataset, const StoredSequence& sequence, StoredView view,
                std::uint32_t ping)
      : dataset_(dataset), sequence_(sequence), files_(files_of(view)), ping_(ping) {
    const bool polar = view == StoredView::polar;
    pixels_.rows = polar ? sequence.samples : sequence.cartesian_height;
    pixels_.columns = polar ? sequence.beams : sequence.cartesian_width;
  }

  Result<StoredPixels> read(const PictureChannels& c) {
    if (pixels_.rows == 0 || pixels_.columns == 0) return std::move(pixels_);
    Status done = sequence_.packed ? read_arrays(c) : read_files(c);
    if (!done) return done.error();
    return std::move(pixels_);
  }

 private:
  Status read_files(const PictureChannels& c) {
    Status done;
    if (c.level || c.clean || c.elevation) done = read_exr(c);
    if (done && c.instance) done = read_png(files_.instance, read_grey16, pixels_.instance);
    if (done && c.semantic) done = read_png(files_.semantic, read_grey8, pixels_.semantic);
    if (done && c.shadow) done = read_png(files_.shadow, read_grey16, pixels_.shadow);
    return done;
  }

  Status read_exr(const PictureChannels& c) {
    if (!sequence_.has(files_.exr)) return {};
    const auto path = ping_file(dataset_, sequence_.row.sequence, files_.exr, ping_);
    if (!path) return path.error();
    std::error_code error;
    // Levels are stored as they are: a shorter file is not worth asking for memory.
    if (fs::file_size(*path, error) < pixels_.rows * pixels_.columns * 2 || error) {
      return damaged(*path, "is cut short");
    }
    const auto halves =
        read_exr_halves(*path, static_cast<int>(pixels_.rows), static_cast<int>(pixels_.columns));
    if (!halves) return halves.error();
    if (c.level) take_halves(halves->level_db, pixels_.level_db);
    if (c.clean) take_halves(halves->clean_db, pixels_.clean_db);
    if (c.elevation) take_halves(halves->elevation_rad, pixels_.elevation_rad);
    return {};
  }

  template <class Read, class Pixel>
  Status read_png(const char* name_template, Read decode, std::vector<Pixel>& pixels) {
    if (!sequence_.has(name_template)) return {};
    const auto path = ping_file(dataset_, sequence_.row.sequence, name_template, ping_);
    if (!path) return path.error();
    auto found = decode(*path, pixels_.rows, pixels_.columns);
    if (!found) return found.error();
    pixels = std::move(*found);
    return {};
  }

  Status read_arrays(const PictureChannels& c) {
    Status done;
    if (c.level) done = read_half_row("level_db", pixels_.level_db);
    if (done && c.clean) done = read_half_row("clean_db", pixels_.clean_db);
    if (done && c.elevation) done = read_half_row("elevation_rad", pixels_.elevation_rad);
    if (done && c.instance) done = read_row("instance", kNpyUint16, pixels_.instance);
    if (done && c.semantic) done = read_row("semantic", kNpyUint8, pixels_.semantic);
    if (done && c.shadow) done = read_row("shadow", kNpyUint16, pixels_.shadow);
    return done;
  }

  template <class Pixel>
  Status read_row(const char* channel, const char* descr, std::vector<Pixel>& pixels) {
    const std::string file = files_.name + "_" + channel + ".npy";
    if (!sequence_.has_array(file)) return {};
    const auto path = stored_file(dataset_, sequence_.row.sequence, file);
    if (!path) return path.error();
    const auto row =
        read_npy_row(*path, descr, {sequence_.row.pings(), pixels_.rows, pixels_.columns},
                     ping_ - sequence_.row.first_ping);
    if (!row) return row.error();
    pixels.resize(row->size() / sizeof(Pixel));
    std::memcpy(pixels.data(), row->data(), pixels.size() * sizeof(Pixel));
    return {};
  }

  Status read_half_row(const char* channel, std::vector<float>& values) {
    std::vector<std::uint16_t> halves;
    const Status done = read_row(channel, kNpyFloat16, halves);
    if (done) take_halves(halves, values);
    return done;
  }

  static void take_halves(std::span<const std::uint16_t> halves, std::vector<float>& values) {
    values.resize(halves.size());
    from_halves(halves, values);
  }

  const StoredDataset& dataset_;
  const StoredSequence& sequence_;
  ViewFiles files_;
  std::uint32_t ping_;
  StoredPixels pixels_;
};

std::vector<std::complex<float>> series_from(std::string_view bytes) {
  std::vector<std::complex<float>> series(bytes.size() / sizeof(std::complex<float>));
  std::memcpy(static_cast<void*>(series.data()), bytes.data(), bytes.size());
  return series;
}

constexpr char kPackedSeries[] = "timeseries.npy";

Result<std::vector<std::complex<float>>> read_packed_series(const StoredDataset& dataset,
                                                            const StoredSequence& sequence,
                                                            std::uint32_t ping) {
  const auto path = stored_file(dataset, sequence.row.sequence, kPackedSeries);
  if (!path) return path.error();
  const auto row =
      read_npy_row(*path, kNpyComplex64, {sequence.row.pings(), sequence.beams, sequence.samples},
                   ping - sequence.row.first_ping);
  if (!row) return row.error();
  return series_from(*row);
}

}  // namespace

PictureChannels stored_channels(const StoredSequence& sequence, StoredView view) {
  const ViewFiles files = files_of(view);
  const auto has = [&](const char* name_template, const char* channel) {
    return sequence.packed ? sequence.has_array(files.name + "_" + channel + ".npy")
                           : sequence.has(name_template);
  };
  PictureChannels channels;
  channels.level = has(files.exr, "level_db");
  channels.clean = has(files.exr, "clean_db");
  channels.elevation = has(files.exr, "elevation_rad");
  channels.instance = has(files.instance, "instance");
  channels.semantic = has(files.semantic, "semantic");
  channels.shadow = has(files.shadow, "shadow");
  return channels;
}

bool has_series(const StoredSequence& sequence) {
  return sequence.has_array(kPackedSeries) || sequence.has(layout::kTimeseries) ||
         sequence.has(layout::kTimeseriesExr);
}

Result<StoredPixels> read_picture(const StoredDataset& dataset, const StoredSequence& sequence,
                                  StoredView view, std::uint32_t ping,
                                  const PictureChannels& channels) {
  ENSONIFY_ASSERT(ping >= sequence.row.first_ping && ping < sequence.row.last_ping);
  return PictureReader(dataset, sequence, view, ping).read(channels);
}

Result<std::vector<std::complex<float>>> read_series(const StoredDataset& dataset,
                                                     const StoredSequence& sequence,
                                                     std::uint32_t ping) {
  ENSONIFY_ASSERT(ping >= sequence.row.first_ping && ping < sequence.row.last_ping);
  if (sequence.has_array(kPackedSeries)) return read_packed_series(dataset, sequence, ping);
  const bool as_npy = sequence.has(layout::kTimeseries);
  if (!as_npy && !sequence.has(layout::kTimeseriesExr)) {
    return std::vector<std::complex<float>>{};
  }
  const auto path = ping_file(dataset, sequence.row.sequence,
                              as_npy ? layout::kTimeseries : layout::kTimeseriesExr, ping);
  if (!path) return path.error();
  std::error_code error;
  const std::uint64_t bytes = sequence.beams * sequence.samples * sizeof(std::complex<float>);
  if (fs::file_size(*path, error) < bytes || error) return damaged(*path, "is cut short");
  if (!as_npy) {
    return read_series_exr(*path, static_cast<int>(sequence.samples),
                           static_cast<int>(sequence.beams));
  }
  const auto array = read_npy(*path, kNpyComplex64, {sequence.beams, sequence.samples});
  if (!array) return array.error();
  return series_from(array->data());
}

}  // namespace ensonify
