#include "sweep/node_json.h"

#include <charconv>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string_view>

#include "scenario/text.h"

namespace ensonify {
namespace {

using Json = nlohmann::ordered_json;

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

std::string json_of_node(const Node& node) { return json_tree(node).dump(); }

std::string plain_text(const Node& node) {
  return node.kind == NodeKind::scalar ? one_line(node.text) : json_of_node(node);
}

}  // namespace ensonify
