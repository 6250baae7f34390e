#include "scenario/text.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>

namespace ensonify {
namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

std::size_t digits_at(std::string_view text, std::size_t from) {
  std::size_t end = from;
  while (end < text.size() && is_digit(text[end])) ++end;
  return end - from;
}

// [digits][.digits][e[sign]digits] with a digit before the exponent.
bool is_decimal(std::string_view text) {
  const std::size_t whole = digits_at(text, 0);
  std::size_t i = whole;
  std::size_t fraction = 0;
  if (i < text.size() && text[i] == '.') {
    fraction = digits_at(text, i + 1);
    i += 1 + fraction;
  }
  if (whole + fraction == 0) return false;
  if (i < text.size() && lower(text[i]) == 'e') {
    ++i;
    if (i < text.size() && (text[i] == '+' || text[i] == '-')) ++i;
    const std::size_t exponent = digits_at(text, i);
    if (exponent == 0) return false;
    i += exponent;
  }
  return i == text.size();
}

bool only_of(std::string_view text, std::string_view letters) {
  return text.find_first_not_of(letters) == std::string_view::npos;
}

bool is_other_number(std::string_view unsigned_text) {
  for (const char* word : {".inf", ".nan", "inf", "nan", "infinity"}) {
    if (equals_ignoring_case(unsigned_text, word)) return true;
  }
  const std::string_view prefix = unsigned_text.substr(0, 2);
  if (prefix == "0x" || prefix == "0X") {
    return unsigned_text.size() > 2 && only_of(unsigned_text.substr(2), "0123456789abcdefABCDEF_");
  }
  if (prefix == "0b" || prefix == "0B") {
    return unsigned_text.size() > 2 && only_of(unsigned_text.substr(2), "01_");
  }
  return !unsigned_text.empty() && is_digit(unsigned_text[0]) &&
         only_of(unsigned_text, "0123456789_:.");
}

bool is_octal_looking(std::string_view unsigned_text) {
  if (unsigned_text.size() < 2 || unsigned_text[0] != '0') return false;
  if (lower(unsigned_text[1]) == 'o') {
    return unsigned_text.size() > 2 && only_of(unsigned_text.substr(2), "01234567_");
  }
  return is_digit(unsigned_text[1]) && only_of(unsigned_text, "0123456789_.eE+-");
}

// Length of the well-formed UTF-8 sequence at `i`; 0 where there is none (Unicode, table 3-7).
std::size_t utf8_length(std::string_view text, std::size_t i) {
  const auto byte = [&](std::size_t k) -> unsigned {
    return k < text.size() ? static_cast<unsigned char>(text[k]) : 0u;
  };
  const unsigned lead = byte(i);
  if (lead < 0x80) return 1;
  if (lead < 0xC2 || lead > 0xF4) return 0;
  const std::size_t length = lead < 0xE0 ? 2 : lead < 0xF0 ? 3 : 4;
  const unsigned low = lead == 0xE0 ? 0xA0 : lead == 0xF0 ? 0x90 : 0x80;
  const unsigned high = lead == 0xED ? 0x9F : lead == 0xF4 ? 0x8F : 0xBF;
  if (byte(i + 1) < low || byte(i + 1) > high) return 0;
  for (std::size_t k = 2; k < length; ++k) {
    if (byte(i + k) < 0x80 || byte(i + k) > 0xBF) return 0;
  }
  return length;
}

// Length of the unwanted character at `i`; 0 if the character is allowed.
std::size_t control_length(std::string_view text, std::size_t i) {
  const auto byte = static_cast<unsigned char>(text[i]);
  if (byte < 0x20 || byte == 0x7F) return 1;
  if (byte == 0xC2 && static_cast<unsigned char>(text[i + 1]) < 0xA0) return 2;
  const std::string_view three = text.substr(i, 3);
  if (three == "\xE2\x80\xA8" || three == "\xE2\x80\xA9" || three == "\xEF\xBB\xBF") return 3;
  return 0;
}

// Edit distance with swaps of neighboring characters (optimal string alignment).
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = lower(a[i - 1]) == lower(b[j - 1]) ? 0 : 1;
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + change});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        row[j] = std::min(row[j], before[j - 2] + 1);
      }
    }
    std::swap(before, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

}  // namespace

bool equals_ignoring_case(std::string_view text, std::string_view word) {
  return std::equal(text.begin(), text.end(), word.begin(), word.end(),
                    [](char a, char b) { return lower(a) == lower(b); });
}

PlainKind classify_plain(std::string_view text) {
  for (const char* word : {"true", "false"}) {
    if (equals_ignoring_case(text, word)) return PlainKind::boolean;
  }
  for (const char* word : {"yes", "no", "on", "off"}) {
    if (equals_ignoring_case(text, word)) return PlainKind::switch_word;
  }
  std::string_view rest = text;
  if (!rest.empty() && (rest[0] == '+' || rest[0] == '-')) rest.remove_prefix(1);
  if (is_octal_looking(rest)) return PlainKind::octal_looking;
  if (is_decimal(rest)) return PlainKind::number;
  if (is_other_number(rest)) return PlainKind::other_number;
  return PlainKind::text;
}

std::optional<std::size_t> first_invalid_utf8(std::string_view text) {
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = utf8_length(text, i);
    if (length == 0) return i;
    i += length;
  }
  return std::nullopt;
}

std::optional<std::size_t> first_control_character(std::string_view text,
                                                   std::string_view allowed) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (control_length(text, i) > 0 && allowed.find(text[i]) == std::string_view::npos) return i;
  }
  return std::nullopt;
}

std::string one_line(std::string_view text) {
  std::string line;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = utf8_length(text, i);
    const std::size_t escaped = length == 0 ? 1 : control_length(text, i);
    if (escaped == 0) {
      line += text.substr(i, length);
      i += length;
      continue;
    }
    for (const char c : text.substr(i, escaped)) {
      line += fmt::format("\\x{:02x}", static_cast<unsigned>(static_cast<unsigned char>(c)));
    }
    i += escaped;
  }
  return line;
}

std::string shown(std::string_view text) {
  constexpr std::size_t kMaxCharacters = 60;
  std::size_t end = 0;
  for (std::size_t count = 0; count < kMaxCharacters && end < text.size(); ++count) {
    end += std::max<std::size_t>(1, utf8_length(text, end));
  }
  return fmt::format("`{}{}`", one_line(text.substr(0, end)), end < text.size() ? "..." : "");
}

std::optional<std::string_view> nearest(std::string_view word,
                                        const std::vector<std::string_view>& candidates) {
  std::optional<std::string_view> best;
  std::size_t best_distance = std::max<std::size_t>(word.size() < 4 ? 1 : 2, word.size() / 3) + 1;
  for (const std::string_view candidate : candidates) {
    const std::size_t longer = std::max(word.size(), candidate.size());
    const std::size_t shorter = std::min(word.size(), candidate.size());
    if (longer - shorter >= best_distance) continue;
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < best_distance && distance < candidate.size()) {
      best = candidate;
      best_distance = distance;
    }
  }
  return best;
}

std::string hint(std::string_view word, const std::vector<std::string_view>& candidates) {
  const auto meant = nearest(word, candidates);
  return meant ? fmt::format(" (did you mean {}?)", *meant) : "";
}

std::string joined(const std::vector<std::string_view>& words) {
  constexpr std::size_t kMaxWords = 40;
  const auto end = words.begin() + static_cast<std::ptrdiff_t>(std::min(words.size(), kMaxWords));
  return fmt::format("{}{}", fmt::join(words.begin(), end, ", "),
                     end == words.end() ? "" : ", ...");
}

}  // namespace ensonify
