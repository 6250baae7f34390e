#include "formats/json_slices.h"

#include <algorithm>

namespace ensonify {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";

void skip_blanks(std::string_view& text) {
  text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
}

bool take(std::string_view& text, char c) {
  skip_blanks(text);
  if (!text.starts_with(c)) return false;
  text.remove_prefix(1);
  return true;
}

// One past the closing quote of a string that begins the text; 0 where there is none.
std::size_t string_end(std::string_view text) {
  for (std::size_t i = 1; (i = text.find('"', i)) != text.npos; ++i) {
    // An even number of backslashes escape each other and not the quote.
    const std::size_t before = text.find_last_not_of('\\', i - 1);
    if ((i - 1 - before) % 2 == 0) return i + 1;
  }
  return 0;
}

// One past the bracket that closes the first one; 0 where none does.
std::size_t bracket_end(std::string_view text) {
  int depth = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '"') {
      const std::size_t length = string_end(text.substr(i));
      if (length == 0) return 0;
      i += length - 1;
    } else if (c == '{' || c == '[') {
      ++depth;
    } else if ((c == '}' || c == ']') && --depth == 0) {
      return i + 1;
    }
  }
  return 0;
}

// The value that begins the text, which then begins behind it; empty where there is none.
std::string_view take_value(std::string_view& text) {
  skip_blanks(text);
  if (text.empty()) return {};
  std::size_t length = 0;
  if (text[0] == '"') {
    length = string_end(text);
  } else if (text[0] == '{' || text[0] == '[') {
    length = bracket_end(text);
  } else {
    length = std::min(text.find_first_of(" \t\r\n,:{}[]\""), text.size());
  }
  const std::string_view value = text.substr(0, length);
  text.remove_prefix(length);
  return value;
}

// item() for each of those between `open` and `close`, which ends the text.
template <class Item>
bool for_each_item(std::string_view text, char open, char close, Item&& item) {
  if (!take(text, open)) return false;
  if (!take(text, close)) {
    do {
      if (!item(text)) return false;
    } while (take(text, ','));
    if (!take(text, close)) return false;
  }
  skip_blanks(text);
  return text.empty();
}

}  // namespace

std::string_view JsonMembers::at(std::string_view key) const {
  for (const auto& [name, value] : all) {
    if (name == key) return value;
  }
  return {};
}

std::optional<JsonMembers> json_members(std::string_view object) {
  JsonMembers members;
  const bool whole = for_each_item(object, '{', '}', [&](std::string_view& text) {
    const std::string_view key = take_value(text);
    if (key.size() < 2 || key[0] != '"' || !take(text, ':')) return false;
    const std::string_view value = take_value(text);
    members.all.emplace_back(key.substr(1, key.size() - 2), value);
    return !value.empty();
  });
  if (!whole) return std::nullopt;
  return members;
}

std::optional<std::vector<std::string_view>> json_elements(std::string_view array) {
  std::vector<std::string_view> elements;
  const bool whole = for_each_item(array, '[', ']', [&](std::string_view& text) {
    elements.push_back(take_value(text));
    return !elements.back().empty();
  });
  if (!whole) return std::nullopt;
  return elements;
}

}  // namespace ensonify
