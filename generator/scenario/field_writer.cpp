#include "scenario/field_writer.h"

#include <fmt/format.h>

#include "scenario/drawn_sections.h"
#include "scenario/value_text.h"

namespace ensonify {

namespace {

std::string leaf_text(const NumberLeaf& leaf) { return number(leaf.out); }
std::string leaf_text(const NumbersLeaf& leaf) {
  std::string text;
  for (const double value : leaf.out) text += (text.empty() ? "" : ", ") + number(value);
  return "[" + text + "]";
}
std::string leaf_text(const IntegerLeaf& leaf) { return std::to_string(leaf.out); }
std::string leaf_text(const SeedLeaf& leaf) { return std::to_string(leaf.out); }
std::string leaf_text(const BooleanLeaf& leaf) { return leaf.out ? "true" : "false"; }
std::string leaf_text(const TextLeaf& leaf) { return quoted_if_needed(leaf.out); }
std::string leaf_text(const MaterialLeaf& leaf) { return quoted_if_needed(leaf.out); }
std::string leaf_text(const FileLeaf&) { return ""; }  // the name of the file is added later
std::string leaf_text(const WordLeaf& leaf) { return std::string(leaf.words[leaf.index]); }

}  // namespace

std::string leaf_text(const Leaf& leaf) {
  return std::visit([](const auto& l) { return leaf_text(l); }, leaf);
}

FieldWriter::FieldWriter(const Scenario& scenario, const NameFile& name_file)
    : scenario_(scenario), name_file_(name_file) {
  frames_.emplace_back();
  frames_.back().in_lines = true;
}

std::string FieldWriter::text_of_scenario() const {
  return text_of(frames_.front()).substr(1) + "\n";
}

// A section with distributions keeps its own text, whatever was sampled.
bool FieldWriter::wants(std::string_view key, const Rule& rule) {
  const Node* drawn = frames_.size() == 1 ? drawn_section(scenario_, key) : nullptr;
  if (drawn == nullptr) return rule.written && rule.useless.empty();
  std::string text = section_text(key, *drawn, name_file_);
  text.pop_back();
  frames_.back().entries.push_back({"", std::move(text)});
  return false;
}

void FieldWriter::put(std::string_view key, std::string text) {
  Frame& frame = frames_.back();
  std::string written(frame.form == Form::list ? "" : key);
  if (frame.form == Form::names) written = quoted_if_needed(written);
  frame.entries.push_back({std::move(written), std::move(text)});
}

std::string FieldWriter::text_of(const Frame& frame) const {
  const bool is_list = frame.form == Form::list;
  const bool in_lines = frame.in_lines && !frame.entries.empty();
  const std::string between =
      in_lines ? "\n" + std::string(2 * (frames_.size() - 1), ' ') + (is_list ? "- " : "") : ", ";
  std::string text;
  for (const Entry& entry : frame.entries) {
    if (in_lines || !text.empty()) text += between;
    text += entry.key;
    if (!entry.key.empty()) text += entry.text.starts_with('\n') ? ":" : ": ";
    text += entry.text;
  }
  if (in_lines) return text;
  return is_list ? "[" + text + "]" : "{" + text + "}";
}

void FieldWriter::end() {
  const bool own_value =
      frames_.back().entries.size() == 1 && frames_.back().entries[0].key.empty();
  const Frame& done = frames_.back();
  std::string text;
  if (done.form == Form::on && done.entries.empty()) {
    text = "true";
  } else if (done.form == Form::kind && done.entries.empty()) {
    text = done.word;
  } else if (done.form == Form::kind) {
    text = fmt::format("{{{}: {}}}", done.word, own_value ? done.entries[0].text : text_of(done));
  } else {
    text = text_of(done);
  }
  const std::string key = done.key;
  frames_.pop_back();
  put(key, std::move(text));
}

bool FieldWriter::leaf(const KeyText& text, const Leaf& leaf, const Rule& rule) {
  const std::string_view key = text.key;
  if (!wants(key, rule)) return false;
  const auto* file = std::get_if<FileLeaf>(&leaf);
  put(key, file != nullptr ? quoted_if_needed(name_file_(file->out)) : leaf_text(leaf));
  return false;
}

bool FieldWriter::begin(const KeyText& text, const Branch& branch, const Rule& rule) {
  const std::string_view key = text.key;
  if (!wants(key, rule)) return false;
  const auto* switched = std::get_if<SwitchBranch>(&branch);
  if (switched != nullptr && !switched->on) {
    put(key, "false");
    return false;
  }
  Frame frame;
  frame.key = key;
  frame.form = static_cast<Form>(branch.index());
  frame.in_lines = rule.in_lines && frames_.back().in_lines;
  if (const auto* kind = std::get_if<KindBranch>(&branch)) frame.word = kind->words[kind->index];
  frames_.push_back(std::move(frame));
  return true;
}

}  // namespace ensonify
