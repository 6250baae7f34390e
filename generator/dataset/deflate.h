// DEFLATE, as pictures want it: fast.
//
//   append_zlib   a whole stream in zlib's format (RFC 1950), which any inflate reads
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace ensonify {

// By libdeflate. Throws std::bad_alloc.
void append_zlib(std::span<const std::uint8_t> bytes, std::string& out);

}  // namespace ensonify
