#include "formats/jpeg.h"

// jpeglib.h needs FILE and size_t.
#include <cstddef>
#include <cstdio>
// clang-format off
#include <jpeglib.h>
// clang-format on

#include <stdexcept>
#include <string>

namespace ensonify {
namespace {

// A baseline image needs 2 bits or more for each block of 64 pixels in each component, a
// progressive one as little as a run of blocks takes.
constexpr std::uint64_t kMostPixelsOfByte = 2048;
constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 28;

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

struct JpegReader {
  jpeg_error_mgr errors{};
  jpeg_decompress_struct state{};
  JpegReader() {
    state.err = jpeg_std_error(&errors);
    errors.error_exit = fail_jpeg;
    errors.emit_message = warn_jpeg;
    jpeg_create_decompress(&state);
  }
  ~JpegReader() { jpeg_destroy_decompress(&state); }
  JpegReader(const JpegReader&) = delete;
  JpegReader& operator=(const JpegReader&) = delete;
};

GreyJpeg read_jpeg(std::string_view bytes) {
  JpegReader reader;
  const void* const start = bytes.data();
  jpeg_mem_src(&reader.state, static_cast<const unsigned char*>(start), bytes.size());
  jpeg_read_header(&reader.state, TRUE);
  GreyJpeg image;
  image.rows = reader.state.image_height;
  image.columns = reader.state.image_width;
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

}  // namespace

Result<GreyJpeg> parse_grey_jpeg(std::string_view bytes) {
  try {
    return read_jpeg(bytes);
  } catch (const std::runtime_error& error) {
    return Error{ErrorKind::usage, std::string("is not a readable JPEG file: ") + error.what()};
  }
}

}  // namespace ensonify
