// DEFLATE, as pictures want it: fast.
//
//   append_zlib   a whole stream in zlib's format (RFC 1950), which any inflate reads
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace ensonify {

// What the bytes are like. runs: masks and labels, by zlib, which looks for runs only. noise:
// speckle, by libdeflate, which is the faster one there and takes 5 cycles for each byte of a run.
enum class Content { runs, noise };

// Throws std::bad_alloc.
void append_zlib(std::span<const std::uint8_t> bytes, Content content, std::string& out);

}  // namespace ensonify
