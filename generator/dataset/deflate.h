// DEFLATE for the bytes that pictures are made of: long runs of one value, or speckle. Only such
// runs are searched for, the rest goes through Huffman codes alone. That is two to three times as
// fast as zlib's Z_RLE, and sizes are within 4 % of its.
//
//   append_zlib   a whole stream in zlib's format (RFC 1950), which any inflate reads
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace ensonify {

void append_zlib(std::span<const std::uint8_t> bytes, std::string& out);

}  // namespace ensonify
