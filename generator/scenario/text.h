// Functions about text that the reader, the writer and the messages share.
//
//   PlainKind  classify_plain      what YAML 1.1 or 1.2 might take an unquoted scalar for
//   first_invalid_utf8             bytes that are not text
//   first_control_character        characters that have no place in a name or a path
//   shown  one_line                text in the form that messages use
//   nearest  hint                  the candidate that a mistyped word most likely meant
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ensonify {

enum class PlainKind {
  text,
  number,         // decimal, no superfluous leading zero
  octal_looking,  // 010, -010, 0o17: readers disagree about the value
  other_number,   // 0x1f, 0b1, 1_000, 1:30, .inf, .nan, inf, nan: numbers to some readers
  boolean,        // true, false in any case
  switch_word,    // yes, no, on, off in any case: booleans to some readers
};
PlainKind classify_plain(std::string_view text);

// Whether `text` is `word`, ignoring the case of ASCII letters.
bool equals_ignoring_case(std::string_view text, std::string_view word);

// Offset of the first byte that is not part of well-formed UTF-8.
std::optional<std::size_t> first_invalid_utf8(std::string_view text);

// Offset of the first C0 control that is not in `allowed`, DEL, C1 control, line or paragraph
// separator, or byte order mark. Needs well-formed UTF-8.
std::optional<std::size_t> first_control_character(std::string_view text, std::string_view allowed);

// Untrusted text in back quotes, with control characters escaped, cut after 60 characters.
std::string shown(std::string_view text);

// The text with control characters escaped, so that an error stays on one line.
std::string one_line(std::string_view text);

// The candidate with the least edit distance (a swap of neighbors counts one), if it is near
// enough: at most a third of the letters may be wrong, and two are always allowed in words of four
// letters or more.
std::optional<std::string_view> nearest(std::string_view word,
                                        const std::vector<std::string_view>& candidates);

// " (did you mean steel?)", or nothing if no candidate is near.
std::string hint(std::string_view word, const std::vector<std::string_view>& candidates);

// "a, b, c", cut after 40 words.
std::string joined(const std::vector<std::string_view>& words);

}  // namespace ensonify
