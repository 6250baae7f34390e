#include "bench/machine.h"

#include <cstring>

#include "bench/timing.h"
#include "catch.h"
#include "dataset/files.h"

using namespace ensonify;

namespace fs = std::filesystem;

TEST_CASE("the median is the middle, the lower one of two") {
  CHECK(median({3, 1, 2}) == 2);
  CHECK(median({4, 1, 3, 2}) == 2);
  CHECK(median({5}) == 5);
}

// Protects against medians of one run: three count at least, and what comes after each is called.
TEST_CASE("a thing is run three times or more, however long it takes") {
  int runs = 0, cleaned = 0;
  median_ms(
      0, [&] { ++runs; }, [&] { ++cleaned; });
  CHECK(runs >= 3);
  CHECK(cleaned == runs);
}

// Protects the figure of the disk: whole pages are written past the cache, and yet the file is the
// one that was asked for.
TEST_CASE("a file on the disk holds what was given, whatever its length") {
  auto folder = ScratchFolder::make(fs::temp_directory_path());
  REQUIRE(folder.ok());
  for (const std::size_t size : {std::size_t{1}, std::size_t{4096}, std::size_t{70'001}}) {
    const PageBuffer buffer(size);
    for (std::size_t i = 0; i < size; ++i) buffer.data()[i] = static_cast<char>(i % 251);
    bool direct = false;
    const fs::path file = folder->path() / "file";
    REQUIRE(write_to_disk(file, buffer.data(), size, direct).ok());
    const auto bytes = read_file(file);
    REQUIRE(bytes.ok());
    CHECK(*bytes == std::string_view(buffer.data(), size));
  }
}

TEST_CASE("a scratch folder takes its files with it, and needs a place") {
  fs::path path;
  {
    auto folder = ScratchFolder::make(fs::temp_directory_path());
    REQUIRE(folder.ok());
    path = folder->path();
    REQUIRE(write_file_atomically(path, "a/b", "text").ok());
  }
  CHECK_FALSE(fs::exists(path));
  const auto nowhere = ScratchFolder::make("/nonexistent/place");
  REQUIRE_FALSE(nowhere.ok());
  CHECK(nowhere.error().kind == ErrorKind::io);
}
