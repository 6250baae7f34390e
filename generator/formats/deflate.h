// Fast DEFLATE for images, by ISA-L.
//
//   append_zlib   a whole stream in zlib's format (RFC 1950), which any inflate reads
//   crc32_of      the checksum of PNG and MCAP
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace ensonify {

// The same bytes give the same stream on one kind of processor. At most 4 GB; throws
// std::bad_alloc.
void append_zlib(std::span<const std::uint8_t> bytes, std::string& out);

// Continues the checksum of the bytes before; 0: there are none.
std::uint32_t crc32_of(std::string_view bytes, std::uint32_t before = 0);

}  // namespace ensonify
