// An export appears whole or not at all, and an interrupted one leaves nothing.
#include "formats/output_place.h"

#include <filesystem>
#include <iterator>
#include <optional>

#include "catch.h"
#include "formats/files.h"
#include "results.h"
#include "temporary_folder.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;

std::size_t entries(const fs::path& folder) {
  return static_cast<std::size_t>(
      std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST_CASE("what is not committed goes, what is committed has its name") {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "above" / "out";
  {
    auto place = value_of(OutputPlace::open(out, true, folder.path() / "set"));
    REQUIRE(write_whole(place.temporary() / "deep/file", "text").ok());
    CHECK_FALSE(fs::exists(out));
  }
  CHECK(entries(out.parent_path()) == 0);
  {
    auto place = value_of(OutputPlace::open(out, true, folder.path() / "set"));
    REQUIRE(write_whole(place.temporary() / "deep/file", "text").ok());
    REQUIRE(place.commit().ok());
  }
  CHECK(*read_file(out / "deep/file") == "text");
  CHECK(entries(out.parent_path()) == 1);
}

TEST_CASE("an output must be new or empty, and outside of the data set") {
  const TemporaryFolder folder;
  const fs::path set = folder.path() / "set", full = folder.path() / "full";
  fs::create_directories(set);
  REQUIRE(write_whole(full / "file", "mine").ok());
  fs::create_directory_symlink(set, folder.path() / "link");
  const auto kind = [&](const fs::path& out, bool is_folder) {
    const auto place = OutputPlace::open(out, is_folder, set);
    return place ? std::optional<ErrorKind>() : place.error().kind;
  };
  CHECK(kind(full, true) == ErrorKind::usage);
  CHECK(kind(full / "file", false) == ErrorKind::usage);
  CHECK(kind(set, true) == ErrorKind::usage);
  CHECK(kind(set / "deep" / "out", true) == ErrorKind::usage);
  CHECK(kind(set / ".." / "set" / "out", true) == ErrorKind::usage);
  CHECK(kind(folder.path() / "link" / "out", true) == ErrorKind::usage);
  CHECK(kind("", true) == ErrorKind::usage);
  CHECK(kind(full / "file" / "out", true) == ErrorKind::io);
  CHECK_FALSE(kind(folder.path() / "set2", true));  // begins alike, and is another folder
  CHECK(entries(set) == 0);
}

TEST_CASE("a write that fails comes out of close and leaves nothing") {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "above" / "file";
  fs::create_directories(path / "in its place");
  StreamedFile file(path);
  file.append("text");
  check_fails(file.close(), ErrorKind::io, {path.string(), "something else has its name"});
  check_fails(write_whole("/proc/ensonify/file", "text"), ErrorKind::io);
}

TEST_CASE("a file written anywhere has a hidden name until it is whole") {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "new" / "file";
  {
    StreamedFile dropped(path);
    dropped.append("text");
    CHECK(fs::directory_iterator(path.parent_path())
              ->path()
              .filename()
              .string()
              .starts_with(".file.part-"));
  }
  CHECK(entries(path.parent_path()) == 0);
  StreamedFile file(path);
  file.append("te");
  file.append("xt");
  CHECK(file.bytes() == 4);
  const auto entry = value_of(file.commit());
  CHECK(entry.path == path.string());
  CHECK(entry.sha256.empty());
  CHECK(*read_file(path) == "text");
  CHECK(entries(path.parent_path()) == 1);
}

}  // namespace
}  // namespace ensonify
