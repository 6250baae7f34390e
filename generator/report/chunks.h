// The binary pieces of a page. Private to report/.
//
//   Chunks  stores equal pieces only once
#pragma once

#include <cstddef>
#include <deque>
#include <string>
#include <string_view>
#include <unordered_map>

namespace ensonify {

class Chunks {
 public:
  Chunks() = default;
  Chunks(const Chunks&) = delete;
  Chunks& operator=(const Chunks&) = delete;

  // The number of the chunk.
  std::size_t add(std::string bytes) {
    const auto known = numbers_.find(bytes);
    if (known != numbers_.end()) return known->second;
    chunks_.push_back(std::move(bytes));
    numbers_.emplace(chunks_.back(), chunks_.size() - 1);
    return chunks_.size() - 1;
  }
  std::size_t size() const { return chunks_.size(); }
  const std::string& operator[](std::size_t number) const { return chunks_[number]; }

 private:
  std::deque<std::string> chunks_;  // keys of numbers_ refer to these texts, which never move
  std::unordered_map<std::string_view, std::size_t> numbers_;
};

}  // namespace ensonify
