// Fast DEFLATE for images, by ISA-L.
//
//   append_zlib   a whole stream in zlib's format (RFC 1950), which any inflate reads
//   inflate_zlib  the inverse, of any writer
//   crc32_of      the checksum of PNG and MCAP
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace ensonify {

// The same bytes give the same stream on one kind of processor. At most 4 GB; throws
// std::bad_alloc.
void append_zlib(std::span<const std::uint8_t> bytes, std::string& out);

// None: not a stream of `size` bytes. The caller limits `size`, which is allocated first.
std::optional<std::string> inflate_zlib(std::string_view stream, std::uint64_t size);

// Continues the checksum of the bytes before; 0: there are none.
std::uint32_t crc32_of(std::string_view bytes, std::uint32_t before = 0);

}  // namespace ensonify
