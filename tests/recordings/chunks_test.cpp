// Compressed chunks: what the libraries of both formats write comes back, and no size makes the
// reader allocate what the bytes cannot hold.
#include "recordings/mcap.h"

#include <lz4frame.h>
#include <zstd.h>

#include "catch.h"
#include "results.h"

using namespace ensonify;

namespace {

std::string lz4_of(const std::string& content) {
  std::string bytes(LZ4F_compressFrameBound(content.size(), nullptr), '\0');
  bytes.resize(
      LZ4F_compressFrame(bytes.data(), bytes.size(), content.data(), content.size(), nullptr));
  return bytes;
}

std::string zstd_of(const std::string& content) {
  std::string bytes(ZSTD_compressBound(content.size()), '\0');
  bytes.resize(ZSTD_compress(bytes.data(), bytes.size(), content.data(), content.size(), 3));
  return bytes;
}

}  // namespace

TEST_CASE("compressed chunks come back", "[chunks]") {
  std::string mixed;
  for (std::size_t i = 0; i < 300'000; ++i) mixed += static_cast<char>(i * i >> 7);
  for (const std::string& content : {std::string("a"), std::string(5'000'000, 'x'), mixed}) {
    for (const bool lz4 : {true, false}) {
      const std::string bytes = lz4 ? lz4_of(content) : zstd_of(content);
      const auto out = value_of(decompressed(lz4 ? "lz4" : "zstd", bytes, content.size()));
      CHECK(out == content);
      // Another size than that of the content.
      CHECK_FALSE(decompressed(lz4 ? "lz4" : "zstd", bytes, content.size() + 1).ok());
      CHECK_FALSE(decompressed(lz4 ? "lz4" : "zstd", bytes, content.size() - 1).ok());
      // All of the content, but not the end of the frame.
      for (std::size_t lost = 1; lost <= 4; ++lost) {
        const std::string cut = bytes.substr(0, bytes.size() - lost);
        CHECK_FALSE(decompressed(lz4 ? "lz4" : "zstd", cut, content.size()).ok());
      }
      CHECK_FALSE(
          decompressed(lz4 ? "lz4" : "zstd", bytes.substr(0, bytes.size() / 2), content.size())
              .ok());
    }
  }
}

// Protects the memory behind the content: what does not fit is not written.
TEST_CASE("a chunk may have several frames, and no more of them than it says", "[chunks]") {
  std::string first, second;
  for (std::size_t i = 0; i < 4'000'000; ++i) {
    first += static_cast<char>(i * i >> 9);
    second += static_cast<char>(i * i >> 8);
  }
  const std::string both = lz4_of(first) + lz4_of(second);
  const auto out = value_of(decompressed("lz4", both, first.size() + second.size()));
  CHECK(out == first + second);
  CHECK_FALSE(decompressed("lz4", both, first.size()).ok());
}

TEST_CASE("a size that compression cannot reach is refused", "[chunks]") {
  const std::string few(1000, '\0');
  for (const char* compression : {"lz4", "zstd"}) {
    check_fails(decompressed(compression, few, std::uint64_t{1} << 28),
                {"than the compression can hold"});
    CHECK_FALSE(decompressed(compression, few, ~std::uint64_t{0}).ok());
  }
  CHECK(contains(decompressed("brotli", few, 1).error().message, "mcap decompress"));
}
