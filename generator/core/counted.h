// A number with its noun in the right form, for messages.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace ensonify {

// "1 ping", "12 pings": for nouns whose plural ends in s.
inline std::string counted(std::uint64_t number, std::string_view noun) {
  std::string text = std::to_string(number) + ' ';
  text += noun;
  if (number != 1) text += 's';
  return text;
}

}  // namespace ensonify
