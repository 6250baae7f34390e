// DEFLATE, as pictures want it: fast.
//
//   append_zlib   a whole stream in zlib's format (RFC 1950), which any inflate reads
//   crc32_of      the checksum of PNG and MCAP
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace ensonify {

// What the bytes are like. runs: masks and labels, by zlib, which looks for runs only. noise:
// speckle, by libdeflate, which is the faster one there and takes 5 cycles for each byte of a run.
enum class Content { runs, noise };

// Throws std::bad_alloc.
void append_zlib(std::span<const std::uint8_t> bytes, Content content, std::string& out);

// Goes on from the checksum of the bytes before; 0: there are none.
std::uint32_t crc32_of(std::string_view bytes, std::uint32_t before = 0);

}  // namespace ensonify
