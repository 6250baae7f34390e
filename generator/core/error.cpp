#include "core/error.h"

#include <stdexcept>
#include <string>

namespace ensonify {

int exit_code(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::bug:
    case ErrorKind::damage:
      return 1;
    case ErrorKind::usage:
    case ErrorKind::redraw:
    case ErrorKind::final_usage:
      return 2;
    case ErrorKind::incomplete:
      return 3;
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
  throw std::logic_error(std::string(file) + ":" + std::to_string(line) + ": " + condition +
                         " does not hold");
}

}  // namespace ensonify
