#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "core/random.h"
#include "formats/json.h"
#include "scenario/text.h"
#include "sweep/axes.h"

namespace ensonify {
namespace {

double rounded(double value, int significant_digits) {
  const std::string text = fmt::format("{:.{}e}", value, significant_digits - 1);
  double back = value;
  std::from_chars(text.data(), text.data() + text.size(), back);
  return back;
}

constexpr int kRandomDigits = 6;

double log_between(double a, double b, double share) {
  const double value = std::exp(std::log(a) + share * (std::log(b) - std::log(a)));
  return std::clamp(rounded(value, kRandomDigits), a, b);
}

// Both ends are exact; value(share) gives the values between them.
template <class Value>
std::vector<double> spaced(double a, double b, int count, Value value) {
  std::vector<double> values = {a};
  for (int i = 1; i < count; ++i) {
    values.push_back(i + 1 == count ? b : value(static_cast<double>(i) / (count - 1)));
  }
  return values;
}

template <class Value>
std::vector<double> drawn(int count, std::uint64_t key, Value value) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i) {
    values.push_back(value(uniform(key, 0, static_cast<std::uint64_t>(i), 0)));
  }
  return values;
}

template <class T>
bool reads_as(std::string_view text, T& out) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  return error == std::errc{} && end == text.data() + text.size();
}

Json scalar_json(const Node& node) {
  const PlainKind kind = node.quoted ? PlainKind::text : classify_plain(node.text);
  if (kind == PlainKind::boolean) return equals_ignoring_case(node.text, "true");
  if (kind != PlainKind::number) return node.text;
  const std::string_view text =
      std::string_view(node.text).substr(node.text.starts_with('+') ? 1 : 0);
  if (std::int64_t whole = 0; reads_as(text, whole)) return whole;
  if (std::uint64_t whole = 0; reads_as(text, whole)) return whole;
  if (double number = 0; reads_as(text, number)) return number;
  return node.text;
}

Json json_tree(const Node& node) {
  if (node.kind == NodeKind::null) return nullptr;
  if (node.kind == NodeKind::scalar) return scalar_json(node);
  Json json = node.kind == NodeKind::map ? Json::object() : Json::array();
  for (std::size_t i = 0; i < node.items.size(); ++i) {
    if (node.kind == NodeKind::map) {
      json[node.keys[i].text] = json_tree(node.items[i]);
    } else {
      json.push_back(json_tree(node.items[i]));
    }
  }
  return json;
}

}  // namespace

std::vector<double> linear_values(double a, double b, int count) {
  return spaced(a, b, count,
                [&](double share) { return rounded(a * (1 - share) + b * share, 15); });
}

std::vector<double> log_values(double a, double b, int count) {
  return spaced(a, b, count, [&](double share) {
    return a < b ? log_between(a, b, share) : log_between(b, a, 1 - share);
  });
}

std::vector<double> uniform_values(double a, double b, int count, std::uint64_t key, bool whole) {
  return drawn(count, key, [&](double share) {
    const double value =
        whole ? std::floor(a + share * (b - a + 1)) : rounded(a + share * (b - a), kRandomDigits);
    return std::clamp(value, a, b);
  });
}

std::vector<double> log_uniform_values(double a, double b, int count, std::uint64_t key) {
  return drawn(count, key, [&](double share) { return log_between(a, b, share); });
}

std::string json_of_node(const Node& node) { return json_tree(node).dump(); }

std::string plain_text(const Node& node) {
  return node.kind == NodeKind::scalar ? one_line(node.text) : json_of_node(node);
}

}  // namespace ensonify
