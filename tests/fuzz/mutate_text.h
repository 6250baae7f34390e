// A mutator of text: libFuzzer's own changes bytes, which nearly always breaks the syntax, so that
// little behind the first check is reached. Half of the inputs come from here: a word becomes
// another word of the text or a number that hurts, a line goes, is doubled or stands elsewhere.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <random>
#include <string>
#include <string_view>
#include <vector>

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

namespace ensonify::test {

constexpr std::array kHurts = {
    "0",
    "-1",
    "1",
    "2",
    "0.5",
    "1e-300",
    "1e300",
    "-0.0",
    ".nan",
    ".inf",
    "nan",
    "90",
    "360",
    "2147483648",
    "18446744073709551616",
    "true",
    "null",
    "~",
    "''",
    "[]",
    "{}",
    "65536",
    "{uniform: [0.1, 2]}",
    "[1, 2, 3]",
    "{choice: [1, 2]}",
    "&a 1",
    "*a",
};

struct Span {
  std::size_t first = 0, size = 0;
};

inline std::vector<Span> words_of(std::string_view text) {
  constexpr std::string_view kLetters =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.+-/";
  std::vector<Span> words;
  for (std::size_t at = text.find_first_of(kLetters); at != text.npos;) {
    const std::size_t end = std::min(text.find_first_not_of(kLetters, at), text.size());
    words.push_back({at, end - at});
    at = text.find_first_of(kLetters, end);
  }
  return words;
}

inline std::vector<Span> lines_of(std::string_view text) {
  std::vector<Span> lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size() - 1) + 1;
    lines.push_back({at, end - at});
    at = end;
  }
  return lines;
}

inline std::string mutated_text(const std::string& text, std::minstd_rand& random) {
  const auto any = [&](const auto& of) { return of[random() % of.size()]; };
  const std::vector<Span> words = words_of(text), lines = lines_of(text);
  if (words.empty() || lines.empty()) return text;
  const Span word = any(words), line = any(lines);
  const std::string other = text.substr(any(lines).first);
  std::string made = text;
  switch (random() % 6) {
    case 0: {
      const Span source = any(words);
      return made.replace(word.first, word.size, text, source.first, source.size);
    }
    case 1:
    case 2:
      return made.replace(word.first, word.size, any(kHurts));
    case 3:
      return made.erase(line.first, line.size);
    case 4:
      return made.insert(line.first, other.substr(0, other.find('\n') + 1));
    default:
      return made.insert(line.first, "  ");
  }
}

}  // namespace ensonify::test

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t most, unsigned seed) {
  std::minstd_rand random(seed);
  if (size == 0 || random() % 2 == 0) return LLVMFuzzerMutate(data, size, most);
  std::string text(reinterpret_cast<const char*>(data), size);
  for (auto left = 1 + random() % 3; left > 0; --left) {
    text = ensonify::test::mutated_text(text, random);
  }
  const std::size_t kept = std::min(text.size(), most);
  std::memcpy(data, text.data(), kept);
  return kept;
}
