#include "formats/deflate.h"

#include <zlib.h>

#include <algorithm>
#include <barrier>
#include <cstdint>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "catch.h"

using namespace ensonify;

namespace {

using Bytes = std::vector<std::uint8_t>;

std::string compressed(const Bytes& bytes) {
  std::string out;
  append_zlib(bytes, out);
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

void check(const Bytes& bytes) { CHECK((inflated(compressed(bytes), bytes.size()) == bytes)); }

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
  CHECK(compressed(noise(1000000, 5)).size() < 1005000);
  CHECK(compressed(Bytes(1000000, 3)).size() < 5000);
}

// Protects callers that put the stream behind other bytes.
TEST_CASE("a stream goes behind what is there") {
  std::string out = "head";
  append_zlib(Bytes(10, 1), out);
  append_zlib(Bytes(10, 2), out);
  CHECK(out == "head" + compressed(Bytes(10, 1)) + compressed(Bytes(10, 2)));
}

// Protects the promise of equal bytes: neither what was compressed before nor what stands beside
// the bytes in memory may show. ISA-L fails here unless its tables are cleared.
TEST_CASE("the same bytes deflate to the same stream, whatever came before") {
  Bytes pattern;
  for (std::size_t i = 0; i < 63; ++i) pattern.push_back("\0\0\1\2\0\1\0\0\1\0\0"[i * i % 11]);
  Bytes speckle = noise(70000, 9);
  for (auto& byte : speckle) byte &= 15;
  for (const Bytes& bytes : {pattern, speckle}) {
    const std::string once = compressed(bytes);
    for (std::uint32_t i = 0; i < 300; ++i) {
      compressed(noise(i, i));
      Bytes among = noise(i % 64 + bytes.size() + 300, i);
      std::copy(bytes.begin(), bytes.end(), among.begin() + i % 64);
      std::string again;
      append_zlib(std::span(among).subspan(i % 64, bytes.size()), again);
      REQUIRE(again == once);
    }
  }
}

// Protects the promise of equal bytes across threads and processes: where in memory a thread's
// tables lie may not show. ISA-L 2.30 lets it show for one address in sixty and input.
TEST_CASE("the same bytes deflate to the same stream in every thread") {
  constexpr int kThreads = 200;
  std::vector<Bytes> inputs(8);
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    for (const std::uint8_t byte : noise(60 + 40 * k, static_cast<std::uint32_t>(k))) {
      inputs[k].push_back(byte % 3 == 0 ? byte & 1 : 0);
    }
  }
  std::vector<std::vector<std::string>> streams(kThreads);
  std::barrier all_have_tables(kThreads);  // so that no two lie at one place
  std::vector<std::thread> threads;
  for (auto& own : streams) {
    threads.emplace_back([&] {
      for (const Bytes& bytes : inputs) own.push_back(compressed(bytes));
      all_have_tables.arrive_and_wait();
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const auto& own : streams) CHECK(own == streams[0]);
}
