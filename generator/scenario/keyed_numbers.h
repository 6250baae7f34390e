// The path of a node in a scenario, and the random numbers that it keys. Private to scenario/.
//
//   Way  step  alternative      from the root to a node
//   KeyedNumbers  DrawExtreme   values of distributions, or their extremes
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace ensonify {

// The key path of a node and the key of its random numbers.
struct Way {
  std::uint64_t key = 0;
  std::string path;   // as in messages: items of lists by index
  std::string named;  // items of lists by name, if they have one
};

Way step(const Way& way, std::string_view segment, std::string_view name);
Way step(const Way& way, std::string_view segment);
// The path into an alternative of a distribution, which keys other random numbers than the
// distribution itself but keeps its named path.
Way alternative(const Way& way, std::size_t index);

// Which end of every distribution, and which of the alternatives (draw_extremes).
struct DrawExtreme {
  bool is_upper = false;
  std::size_t variant = 0;
};

struct KeyedNumbers {
  std::uint64_t key = 0;
  const DrawExtreme* extreme = nullptr;  // not null: its end of each distribution

  double uniform_of(const Way& way) const;  // from 0 to 1
  // Of a valid distribution of this kind (distribution.h).
  double drawn(std::string_view kind, const std::array<double, 2>& given, const Way& way) const;
};

}  // namespace ensonify
