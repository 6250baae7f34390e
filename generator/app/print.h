// What the program says.
//
//   tell               to standard error: a failure to write is none of the work's, which goes on
//   answer             to standard output: what was asked for
//   answers_written    whether all answers came through
#pragma once

#include <fmt/format.h>

#include <string_view>
#include <utility>

#include "core/error.h"

namespace ensonify {

void tell_text(std::string_view text);
void answer_text(std::string_view text);

template <class... T>
void tell(fmt::format_string<T...> format, T&&... values) {
  tell_text(fmt::format(format, std::forward<T>(values)...));
}

template <class... T>
void answer(fmt::format_string<T...> format, T&&... values) {
  answer_text(fmt::format(format, std::forward<T>(values)...));
}

// ErrorKind::io where standard output did not take everything, as on a full disk.
Status answers_written();

}  // namespace ensonify
