#include "formats/jpeg.h"

// jpeglib.h needs FILE and size_t.
#include <cstddef>
#include <cstdio>
// clang-format off
#include <jpeglib.h>
// clang-format on

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <stdexcept>
#include <string>

namespace ensonify {
namespace {

// A baseline image needs 2 bits or more for each block of 64 pixels in each component, a
// progressive one as little as a run of blocks takes.
constexpr std::uint64_t kMostPixelsOfByte = 2048;
constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 28;
// Each scan of a progressive image passes over all pixels, however few bytes it has; encoders write
// about ten.
constexpr int kMostScans = 100;

// By default libjpeg ends the program; this throws instead.
[[noreturn]] void fail_jpeg(j_common_ptr state) {
  char text[JMSG_LENGTH_MAX];
  state->err->format_message(state, text);
  throw std::runtime_error(text);
}

// A warning is damage: libjpeg goes on with gray.
void warn_jpeg(j_common_ptr state, int level) {
  if (level < 0) fail_jpeg(state);
}

void limit_scans(j_common_ptr common) {
  void* const state = common;
  if (static_cast<j_decompress_ptr>(state)->input_scan_number > kMostScans) {
    throw std::runtime_error("it has more than 100 scans");
  }
}

struct JpegReader {
  jpeg_error_mgr errors{};
  jpeg_progress_mgr progress{};
  jpeg_decompress_struct state{};
  JpegReader() {
    state.err = jpeg_std_error(&errors);
    errors.error_exit = fail_jpeg;
    errors.emit_message = warn_jpeg;
    jpeg_create_decompress(&state);
    progress.progress_monitor = limit_scans;
    state.progress = &progress;
  }
  ~JpegReader() { jpeg_destroy_decompress(&state); }
  JpegReader(const JpegReader&) = delete;
  JpegReader& operator=(const JpegReader&) = delete;
};

GreyJpeg read_jpeg(std::string_view bytes, const std::optional<JpegSize>& expected) {
  JpegReader reader;
  const void* const start = bytes.data();
  jpeg_mem_src(&reader.state, static_cast<const unsigned char*>(start), bytes.size());
  jpeg_read_header(&reader.state, TRUE);
  GreyJpeg image;
  image.rows = reader.state.image_height;
  image.columns = reader.state.image_width;
  const int components = reader.state.num_components;
  if (expected &&
      (image.rows != expected->rows || image.columns != expected->columns || components != 1)) {
    throw std::runtime_error(
        fmt::format("it has {} x {} pixels of {} components; expected {} x {} of 1", image.rows,
                    image.columns, components, expected->rows, expected->columns));
  }
  const std::uint64_t pixels = std::uint64_t{image.rows} * image.columns;
  if (pixels > kMostPixels || pixels / kMostPixelsOfByte > bytes.size()) {
    throw std::runtime_error("its header gives more pixels than it holds");
  }
  reader.state.out_color_space = JCS_GRAYSCALE;
  jpeg_start_decompress(&reader.state);
  image.grey.resize(pixels);
  while (reader.state.output_scanline < reader.state.output_height) {
    JSAMPROW row = image.grey.data() + std::size_t{reader.state.output_scanline} * image.columns;
    jpeg_read_scanlines(&reader.state, &row, 1);
  }
  jpeg_finish_decompress(&reader.state);
  return image;
}

struct JpegWriter {
  jpeg_error_mgr errors{};
  jpeg_compress_struct state{};
  unsigned char* bytes = nullptr;  // allocated by libjpeg
  unsigned long size = 0;
  JpegWriter() {
    state.err = jpeg_std_error(&errors);
    errors.error_exit = fail_jpeg;
    errors.emit_message = warn_jpeg;
    jpeg_create_compress(&state);
  }
  ~JpegWriter() {
    jpeg_destroy_compress(&state);
    std::free(bytes);
  }
  JpegWriter(const JpegWriter&) = delete;
  JpegWriter& operator=(const JpegWriter&) = delete;
};

std::string write_jpeg(std::span<const std::uint8_t> grey, int rows, int columns, int quality) {
  JpegWriter writer;
  jpeg_mem_dest(&writer.state, &writer.bytes, &writer.size);
  writer.state.image_width = static_cast<JDIMENSION>(columns);
  writer.state.image_height = static_cast<JDIMENSION>(rows);
  writer.state.input_components = 1;
  writer.state.in_color_space = JCS_GRAYSCALE;
  jpeg_set_defaults(&writer.state);
  jpeg_set_quality(&writer.state, quality, TRUE);
  jpeg_start_compress(&writer.state, TRUE);
  std::vector<std::uint8_t> line(static_cast<std::size_t>(columns));
  while (writer.state.next_scanline < writer.state.image_height) {
    const auto from = grey.subspan(std::size_t{writer.state.next_scanline} * line.size());
    std::copy_n(from.begin(), line.size(), line.begin());
    JSAMPROW row = line.data();
    jpeg_write_scanlines(&writer.state, &row, 1);
  }
  jpeg_finish_compress(&writer.state);
  const void* const start = writer.bytes;
  return {static_cast<const char*>(start), writer.size};
}

}  // namespace

Result<GreyJpeg> parse_grey_jpeg(std::string_view bytes, const std::optional<JpegSize>& expected) {
  try {
    return read_jpeg(bytes, expected);
  } catch (const std::runtime_error& error) {
    return Error{ErrorKind::usage, std::string("is not a readable JPEG file: ") + error.what()};
  }
}

Result<std::string> encode_grey_jpeg(std::span<const std::uint8_t> grey, int rows, int columns,
                                     int quality) {
  ENSONIFY_ASSERT(rows > 0 && columns > 0 && quality >= 1 && quality <= 100);
  ENSONIFY_ASSERT(grey.size() ==
                  static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns));
  try {
    return write_jpeg(grey, rows, columns, quality);
  } catch (const std::runtime_error& error) {
    return Error{ErrorKind::usage, std::string("cannot be a JPEG file: ") + error.what()};
  }
}

}  // namespace ensonify
