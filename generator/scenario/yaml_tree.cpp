#include "scenario/yaml_tree.h"

#include <algorithm>
#include <exception>
#include <sstream>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/parser.h>

#include "scenario/text.h"
#include "scenario/yaml_text.h"

namespace ensonify {
namespace {

// Thrown through yaml-cpp when reading on makes no sense; the error has been reported already.
struct StopReading {};

struct Extent {
  std::size_t values = 1;
  std::size_t height = 1;
};

Extent extent_of(const Node& node) {
  Extent extent;
  for (const Node& item : node.items) {
    const Extent inner = extent_of(item);
    extent.values += inner.values;
    extent.height = std::max(extent.height, inner.height + 1);
  }
  return extent;
}

// Whether a null is written as a word here.
bool is_null_word(std::string_view rest) {
  if (rest.starts_with('~')) return true;
  const std::string_view word = rest.substr(0, 4);
  return word == "null" || word == "Null" || word == "NULL";
}

// A list or map that is being read.
struct Frame {
  Node node;
  YAML::anchor_t anchor = 0;
  std::optional<Key> key;  // of a map: the key of the next value
  bool drop_value = false;
  std::unordered_map<std::string, Place> seen;
};

class Builder : public YAML::EventHandler {
 public:
  Builder(const std::string& text, int source, std::string path, bool whole_text, Faults& faults)
      : text_(text),
        columns_(text),
        source_(source),
        path_(std::move(path)),
        whole_text_(whole_text),
        faults_(faults) {}

  std::optional<Node> root;
  std::optional<int> last_quoted;  // offset of the last scalar, if it was not plain

  Place place(const YAML::Mark& mark) const {
    if (!whole_text_) return {source_, 0, 0};
    if (mark.is_null()) return {source_, 1, 1};
    return {source_, mark.line + 1, columns_.column(mark.pos, mark.column)};
  }

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (documents_++ == 0) return;
    stop(place(mark), "a second document or stray text begins here; expected a single document");
  }
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    Node node;
    node.place = place(mark);
    if (!is_null_word(text_.substr(offset_of(mark)))) {
      const bool has_key = !stack_.empty() && stack_.back().key;
      node.place = has_key ? stack_.back().key->place : place_before(mark);
    }
    finish(std::move(node), anchor);
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    Node node;
    node.kind = NodeKind::scalar;
    node.quoted = tag == "!";
    node.place = place(mark);
    node.text = value;
    // yaml-cpp turns the escapes \_ and \N into bytes of Latin-1.
    if (first_invalid_utf8(value)) {
      stop(node.place, "this text has an escape that is not understood; expected the character");
    }
    last_quoted = node.quoted ? std::optional<int>(mark.pos) : std::nullopt;
    refuse_tag(tag, node.place);
    finish(std::move(node), anchor);
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto found = anchors_.find(anchor);
    if (found == anchors_.end()) stop(place(mark), "this alias refers to a value that contains it");
    const Extent extent = extent_of(found->second);
    count_copies(extent.values, place(mark));
    if (stack_.size() + extent.height > kMaxYamlDepth) stop_too_deep(place(mark));
    finish(found->second, 0);
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    begin(NodeKind::list, mark, tag, anchor);
  }
  void OnSequenceEnd() override { end(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    begin(NodeKind::map, mark, tag, anchor);
  }
  void OnMapEnd() override { end(); }

 private:
  void begin(NodeKind kind, const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor) {
    Frame frame;
    frame.node.kind = kind;
    frame.node.place = place(mark);
    frame.anchor = anchor;
    refuse_tag(tag, frame.node.place);
    if (stack_.size() >= kMaxYamlDepth) stop_too_deep(frame.node.place);
    if (stack_.empty()) check_top(frame.node);
    stack_.push_back(std::move(frame));
  }

  void end() {
    Frame frame = std::move(stack_.back());
    stack_.pop_back();
    finish(std::move(frame.node), frame.anchor);
  }

  void finish(Node node, YAML::anchor_t anchor) {
    if (stack_.empty()) check_top(node);
    if (++values_ > faults_.limits.values) {
      stop(node.place, fmt::format("more than {} values", faults_.limits.values));
    }
    if (anchor != 0) {
      count_copies(extent_of(node).values, node.place);
      anchors_[anchor] = node;
    }
    if (stack_.empty()) {
      root = std::move(node);
    } else if (stack_.back().node.kind == NodeKind::list) {
      stack_.back().node.items.push_back(std::move(node));
    } else if (!stack_.back().key) {
      take_key(stack_.back(), std::move(node));
    } else {
      take_value(stack_.back(), std::move(node));
    }
  }

  void take_key(Frame& frame, Node node) {
    frame.drop_value = node.kind != NodeKind::scalar;
    if (frame.drop_value) {
      frame.key = Key{"?", true, node.place};
      add_fault(faults_, node.place, path(), "a key is not text; expected text");
      return;
    }
    frame.key = Key{node.text, node.quoted, node.place};
    const auto [first, fresh] = frame.seen.emplace(node.text, node.place);
    if (fresh) return;
    frame.drop_value = true;
    std::string text = "the key is given twice";
    if (whole_text_) {
      text += fmt::format(", first at {}:{}", first->second.line, first->second.column);
    }
    add_fault(faults_, node.place, path(), text + "; expected once");
  }

  void take_value(Frame& frame, Node node) {
    if (!frame.drop_value) {
      frame.node.keys.push_back(std::move(*frame.key));
      frame.node.items.push_back(std::move(node));
    }
    frame.key.reset();
  }

  // The path of the next value.
  std::string path() const {
    std::string path = path_;
    for (const Frame& frame : stack_) {
      if (frame.node.kind == NodeKind::map && !frame.key) continue;
      if (!path.empty()) path += '.';
      path += frame.key ? frame.key->text : std::to_string(frame.node.items.size());
    }
    return path;
  }

  void check_top(const Node& node) {
    if (whole_text_ && node.kind != NodeKind::map) {
      stop(node.place, "the top level is not a map; expected keys such as `ensonify: 1`");
    }
  }

  void refuse_tag(const std::string& tag, Place at) {
    if (tag.empty() || tag == "?" || tag == "!") return;
    add_fault(faults_, at, path(),
              "YAML tags (!, !!) are not supported; expected a value without a tag");
  }

  void count_copies(std::size_t values, Place at) {
    copies_ += values;
    if (copies_ <= faults_.limits.copied_values) return;
    stop(at, fmt::format("anchors and aliases stand for more than {} values",
                         faults_.limits.copied_values));
  }

  [[noreturn]] void stop_too_deep(Place at) {
    stop(at, fmt::format("the text is nested more than {} levels deep", kMaxYamlDepth));
  }

  [[noreturn]] void stop(Place at, std::string text) {
    add_fault(faults_, at, path_, std::move(text));
    throw StopReading{};
  }

  std::size_t offset_of(const YAML::Mark& mark) const {
    return std::min(static_cast<std::size_t>(std::max(mark.pos, 0)), text_.size());
  }

  // An empty value has no place of its own, and yaml-cpp returns the place of whatever follows.
  // This is the place of the dash or comma before it.
  Place place_before(YAML::Mark mark) const {
    const std::size_t end = offset_of(mark);
    const std::size_t last = text_.substr(0, end).find_last_not_of(" \t\r\n");
    if (last == std::string_view::npos) return place(mark);
    const std::string_view between = text_.substr(last, end - last);
    const auto newlines = std::count(between.begin(), between.end(), '\n');
    if (newlines > 0) {
      const std::size_t newline = text_.substr(0, last).rfind('\n');
      mark.column = static_cast<int>(newline == std::string_view::npos ? last : last - newline - 1);
    } else {
      mark.column -= static_cast<int>(end - last);
    }
    mark.line -= static_cast<int>(newlines);
    mark.pos = static_cast<int>(last);
    return place(mark);
  }

  std::string_view text_;
  Columns columns_;
  int source_;
  std::string path_;
  bool whole_text_;
  Faults& faults_;
  int documents_ = 0;
  std::size_t values_ = 0;
  std::size_t copies_ = 0;
  std::vector<Frame> stack_;
  std::unordered_map<YAML::anchor_t, Node> anchors_;
};

std::optional<Node> read_clean(const std::string& text, int source, const std::string& path,
                               bool whole_text, Faults& faults) {
  Builder builder(text, source, path, whole_text, faults);
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    while (parser.HandleNextDocument(builder)) {
    }
  } catch (const StopReading&) {
    return std::nullopt;
  } catch (const YAML::Exception& error) {
    const std::string trouble =
        whole_text ? indentation_trouble(text, error.mark.line) : std::string();
    add_fault(faults, builder.place(error.mark), path,
              "not valid YAML: " + (trouble.empty() ? error.msg : trouble));
    return std::nullopt;
  } catch (const std::exception& error) {
    add_fault(faults, {source, whole_text ? 1 : 0, 1}, path,
              std::string("cannot be read as YAML: ") + error.what());
    return std::nullopt;
  }
  if (builder.last_quoted) {
    const auto offset = static_cast<std::size_t>(*builder.last_quoted);
    if (is_unterminated(text, offset)) {
      const Place at = whole_text ? place_at_offset(source, text, offset) : Place{source, 0, 0};
      add_fault(faults, at, path, "not valid YAML: the quote that opens here is never closed");
      return std::nullopt;
    }
  }
  return std::move(builder.root);
}

}  // namespace

