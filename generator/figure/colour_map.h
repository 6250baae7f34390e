// Colours of values and of ids.
//
//   colour_maps  find_colour_map   maps of even lightness, dark to light
//   colour_at                      colour of a value between 0 and 1
//   id_colour                      colour of an instance or class
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

namespace ensonify {

struct Rgb {
  std::uint8_t red = 0, green = 0, blue = 0;
  friend bool operator==(const Rgb&, const Rgb&) = default;
};

inline constexpr Rgb kWhite{255, 255, 255};
inline constexpr Rgb kNoIdColour{0xe4, 0xe4, 0xe4};

struct ColourMap {
  const char* name;
  std::array<std::uint32_t, 33> stops;  // 0xrrggbb, evenly spaced
};

std::span<const ColourMap> colour_maps();
// Null where there is none.
const ColourMap* find_colour_map(std::string_view name);

// Below 0 and above 1 the map's ends.
Rgb colour_at(const ColourMap& map, double value);

// The same for the same id always; 0 is kNoIdColour.
Rgb id_colour(std::uint32_t id);

}  // namespace ensonify
