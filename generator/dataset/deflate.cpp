#include "dataset/deflate.h"

#include <libdeflate.h>

#include <memory>
#include <new>

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

}  // namespace

void append_zlib(std::span<const std::uint8_t> bytes, std::string& out) {
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

}  // namespace ensonify