std::optional<Node> read_yaml_map(const std::string& text, int source, Faults& faults) {
  const std::string_view mark = "\xEF\xBB\xBF";
  const std::string body = text.starts_with(mark) ? text.substr(mark.size()) : text;
  if (!is_clean_text(body, source, "", true, faults)) return std::nullopt;
  const std::size_t before = faults.found();
  std::optional<Node> root = read_clean(body, source, "", true, faults);
  if (!root && faults.found() == before) {
    add_fault(faults, {source, 1, 1}, "",
              "the text is empty; expected a map of keys that begins with `ensonify: 1`");
  }
  return root;
}

std::optional<Node> read_yaml_value(const std::string& text, int source, const std::string& path,
                                    Faults& faults) {
  if (!is_clean_text(text, source, path, false, faults)) return std::nullopt;
  const std::size_t before = faults.found();
  std::optional<Node> root = read_clean(text, source, path, false, faults);
  if (!root && faults.found() == before) {
    root.emplace();
    root->place = {source, 0, 0};
  }
  return root;
}

const Node* find(const Node& map, std::string_view key) {
  for (std::size_t i = 0; i < map.keys.size(); ++i) {
    if (map.keys[i].text == key) return &map.items[i];
  }
  return nullptr;
}

Node* find(Node& map, std::string_view key) {
  return const_cast<Node*>(find(std::as_const(map), key));
}

Node without(const Node& map, std::string_view key) {
  Node rest = map;
  for (std::size_t i = rest.keys.size(); i-- > 0;) {
    if (rest.keys[i].text != key) continue;
    rest.keys.erase(rest.keys.begin() + static_cast<std::ptrdiff_t>(i));
    rest.items.erase(rest.items.begin() + static_cast<std::ptrdiff_t>(i));
  }
  return rest;
}

std::size_t values_in(const Node& node) {
  std::size_t count = 1;
  for (const Node& item : node.items) count += values_in(item);
  return count;
}

}  // namespace ensonify
