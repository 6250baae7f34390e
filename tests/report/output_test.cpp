// Where a page may be written.
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>

#include "catch.h"
#include "report/page.h"
#include "results.h"
#include "verified.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;
using test::TemporaryFolder;

std::size_t entries(const fs::path& folder) {
  return static_cast<std::size_t>(
      std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST_CASE("a page replaces a page, and nothing else unless it is told to") {
  const TemporaryFolder folder;
  ReportOptions options;
  options.dataset = test::make_set(folder, "set", test::kScene, {{"trajectory.pings", "1"}});
  options.threads = 2;
  const auto kind = [&]() -> std::optional<ErrorKind> {
    const auto summary = write_report(options);
    return summary ? std::nullopt : std::optional(summary.error().kind);
  };
  CHECK_FALSE(kind());
  CHECK(fs::exists(folder.path() / "set_report.html"));
  CHECK_FALSE(kind());
  options.dataset /= "";  // with a slash at its end
  CHECK_FALSE(kind());

  options.output = folder.write("mine.html", "<!doctype html>\n");
  const std::size_t before = entries(folder.path());
  CHECK(kind() == ErrorKind::usage);
  std::string text;
  std::getline(std::ifstream(options.output), text);
  CHECK(text == "<!doctype html>");
  options.overwrite = true;
  CHECK_FALSE(kind());
  options.overwrite = false;
  CHECK_FALSE(kind());
  CHECK(entries(folder.path()) == before);

  options.output = folder.path();
  CHECK(kind() == ErrorKind::usage);
  options.output = options.dataset / "report.html";
  check_fails(write_report(options), {"ensonify verify"});
  fs::create_directory_symlink(options.dataset, folder.path() / "link");
  options.output = folder.path() / "link" / "report.html";
  CHECK(kind() == ErrorKind::usage);
  CHECK(test::verified(options.dataset).ok());

  options.output = folder.path() / "mine.html" / "page.html";
  CHECK(kind() == ErrorKind::io);
  options.output = folder.path() / "deep" / "page.html";
  CHECK_FALSE(kind());
}

TEST_CASE("what is no finished data set is refused, and damage is told") {
  const TemporaryFolder folder;
  ReportOptions options;
  options.dataset = folder.path();
  options.output = folder.path() / "out" / "page.html";
  const auto refused = [&](ErrorKind kind, const std::string& what) {
    const auto summary = write_report(options);
    REQUIRE_FALSE(summary.ok());
    CHECK(summary.error().kind == kind);
    INFO(summary.error().message);
    CHECK(contains(summary.error().message, what));
    CHECK_FALSE(fs::exists(options.output));
  };
  refused(ErrorKind::usage, "not a data set of ensonify");
  options.dataset = test::make_set(folder, "set", test::kScene, {{"trajectory.pings", "2"}});
  const fs::path sequence = options.dataset / "sequences/000000";
  fs::rename(sequence / "polar/000001.exr", sequence / "gone");
  refused(ErrorKind::io, "000001.exr: is missing");
  fs::rename(sequence / "gone", sequence / "polar/000001.exr");
  fs::resize_file(sequence / "boxes.csv", fs::file_size(sequence / "boxes.csv") - 5);
  refused(ErrorKind::io, "boxes.csv");
}

TEST_CASE("an interrupted page leaves nothing, and the old one stays") {
  const TemporaryFolder folder;
  ReportOptions options;
  options.dataset = test::make_set(folder, "set", test::kScene);
  options.output = folder.path() / "page.html";
  REQUIRE(write_report(options).ok());
  const auto stamp = fs::last_write_time(options.output);
  const std::size_t before = entries(folder.path());
  options.stop = [] { return true; };
  check_fails(write_report(options), ErrorKind::interrupted);
  CHECK(fs::last_write_time(options.output) == stamp);
  CHECK(entries(folder.path()) == before);
}

}  // namespace
}  // namespace ensonify
