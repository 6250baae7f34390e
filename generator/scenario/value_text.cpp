#include "scenario/value_text.h"

#include <fmt/format.h>

#include "scenario/text.h"

namespace ensonify {
namespace {

// In double quotes, with escapes for characters that a text file should not contain.
std::string in_double_quotes(std::string_view text) {
  std::string out = "\"";
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const std::string_view three = text.substr(i, 3);
    if (byte < 0x20 || byte == 0x7F) {
      out += fmt::format("\\x{:02x}", static_cast<unsigned>(byte));
    } else if (byte == 0xC2 && i + 1 < text.size() &&
               static_cast<unsigned char>(text[i + 1]) < 0xA0) {
      out += fmt::format("\\x{:02x}", static_cast<unsigned>(static_cast<unsigned char>(text[++i])));
    } else if (three == "\xE2\x80\xA8" || three == "\xE2\x80\xA9" || three == "\xEF\xBB\xBF") {
      out += three == "\xE2\x80\xA8" ? "\\u2028" : three == "\xE2\x80\xA9" ? "\\u2029" : "\\ufeff";
      i += 2;
    } else {
      if (byte == '"' || byte == '\\') out += '\\';
      out += text[i];
    }
  }
  return out + "\"";
}

}  // namespace

std::string number(double value) {
  std::string text = fmt::format("{}", value);
  const std::size_t exponent = text.find('e');
  if (exponent != std::string::npos && text.find('.') == std::string::npos) {
    text.insert(exponent, ".0");
  }
  return text;
}

std::string quoted_if_needed(const std::string& text) {
  constexpr std::string_view kLetters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_";
  constexpr std::string_view kOthers = "0123456789.-/";
  const auto one_of = [](char c, std::string_view set) {
    return set.find(c) != std::string_view::npos;
  };
  bool plain = !text.empty() && one_of(text[0], kLetters);
  for (const char c : text) plain = plain && (one_of(c, kLetters) || one_of(c, kOthers));
  for (const char* word : {"null", "y", "n"}) plain = plain && !equals_ignoring_case(text, word);
  if (plain && classify_plain(text) == PlainKind::text) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

std::string scalar_text(const std::string& text, bool in_quotes) {
  if (in_quotes || text.empty()) return in_double_quotes(text);
  if (classify_plain(text) != PlainKind::text) return text;
  const std::string plain = quoted_if_needed(text);
  return plain.starts_with('"') ? in_double_quotes(text) : plain;
}

std::string flow_text(const Node& node) {
  if (node.kind == NodeKind::null) return "~";
  if (node.kind == NodeKind::scalar) return scalar_text(node.text, node.quoted);
  const bool map = node.kind == NodeKind::map;
  std::string text;
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    if (i > 0) text += ", ";
    if (map) text += scalar_text(node.keys[i].text, node.keys[i].quoted) + ": ";
    text += flow_text(node.items[i]);
  }
  return map ? "{" + text + "}" : "[" + text + "]";
}

}  // namespace ensonify
