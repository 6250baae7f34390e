// User errors are values: Result<T> holds a T or an Error, Status holds nothing or an Error.
// Bugs are assertions (ENSONIFY_ASSERT), which stay on in release builds.
//
//   Result<T>   ok error operator* operator->
//   Status      ok error
//   exit_code   the process exit status that an error ends with
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>

namespace ensonify {

enum class ErrorKind {
  bug,          // a broken invariant of the program
  damage,       // verify found a damaged or incomplete data set
  usage,        // wrong command line, scenario, or input file
  io,           // reading or writing failed
  device,       // no device, or not enough memory
  interrupted,  // stopped on request; finished files are kept
  incomplete,   // some parts of the work cannot be made; all others are done
  redraw,       // the sampled world cannot be built; another sample may work
  final_usage,  // as usage, but ends the whole run instead of one sequence
};

struct Error {
  ErrorKind kind = ErrorKind::bug;
  std::string message;  // what is wrong, where, and what to do; one line per error
};

// 1 bug or damage, 2 usage, 3 incomplete, 4 reading or writing, 5 device or memory,
// 130 interrupted.
int exit_code(ErrorKind kind);

template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::move(value)) {}
  Result(Error error) : state_(std::move(error)) {}

  bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }

  // Values need ok(), and error() needs !ok(). Any other use is a bug and throws.
  T& operator*() { return std::get<0>(state_); }
  const T& operator*() const { return std::get<0>(state_); }
  T* operator->() { return &std::get<0>(state_); }
  const T* operator->() const { return &std::get<0>(state_); }
  const Error& error() const { return std::get<1>(state_); }

 private:
  std::variant<T, Error> state_;
};

// Thrown if a device or a library has no memory or cannot start, in code that cannot return an
// Error. The program's top level converts it to ErrorKind::device.
class DeviceFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class [[nodiscard]] Status {
 public:
  Status() = default;
  Status(Error error) : error_(std::move(error)) {}

  bool ok() const { return !error_.has_value(); }
  explicit operator bool() const { return ok(); }
  const Error& error() const { return error_.value(); }

 private:
  std::optional<Error> error_;
};

// Throws std::logic_error with the broken condition and its place; the program's top level reports
// it as a bug.
[[noreturn]] void assertion_failed(const char* condition, const char* file, int line);

}  // namespace ensonify

#define ENSONIFY_ASSERT(condition) \
  ((condition) ? void(0) : ::ensonify::assertion_failed(#condition, __FILE__, __LINE__))
