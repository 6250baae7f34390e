#include "formats/files.h"

#include <sys/resource.h>
#include <sys/stat.h>

#include <cerrno>
#include <csignal>
#include <filesystem>

#include "catch.h"
#include "dataset/sample.h"
#include "dataset/work_folder.h"
#include "results.h"

using namespace ensonify;
namespace fs = std::filesystem;

// Protects every checksum of a data set; test vectors of FIPS 180-4.
TEST_CASE("sha256 gives the standard's values") {
  CHECK(sha256_hex("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK(sha256_hex("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  const sample::TemporaryFolder folder;
  sample::write(folder.path() / "a", "abc");
  const auto hash = value_of(sha256_of_file(folder.path() / "a"));
  CHECK(hash == sha256_hex("abc"));
  check_fails(sha256_of_file(folder.path() / "b"), ErrorKind::io);
}

// Protects the way of writing: folders are made, the entry tells the truth, and nothing but the
// file is left.
TEST_CASE("a file is written with its folders, size and hash") {
  const sample::TemporaryFolder folder;
  const auto entry = value_of(write_file_atomically(folder.path(), "a/b/c.txt", "abc"));
  CHECK(entry.path == "a/b/c.txt");
  CHECK(entry.bytes == 3);
  CHECK(entry.sha256 == sha256_hex("abc"));
  CHECK(sample::read(folder.path() / "a/b/c.txt") == "abc");
  CHECK(fs::is_empty(folder.path() / ".work/tmp"));
}

// Protects long files: pieces of any size, smaller and larger than the buffer, arrive in order.
TEST_CASE("a streamed file holds its pieces in order") {
  const sample::TemporaryFolder folder;
  StreamedFile file(folder.path(), "long");
  std::string expected;
  for (const std::size_t size : {1u, 100000u, 200000u, 300000u, 7u, 1000000u, 0u, 3u}) {
    const std::string piece(size, static_cast<char>('a' + expected.size() % 26));
    file.append(piece);
    expected += piece;
  }
  const auto entry = value_of(file.commit());
  CHECK(sample::read(folder.path() / "long") == expected);
  CHECK(entry.bytes == expected.size());
  CHECK(entry.sha256 == sha256_hex(expected));
}

// Protects files that go past the page cache: sizes around whole blocks, and pieces that come after
// a front of any length, arrive byte for byte.
TEST_CASE("long files arrive whole whatever their length") {
  const sample::TemporaryFolder folder;
  for (const std::size_t front : {0u, 1u, 4096u}) {
    for (const std::size_t size :
         {(1u << 20) - 1, 1u << 20, (1u << 20) + 1, (1u << 20) + 4095, (3u << 20) + 4097}) {
      std::string bytes(front + size, '\0');
      for (std::size_t i = 0; i < bytes.size(); ++i) {
        bytes[i] = static_cast<char>((i * 2654435761u) >> 13);
      }
      StreamedFile file(folder.path(), "long");
      file.append(std::string_view(bytes).substr(0, front));
      file.append(std::string_view(bytes).substr(front));
      const auto entry = value_of(file.commit());
      CHECK(entry.bytes == bytes.size());
      CHECK(entry.sha256 == sha256_hex(bytes));
      CHECK((sample::read(folder.path() / "long") == bytes));
    }
  }
}

// Protects "a file appears under its final name only when it is whole": before commit there is no
// such name, and without commit nothing stays.
TEST_CASE("a streamed file has no name before it is whole") {
  const sample::TemporaryFolder folder;
  {
    StreamedFile file(folder.path(), "long");
    file.append(std::string(1000000, 'x'));
    CHECK_FALSE(fs::exists(folder.path() / "long"));
  }
  CHECK_FALSE(fs::exists(folder.path() / "long"));
  CHECK(fs::is_empty(folder.path() / ".work/tmp"));
}

// Protects two copies of the same work: one removes .work, with the temporary file that the other
// is writing in it.
TEST_CASE("a file is written even if .work vanishes meanwhile") {
  const sample::TemporaryFolder folder;
  StreamedFile file(folder.path(), "sequences/000000/long");
  const std::string bytes(600000, 'x');
  file.append(bytes);
  remove_work_folder(folder.path());
  REQUIRE_FALSE(fs::exists(folder.path() / ".work"));
  const auto entry = value_of(file.commit());
  CHECK(sample::read(folder.path() / "sequences/000000/long") == bytes);
  CHECK(entry.sha256 == sha256_hex(bytes));
}

// Protects the exit status 4: a folder that cannot be made is an io error with the file's name.
TEST_CASE("an unwritable place is an io error that names the file") {
  const sample::TemporaryFolder folder;
  sample::write(folder.path() / "a", "a file where a folder should be");
  for (const fs::path& dir : {folder.path() / "a", fs::path("/proc/ensonify")}) {
    check_fails(write_file_atomically(dir, "b.txt", "abc"), ErrorKind::io,
                {(dir / "b.txt").string()});
  }
  check_fails(write_file_atomically(folder.path(), "a/b.txt", "abc"), ErrorKind::io);
}

// Protects against half-written files when writing fails in the middle. The system's limit on the
// size of a file plays the full disk.
TEST_CASE("a file that cannot be written to its end leaves nothing behind") {
  const sample::TemporaryFolder folder;
  rlimit before{};
  REQUIRE(::getrlimit(RLIMIT_FSIZE, &before) == 0);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{500000, before.rlim_max};
  REQUIRE(::setrlimit(RLIMIT_FSIZE, &small) == 0);
  const auto entry = write_file_atomically(folder.path(), "long", std::string(1000000, 'x'));
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, old_handler);
  REQUIRE_FALSE(entry);
  CHECK(entry.error().kind == ErrorKind::io);
  CHECK(contains(entry.error().message, (folder.path() / "long").string()));
  CHECK_FALSE(fs::exists(folder.path() / "long"));
  CHECK(fs::is_empty(folder.path() / ".work/tmp"));
}

// Protects the advice for the most likely failure of a long run.
TEST_CASE("a full disk is an io error that says what to do") {
  const Error error = write_error("out/data.npy", ENOSPC);
  CHECK(error.kind == ErrorKind::io);
  CHECK(contains(error.message, "out/data.npy: No space left on device"));
  CHECK(contains(error.message, "same command again"));
}

// Protects against manifests that name files outside of the folder.
TEST_CASE("paths that leave the folder are not safe") {
  for (const char* path : {"a", "a/b", "sequences/000000/x.npy", "..a", "a..b", ".work"}) {
    CHECK(is_safe_relative_path(path));
  }
  for (const char* path : {"", "/", "/etc/passwd", "..", "../a", "a/../b", "a/..", ".", "./a",
                           "a/./b", "a//b", "a/"}) {
    INFO(path);
    CHECK_FALSE(is_safe_relative_path(path));
  }
  CHECK_FALSE(is_safe_relative_path(std::string_view("a\0b", 3)));
}

// Protects against links that lead out of the folder, in the last part of a path or before it.
TEST_CASE("a listed file is not reached through links") {
  const sample::TemporaryFolder folder;
  sample::write(folder.path() / "outside/file", "abc");
  sample::write(folder.path() / "inside/file", "abc");
  fs::create_symlink(folder.path() / "outside/file", folder.path() / "inside/link");
  fs::create_directory_symlink(folder.path() / "outside", folder.path() / "inside/folder");
  const fs::path dir = folder.path() / "inside";
  CHECK(listed_file_size(dir, "file") == std::uint64_t{3});
  CHECK_FALSE(listed_file_size(dir, "link"));
  CHECK_FALSE(listed_file_size(dir, "folder/file"));
  CHECK_FALSE(listed_file_size(dir, "folder"));
  CHECK_FALSE(listed_file_size(dir, "missing"));
  CHECK_FALSE(listed_file_size(dir, "../outside/file"));
}

// Protects strangers' files in .work, and what a link in it points to.
// Protects the night: a pipe would be waited for without end.
TEST_CASE("only regular files are read, and no more of them than is asked for") {
  const sample::TemporaryFolder folder;
  REQUIRE(::mkfifo((folder.path() / "pipe").c_str(), 0600) == 0);
  fs::create_symlink("/dev/zero", folder.path() / "zeros");
  for (const char* name : {"pipe", "zeros", "."}) {
    check_fails(read_file(folder.path() / name), ErrorKind::io, {"not a regular file"});
  }
  sample::write(folder.path() / "ten", "0123456789");
  CHECK(*read_file(folder.path() / "ten", 10) == "0123456789");
  CHECK_FALSE(read_file(folder.path() / "ten", 9).ok());
}

TEST_CASE("only records and temporary files are removed with .work") {
  const sample::TemporaryFolder folder;
  const fs::path dir = folder.path() / "data";
  sample::write(folder.path() / "outside/000000.json", "keep");
  sample::write(dir / ".work/tmp/1-2", "x");
  sample::write(dir / ".work/plan.json", "x");
  sample::write(dir / ".work/sequences/000000/000001.json", "x");
  fs::create_directory_symlink(folder.path() / "outside", dir / ".work/sequences/000001");
  sample::write(dir / ".work/notes.txt", "mine");
  remove_work_folder(dir);
  CHECK(sample::read(folder.path() / "outside/000000.json") == "keep");
  CHECK(sample::read(dir / ".work/notes.txt") == "mine");
  CHECK_FALSE(fs::exists(dir / ".work/tmp"));
  CHECK_FALSE(fs::exists(dir / ".work/plan.json"));
  CHECK_FALSE(fs::exists(dir / ".work/sequences/000000"));
}
