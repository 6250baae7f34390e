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
  bug,          // a broken promise of our own
  damage,       // verify found a data set that is not whole
  usage,        // wrong command line, scenario, or input file
  io,           // reading or writing failed
  device,       // device or memory not to be had
  interrupted,  // asked to stop; what is finished is kept
  incomplete,   // some parts of the work cannot be made; all others are done
  redraw,       // a world as it was drawn cannot be built; another draw may do
  final_usage,  // usage that ends the whole run, where usage costs one sequence
};

struct Error {
  ErrorKind kind = ErrorKind::bug;
  std::string message;  // what is wrong, where, and what to do; one line a fault
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

  // Only after ok() said yes (no): anything else is a bug and throws.
  T& operator*() { return std::get<0>(state_); }
  const T& operator*() const { return std::get<0>(state_); }
  T* operator->() { return &std::get<0>(state_); }
  const T* operator->() const { return &std::get<0>(state_); }
  const Error& error() const { return std::get<1>(state_); }

 private:
  std::variant<T, Error> state_;
};

// Thrown where a device or a library behind a stage has no memory or cannot start, deep inside work
// that has no way to hand a value back; the program's top turns it into ErrorKind::device.
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

// Throws std::logic_error with the broken condition and its place; the program's top reports it as
// a bug.
[[noreturn]] void assertion_failed(const char* condition, const char* file, int line);

}  // namespace ensonify

#define ENSONIFY_ASSERT(condition) \
  ((condition) ? void(0) : ::ensonify::assertion_failed(#condition, __FILE__, __LINE__))
