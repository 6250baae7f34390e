#include "app/print.h"

#include <cerrno>
#include <cstdio>
#include <cstring>

namespace ensonify {

void tell_text(std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

void answer_text(std::string_view text) { std::fwrite(text.data(), 1, text.size(), stdout); }

Status answers_written() {
  errno = 0;
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return {};
  return Error{ErrorKind::io,
               fmt::format("standard output: cannot be written{}{}", errno != 0 ? ": " : "",
                           errno != 0 ? std::strerror(errno) : "")};
}

}  // namespace ensonify
