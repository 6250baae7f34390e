#include "core/error.h"

#include <cstdio>
#include <cstdlib>

namespace ensonify {

int exit_code(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::bug:
    case ErrorKind::damage:
      return 1;
    case ErrorKind::usage:
      return 2;
    case ErrorKind::io:
      return 4;
    case ErrorKind::device:
      return 5;
    case ErrorKind::interrupted:
      return 130;
  }
  return 1;
}

void assertion_failed(const char* condition, const char* file, int line) {
  std::fprintf(stderr, "ensonify: bug: %s:%d: %s does not hold; please report it\n", file, line,
               condition);
  std::abort();
}

}  // namespace ensonify
