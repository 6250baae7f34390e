// Stopped between two pings, every exporter leaves nothing behind.
#include <filesystem>

#include "catch.h"
#include "export/export.h"
#include "results.h"
#include "run/small_data_set.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

TEST_CASE("an interrupted export leaves nothing, and the next one is whole") {
  const test::Maker maker;
  GenerateOptions with_all = maker.options("set");
  with_all.input.overrides.push_back({"output.front", "true"});
  with_all.input.overrides.push_back({"camera", "{fov_deg: 60, width_px: 16, height_px: 12}"});
  maker.make(with_all);
  ExportOptions options;
  options.dataset = maker.folder.path() / "set";
  for (const ExportFormat& format : export_formats()) {
    INFO(format.name);
    // It holds fans of an ARIS alone; it is written ping by ping as an Oculus log is.
    if (std::string(format.name) == "aris") continue;
    const fs::path place = maker.folder.path() / format.name;
    options.output = place / "out";
    int asked = 0;
    options.stop = [&] { return ++asked == 3; };
    check_fails(export_dataset(format, options), ErrorKind::interrupted);
    CHECK(fs::is_empty(place));
    // Of four pings, two were done: it is asked once a ping.
    CHECK(asked == 3);
    options.stop = nullptr;
    const auto again = value_of(export_dataset(format, options));
    CHECK(again.pings == 4);
    CHECK(fs::exists(options.output));
  }
}

TEST_CASE("an export that is interrupted in its search for pairs leaves nothing") {
  const test::Maker maker;
  maker.make(maker.options("set"));
  ExportOptions options;
  options.dataset = maker.folder.path() / "set";
  const fs::path place = maker.folder.path() / "place";
  options.output = place / "out";
  int asked = 0;
  options.stop = [&] { return ++asked == 8; };  // four times while pings are read
  check_fails(export_dataset(*find_export_format("sonic"), options), ErrorKind::interrupted);
  CHECK(fs::is_empty(place));
}

TEST_CASE("every format has another name, and options that exist") {
  const auto formats = export_formats();
  CHECK(formats.size() == 23);
  for (const ExportFormat& format : formats) {
    CHECK(find_export_format(format.name) == &format);
    CHECK(std::string(format.what).size() > 10);
  }
  CHECK(find_export_format("png") == nullptr);
}

}  // namespace
}  // namespace ensonify
