#include "dataset/direct_write.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <memory>

namespace ensonify {
namespace {

constexpr std::size_t kBlock = 4096;
constexpr std::size_t kPiece = 1 << 20;

struct Free {
  void operator()(void* memory) const { std::free(memory); }
};

// Writes one piece of whole blocks; false with errno where that fails.
bool write_piece(int descriptor, const char* data, std::size_t size) {
  while (size > 0) {
    const auto written = ::write(descriptor, data, size);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    data += written;
    size -= static_cast<std::size_t>(written);
  }
  return true;
}

DirectWrite write_blocks(int descriptor, std::string_view bytes) {
  // The kernel takes whole blocks from aligned memory only.
  const std::unique_ptr<char, Free> piece(static_cast<char*>(std::aligned_alloc(kBlock, kPiece)));
  DirectWrite done;
  const std::size_t end = bytes.size() / kBlock * kBlock;
  while (piece && done.written < end) {
    const std::size_t size = std::min(kPiece, end - done.written);
    std::memcpy(piece.get(), bytes.data() + done.written, size);
    if (!write_piece(descriptor, piece.get(), size)) {
      // A file system may take the flag and refuse the write: the usual way goes on from here.
      if (errno != EINVAL) done.error_number = errno;
      break;
    }
    done.written += size;
  }
  return done;
}

}  // namespace

DirectWrite write_past_cache(int descriptor, std::string_view bytes) {
  const int flags = ::fcntl(descriptor, F_GETFL);
  if (flags < 0 || ::fcntl(descriptor, F_SETFL, flags | O_DIRECT) != 0) return {};
  const off_t start = ::lseek(descriptor, 0, SEEK_CUR);
  DirectWrite done;
  if (start >= 0 && static_cast<std::size_t>(start) % kBlock == 0) {
    done = write_blocks(descriptor, bytes);
  }
  ::fcntl(descriptor, F_SETFL, flags);
  // A piece that was cut short by a refusal is written again, as a whole.
  if (start >= 0) ::lseek(descriptor, start + static_cast<off_t>(done.written), SEEK_SET);
  return done;
}

}  // namespace ensonify
