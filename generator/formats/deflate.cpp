#include "formats/deflate.h"

#include <libdeflate.h>
#include <zlib.h>

#include <memory>
#include <new>

#include "core/error.h"

namespace ensonify {
namespace {

// Masks are runs and speckle has no matches: more than the first level costs time and gains a few
// percent.
constexpr int kLevel = 1;

struct FreeCompressor {
  void operator()(libdeflate_compressor* compressor) const {
    libdeflate_free_compressor(compressor);
  }
};

void append_noise(std::span<const std::uint8_t> bytes, std::string& out) {
  // Its tables are 100 kB and more: one for each thread, made once.
  thread_local const std::unique_ptr<libdeflate_compressor, FreeCompressor> compressor(
      libdeflate_alloc_compressor(kLevel));
  if (!compressor) throw std::bad_alloc();
  const std::size_t before = out.size();
  out.resize(before + libdeflate_zlib_compress_bound(compressor.get(), bytes.size()));
  const std::size_t size = libdeflate_zlib_compress(compressor.get(), bytes.data(), bytes.size(),
                                                    out.data() + before, out.size() - before);
  out.resize(before + size);
}

struct EndDeflate {
  void operator()(z_stream* stream) const {
    deflateEnd(stream);
    delete stream;
  }
};

using Zlib = std::unique_ptr<z_stream, EndDeflate>;

Zlib make_zlib() {
  // Below zero: without header and checksum, which libdeflate works out several times as fast.
  constexpr int kLargestWindow = -15, kMemory = 8;
  Zlib stream(new z_stream{});
  if (deflateInit2(stream.get(), kLevel, Z_DEFLATED, kLargestWindow, kMemory, Z_RLE) != Z_OK) {
    throw std::bad_alloc();
  }
  return stream;
}

void append_runs(std::span<const std::uint8_t> bytes, std::string& out) {
  thread_local const Zlib stream = make_zlib();
  out += "\x78\x01";  // RFC 1950: deflate with a window of 32 kB, the fastest level
  const std::size_t before = out.size();
  out.resize(before + deflateBound(stream.get(), bytes.size()));
  deflateReset(stream.get());
  // It reads through a pointer that is not const.
  stream->next_in = const_cast<std::uint8_t*>(bytes.data());
  stream->avail_in = static_cast<uInt>(bytes.size());
  stream->next_out = reinterpret_cast<Bytef*>(out.data() + before);
  stream->avail_out = static_cast<uInt>(out.size() - before);
  ENSONIFY_ASSERT(stream->avail_in == bytes.size() && stream->avail_out == out.size() - before);
  const int code = deflate(stream.get(), Z_FINISH);
  ENSONIFY_ASSERT(code == Z_STREAM_END);
  out.resize(before + stream->total_out);
  const std::uint32_t checksum = libdeflate_adler32(1, bytes.data(), bytes.size());
  for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(checksum >> shift & 255);
}

}  // namespace

void append_zlib(std::span<const std::uint8_t> bytes, Content content, std::string& out) {
  content == Content::runs ? append_runs(bytes, out) : append_noise(bytes, out);
}

std::uint32_t crc32_of(std::string_view bytes, std::uint32_t before) {
  return libdeflate_crc32(before, bytes.data(), bytes.size());
}

}  // namespace ensonify
