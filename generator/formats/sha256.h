// SHA-256, as 64 lower-case hexadecimal digits.
//
//   sha256_hex  of bytes in memory
//   Sha256      of bytes in pieces
#pragma once

#include <memory>
#include <string>
#include <string_view>

namespace ensonify {

std::string sha256_hex(std::string_view bytes);

class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(Sha256&&) noexcept;
  Sha256& operator=(Sha256&&) noexcept;

  void update(std::string_view bytes);
  // The hash of all bytes so far; afterwards only destruction is allowed.
  std::string finish();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ensonify
