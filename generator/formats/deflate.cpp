#include "formats/deflate.h"

#include <isa-l/crc.h>
#include <isa-l/igzip_lib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <memory>
#include <utility>

#include "core/error.h"

namespace ensonify {
namespace {

// Level 1 with its second smallest buffer: for masks, labels and speckle, higher levels take two to
// seven times as long and save nothing. Level 0 takes 0.7 to 0.8 of the time and makes 1.3 to 1.45
// times the bytes; the smallest buffer takes twice the time, larger ones 0.95 for 1 % more bytes.
struct Compressor {
  isal_zstream stream;
  std::array<std::uint8_t, ISAL_DEF_LVL1_SMALL> buffer;
};

// Clears the tables, because their content from an earlier call can change the stream.
void clear(Compressor& compressor) {
  std::memset(&compressor.stream, 0, sizeof compressor.stream);
  compressor.buffer.fill(0);
}

// The first bytes are flushed separately, before the rest. The loop for long inputs of ISA-L up to
// 2.30 hashes the address of the stream in place of the second byte (.write_first_byte of
// igzip_icf_body_h1_gr_bt), so that the same bytes gave different streams from one thread or
// process to the next. Inputs as short as this do not enter that loop, and the bytes after them do
// not begin a stream.
constexpr std::size_t kFirstBytes = 8;

// A deflate block stores at most 65,535 uncompressed bytes after a header of 5 bytes.
std::size_t largest_size(std::size_t count) { return count + 5 * (count / 0xffff + 1) + 128; }

void feed(std::span<const std::uint8_t> bytes, isal_zstream& stream) {
  // ISA-L reads through a non-const pointer.
  stream.next_in = const_cast<std::uint8_t*>(bytes.data());
  stream.avail_in = static_cast<std::uint32_t>(bytes.size());
  ENSONIFY_ASSERT(stream.avail_in == bytes.size());
  const int code = isal_deflate(&stream);
  ENSONIFY_ASSERT(code == COMP_OK && stream.avail_in == 0);
}

}  // namespace

void append_zlib(std::span<const std::uint8_t> bytes, std::string& out) {
  // 170 kB: one for each thread, made once.
  thread_local const auto compressor = std::make_unique<Compressor>();
  clear(*compressor);
  isal_zstream& stream = compressor->stream;
  isal_deflate_init(&stream);
  stream.level = 1;
  stream.level_buf = compressor->buffer.data();
  stream.level_buf_size = static_cast<std::uint32_t>(compressor->buffer.size());
  stream.gzip_flag = IGZIP_ZLIB;
  // Without zeros: most of it is never written, and then takes no memory.
  const std::size_t most = largest_size(bytes.size());
  const auto compressed = std::make_unique_for_overwrite<std::uint8_t[]>(most);
  stream.next_out = compressed.get();
  stream.avail_out = static_cast<std::uint32_t>(most);
  ENSONIFY_ASSERT(stream.avail_out == most);
  const auto first = bytes.first(std::min(kFirstBytes, bytes.size()));
  stream.flush = SYNC_FLUSH;
  feed(first, stream);
  stream.flush = NO_FLUSH;
  stream.end_of_stream = 1;
  feed(bytes.subspan(first.size()), stream);
  ENSONIFY_ASSERT(stream.internal_state.state == ZSTATE_END);
  out.append(reinterpret_cast<const char*>(compressed.get()), stream.total_out);
}

std::optional<std::string> inflate_zlib(std::string_view stream, std::uint64_t size) {
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint32_t>::max();
  if (size > kMost || stream.size() > kMost) return std::nullopt;
  const auto state = std::make_unique<inflate_state>();
  isal_inflate_init(state.get());
  state->crc_flag = ISAL_ZLIB;
  std::string out(size, '\0');
  std::string text(stream);  // ISA-L reads through a non-const pointer
  state->next_in = reinterpret_cast<std::uint8_t*>(text.data());
  state->avail_in = static_cast<std::uint32_t>(text.size());
  state->next_out = reinterpret_cast<std::uint8_t*>(out.data());
  state->avail_out = static_cast<std::uint32_t>(size);
  const int code = isal_inflate(state.get());
  const bool whole = code == ISAL_DECOMP_OK && state->block_state == ISAL_BLOCK_FINISH;
  return whole && state->avail_out == 0 ? std::optional(std::move(out)) : std::nullopt;
}

std::uint32_t crc32_of(std::string_view bytes, std::uint32_t before) {
  const auto* first = reinterpret_cast<const unsigned char*>(bytes.data());
  return crc32_gzip_refl(before, first, bytes.size());
}

}  // namespace ensonify
