#include "recordings/chunks.h"

#include <fmt/format.h>
#include <lz4frame.h>
#include <zstd.h>

namespace ensonify {
namespace {

// Of a byte, at best: a run of 255 bytes; a block of 128 KiB that takes four bytes.
constexpr std::uint64_t kMostOfByteLz4 = 255, kMostOfByteZstd = 32'768;

struct Lz4Reader {
  LZ4F_dctx* context = nullptr;
  Lz4Reader() {
    if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION))) context = nullptr;
  }
  ~Lz4Reader() { LZ4F_freeDecompressionContext(context); }
  Lz4Reader(const Lz4Reader&) = delete;
  Lz4Reader& operator=(const Lz4Reader&) = delete;
};

// Whether the bytes are one or more whole frames that fill `out`, neither more nor less.
bool read_lz4(std::string_view bytes, std::string& out) {
  Lz4Reader reader;
  if (reader.context == nullptr) return false;
  std::size_t at = 0, filled = 0, hint = 0;  // 0: at the end of a frame
  while (at < bytes.size()) {
    std::size_t taken = bytes.size() - at, made = out.size() - filled;
    hint = LZ4F_decompress(reader.context, out.data() + filled, &made, bytes.data() + at, &taken,
                           nullptr);
    if (LZ4F_isError(hint) || (taken == 0 && made == 0)) return false;
    at += taken;
    filled += made;
  }
  return filled == out.size() && hint == 0;
}

bool read_zstd(std::string_view bytes, std::string& out) {
  const std::size_t made = ZSTD_decompress(out.data(), out.size(), bytes.data(), bytes.size());
  return !ZSTD_isError(made) && made == out.size();
}

}  // namespace

Result<std::string> decompressed(std::string_view compression, std::string_view bytes,
                                 std::uint64_t size) {
  const auto refused = [](const std::string& what) { return Error{ErrorKind::usage, what}; };
  const bool lz4 = compression == "lz4";
  if (!lz4 && compression != "zstd") {
    return refused(
        "a chunk of another compression than lz4 and zstd; `mcap decompress` writes the "
        "file without compression");
  }
  if (size > kMostChunk || size / (lz4 ? kMostOfByteLz4 : kMostOfByteZstd) > bytes.size()) {
    return refused(
        fmt::format("a chunk of {} bytes, compressed to {}; expected at most {}, and no "
                    "more than the compression can hold",
                    size, bytes.size(), kMostChunk));
  }
  std::string out(size, '\0');
  if (lz4 ? read_lz4(bytes, out) : read_zstd(bytes, out)) return out;
  return refused(fmt::format("a damaged chunk ({})", compression));
}

}  // namespace ensonify
