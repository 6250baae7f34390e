// Rows become columns, four by four.
//
//   Four  four_at   four floats that lie next to each other, or of small integers
//   transpose       of four of them, or of a block
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace ensonify {

// A vector of GCC and clang: operators work on each of the four.
using Four = float __attribute__((vector_size(4 * sizeof(float))));

inline Four four_at(const float* at) {
  Four four;
  std::memcpy(&four, at, sizeof four);
  return four;
}

inline Four four_at(const std::uint16_t* at) {
  using Words = std::uint16_t __attribute__((vector_size(4 * sizeof(std::uint16_t))));
  Words words;
  std::memcpy(&words, at, sizeof words);
  return __builtin_convertvector(words, Four);
}

inline void transpose(Four (&v)[4]) {
  const Four low_ab = __builtin_shufflevector(v[0], v[1], 0, 4, 1, 5);
  const Four low_cd = __builtin_shufflevector(v[2], v[3], 0, 4, 1, 5);
  const Four high_ab = __builtin_shufflevector(v[0], v[1], 2, 6, 3, 7);
  const Four high_cd = __builtin_shufflevector(v[2], v[3], 2, 6, 3, 7);
  v[0] = __builtin_shufflevector(low_ab, low_cd, 0, 1, 4, 5);
  v[1] = __builtin_shufflevector(low_ab, low_cd, 2, 3, 6, 7);
  v[2] = __builtin_shufflevector(high_ab, high_cd, 0, 1, 4, 5);
  v[3] = __builtin_shufflevector(high_ab, high_cd, 2, 3, 6, 7);
}

// to[j * to_stride + i] = from[i * from_stride + j] for i below `rows` and j below `columns`.
inline void transpose(const float* from, std::size_t from_stride, std::size_t rows,
                      std::size_t columns, float* to, std::size_t to_stride) {
  const std::size_t whole_rows = rows / 4 * 4, whole_columns = columns / 4 * 4;
  for (std::size_t j = 0; j < whole_columns; j += 4) {
    for (std::size_t i = 0; i < whole_rows; i += 4) {
      const float* block = from + i * from_stride + j;
      Four four[4] = {four_at(block), four_at(block + from_stride),
                      four_at(block + 2 * from_stride), four_at(block + 3 * from_stride)};
      transpose(four);
      for (std::size_t k = 0; k < 4; ++k) {
        std::memcpy(to + (j + k) * to_stride + i, &four[k], sizeof four[k]);
      }
    }
  }
  for (std::size_t j = 0; j < columns; ++j) {
    for (std::size_t i = j < whole_columns ? whole_rows : 0; i < rows; ++i) {
      to[j * to_stride + i] = from[i * from_stride + j];
    }
  }
}

}  // namespace ensonify
