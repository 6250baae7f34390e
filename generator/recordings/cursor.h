// Values one after another in bytes of MCAP and ROS. Private to recordings/.
//
//   Cursor
#pragma once

#include <cstdint>
#include <string_view>

#include "formats/bytes.h"

namespace ensonify {

// Values one after another. Once a value goes beyond the bytes, all are 0 and `whole` is false.
class Cursor {
 public:
  // CDR aligns numbers to their size; MCAP does not.
  Cursor(std::string_view bytes, bool aligned) : bytes_(bytes), aligned_(aligned) {}

  template <class T>
  T number() {
    if (aligned_) skip((sizeof(T) - at_ % sizeof(T)) % sizeof(T));
    const std::string_view raw = take(sizeof(T));
    return whole_ ? value_at<T>(raw, 0) : T{};
  }
  std::string_view take(std::uint64_t count) {
    if (!whole_ || count > bytes_.size() - at_) {
      whole_ = false;
      return {};
    }
    const std::string_view taken = bytes_.substr(at_, count);
    at_ += count;
    return taken;
  }
  std::string_view text() { return take(number<std::uint32_t>()); }
  // The bytes of an array of such numbers.
  template <class T>
  std::string_view array() {
    const std::uint64_t count = number<std::uint32_t>();
    if (aligned_ && count > 0) skip((sizeof(T) - at_ % sizeof(T)) % sizeof(T));
    return take(count * sizeof(T));
  }
  bool whole() const { return whole_; }
  std::uint64_t at() const { return at_; }

 private:
  void skip(std::uint64_t count) { take(count); }

  std::string_view bytes_;
  std::uint64_t at_ = 0;
  bool aligned_, whole_ = true;
};

}  // namespace ensonify
