#include "formats/deflate.h"

#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "catch.h"

using namespace ensonify;

namespace {

using Bytes = std::vector<std::uint8_t>;

std::string compressed(const Bytes& bytes, Content content) {
  std::string out;
  append_zlib(bytes, content, out);
  return out;
}

// By zlib's inflate, which checks codes and checksum and must come to its end.
Bytes inflated(const std::string& stream, std::size_t size) {
  Bytes bytes(size + 1);
  uLongf got = bytes.size();
  uLong taken = stream.size();
  const auto* source = static_cast<const Bytef*>(static_cast<const void*>(stream.data()));
  REQUIRE(uncompress2(bytes.data(), &got, source, &taken) == Z_OK);
  CHECK(taken == stream.size());
  bytes.resize(got);
  return bytes;
}

void check(const Bytes& bytes) {
  for (const Content content : {Content::runs, Content::noise}) {
    CHECK((inflated(compressed(bytes, content), bytes.size()) == bytes));
  }
}

Bytes noise(std::size_t size, std::uint32_t seed) {
  std::mt19937 random(seed);
  Bytes bytes(size);
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
  return bytes;
}

}  // namespace

// Protects what comes back: every length of a run, as the symbols of lengths and the remainders of
// long runs differ, and blocks' ends in the middle of one.
TEST_CASE("runs of all lengths inflate to what they were") {
  for (std::size_t length = 0; length < 800; ++length) {
    Bytes bytes(length, 7);
    bytes.push_back(8);
    check(bytes);
  }
  for (const std::size_t size : {65535u, 65536u, 65537u, 65538u, 65540u, 131072u, 400000u}) {
    check(Bytes(size, 0));
    check(Bytes(size, 255));
  }
}

// Protects noise, alone and among runs, in several blocks.
TEST_CASE("noise inflates to what it was") {
  for (const std::size_t size : {0u, 1u, 2u, 3u, 65536u, 200001u}) check(noise(size, 1));
  Bytes bytes = noise(300000, 2);
  std::mt19937 random(3);
  for (std::size_t at = 0; at + 700 < bytes.size(); at += random() % 900) {
    std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), random() % 700, bytes[at]);
  }
  check(bytes);
}

// Protects the limit of 15 bits to a code: with these counts the best code has 19, since each is
// more than the two before it together.
TEST_CASE("very uneven counts of bytes inflate to what they were") {
  Bytes bytes;
  std::size_t count = 1, next = 2;
  for (std::uint8_t value = 0; value < 19; ++value) {
    bytes.insert(bytes.end(), count, value);
    count = std::exchange(next, count + next + 1);
  }
  REQUIRE(bytes.size() == 28635);
  Bytes mixed;  // in steps of the golden section, so that no value stands four times in a row
  for (std::size_t i = 0; i < bytes.size(); ++i) mixed.push_back(bytes[i * 17696 % bytes.size()]);
  check(mixed);
}

// Protects sizes: noise costs its codes' lengths alone, runs nearly nothing.
TEST_CASE("noise hardly grows and runs shrink") {
  CHECK(compressed(noise(1000000, 5), Content::noise).size() < 1005000);
  CHECK(compressed(Bytes(1000000, 3), Content::runs).size() < 5000);
}

// Protects callers that put the stream behind other bytes.
TEST_CASE("a stream goes behind what is there") {
  std::string out = "head";
  append_zlib(Bytes(10, 1), Content::runs, out);
  append_zlib(Bytes(10, 2), Content::noise, out);
  CHECK(out == "head" + compressed(Bytes(10, 1), Content::runs) +
                   compressed(Bytes(10, 2), Content::noise));
}

// Protects the promise of equal bytes: nothing that was compressed before may show (one library
// that was tried failed here).
TEST_CASE("the same bytes deflate to the same stream, whatever came before") {
  Bytes bytes;
  for (std::size_t i = 0; i < 63; ++i) bytes.push_back("\0\0\1\2\0\1\0\0\1\0\0"[i * i % 11]);
  for (const Content content : {Content::runs, Content::noise}) {
    const std::string once = compressed(bytes, content);
    for (int i = 0; i < 300; ++i) {
      compressed(noise(static_cast<std::size_t>(i), static_cast<std::uint32_t>(i)), content);
      REQUIRE(compressed(bytes, content) == once);
    }
  }
}
