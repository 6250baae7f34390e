// Random numbers without state: a number is a function of its key and counter, so that results do
// not depend on the order of calls or on threads.
//
//   Stream          the purpose of a draw
//   SequenceDraw    a sequence may be sampled several times
//   stream_key      64-bit key from (seed, stream, sequence)
//   name_key        64-bit key from a name
//   philox4x32_10   the generator
//   complex_normal  circular complex normal, E|xi|^2 = 1
//   uniform         in (0, 1)
#pragma once

#include <cmath>
#include <cstdint>
#include <string_view>

#include "core/compile_targets.h"
#include "core/units.h"

namespace ensonify {

// The values are part of every data set's identity, so they must never change.
enum class Stream : std::uint32_t {
  speckle = 1,
  noise = 2,
  split = 3,
  volume = 4,   // echoes of volumes
  terrain = 5,  // procedural seabed
  motion = 6,   // wave motion of paths
  world = 7,    // sampled values of a scenario
  place = 8,    // positions of objects
  bubbles = 9,  // procedural volumes
  array = 12,   // errors of elements
  sweep = 13,   // random values of a sweep's axes
  bounces = 14,  // directions in which surfaces scatter sound to others
  electronics = 15,  // effects of the electronics
  dropped = 16,  // frames that a recorder drops
  detector = 18,  // noise of the detector
  navigation = 21,  // errors of navigation sensors
};

struct Philox4 {
  std::uint32_t v[4];
};

// Philox 4x32 with 10 rounds; Salmon et al., "Parallel random numbers: as easy as 1, 2, 3" (2011).
ENSONIFY_HD inline Philox4 philox4x32_10(Philox4 counter, std::uint64_t key) {
  std::uint32_t k0 = static_cast<std::uint32_t>(key);
  std::uint32_t k1 = static_cast<std::uint32_t>(key >> 32);
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t p0 = std::uint64_t{0xD2511F53u} * counter.v[0];
    const std::uint64_t p1 = std::uint64_t{0xCD9E8D57u} * counter.v[2];
    counter = {
        {static_cast<std::uint32_t>(p1 >> 32) ^ counter.v[1] ^ k0, static_cast<std::uint32_t>(p1),
         static_cast<std::uint32_t>(p0 >> 32) ^ counter.v[3] ^ k1, static_cast<std::uint32_t>(p0)}};
    k0 += 0x9E3779B9u;
    k1 += 0xBB67AE85u;
  }
  return counter;
}

// Finalizer of splitmix64: a bijection of 64-bit words in which every input bit reaches every
// output bit.
ENSONIFY_HD inline std::uint64_t mix64(std::uint64_t z) {
  z += 0x9E3779B97F4A7C15u;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

ENSONIFY_HD inline std::uint64_t stream_key(std::uint64_t seed, Stream stream,
                                            std::uint32_t sequence) {
  const auto word = (std::uint64_t{static_cast<std::uint32_t>(stream)} << 32) | sequence;
  return mix64(mix64(seed) ^ mix64(~word));
}

// A sample of a sequence's world. The first one is redraw 0; another one is made if objects find no
// place.
struct SequenceDraw {
  constexpr SequenceDraw(std::uint32_t sequence_number = 0, std::uint32_t redraw_number = 0)
      : sequence(sequence_number), redraw(redraw_number) {}
  std::uint32_t sequence, redraw;
};

inline std::uint64_t stream_key(std::uint64_t seed, Stream stream, SequenceDraw draw) {
  const std::uint64_t key = stream_key(seed, stream, draw.sequence);
  return draw.redraw == 0 ? key : mix64(key ^ mix64(draw.redraw));
}

// FNV-1a over the bytes, mixed.
inline std::uint64_t name_key(std::string_view name) {
  std::uint64_t hash = 0xCBF29CE484222325u;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3u;
  return mix64(hash);
}

// Counter of the contract: (ping, item, draw); the item is a scatterer's key or a sample's index.
ENSONIFY_HD inline Philox4 random_words(std::uint64_t key, std::uint32_t ping, std::uint64_t item,
                                        std::uint32_t draw) {
  return philox4x32_10(
      {{ping, static_cast<std::uint32_t>(item), static_cast<std::uint32_t>(item >> 32), draw}},
      key);
}

ENSONIFY_HD inline double uniform_from_word(std::uint32_t word) {
  return (word + 0.5) * (1.0 / 4294967296.0);
}

ENSONIFY_HD inline double uniform(std::uint64_t key, std::uint32_t ping, std::uint64_t item,
                                  std::uint32_t draw) {
  return uniform_from_word(random_words(key, ping, item, draw).v[0]);
}

struct ComplexDraw {
  double re, im;
};

// Circular complex normal with E|xi|^2 = 1 (each part has variance 1/2), by Box-Muller. The
// tail ends at |xi| = 4.78, which a true normal passes once in 1e10 draws.
ENSONIFY_HD inline ComplexDraw complex_normal(std::uint64_t key, std::uint32_t ping,
                                              std::uint64_t item, std::uint32_t draw) {
  const Philox4 words = random_words(key, ping, item, draw);
  const double radius = std::sqrt(-std::log(uniform_from_word(words.v[0])));
  const double angle = 2.0 * kPi * uniform_from_word(words.v[1]);
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

}  // namespace ensonify
