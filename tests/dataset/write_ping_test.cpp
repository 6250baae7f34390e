#include "dataset/write_ping.h"

#include <filesystem>
#include <thread>

#include "catch.h"
#include "dataset/layout.h"
#include "dataset/sample.h"
#include "formats/npy.h"
#include "formats/png.h"
#include "results.h"

using namespace ensonify;
namespace fs = std::filesystem;

namespace {

const fs::path kSequence = "sequences/000000";

}  // namespace

// Protects the layout on disk: these names, all of them, and nothing else beside the record and
// plan.
TEST_CASE("a ping has the files of the layout") {
  const sample::TemporaryFolder folder;
  const auto info = sample::sequence_info(0);
  REQUIRE(write_ping(folder.path(), info, sample::ping_result(info, 2), Workers(2)).ok());
  std::vector<std::string> names;
  for (const auto& [name, bytes] : sample::contents(folder.path())) names.push_back(name);
  const std::vector<std::string> expected = {".work/sequences/000000/000002.json",
                                             ".work/sequences/000000/plan.json",
                                             "sequences/000000/cartesian/000002.exr",
                                             "sequences/000000/cartesian/000002_instance.png",
                                             "sequences/000000/cartesian/000002_semantic.png",
                                             "sequences/000000/cartesian/000002_shadow.png",
                                             "sequences/000000/png/000002_cartesian.png",
                                             "sequences/000000/png/000002_polar.png",
                                             "sequences/000000/points/000002.ply",
                                             "sequences/000000/polar/000002.exr",
                                             "sequences/000000/polar/000002_instance.png",
                                             "sequences/000000/polar/000002_semantic.png",
                                             "sequences/000000/polar/000002_shadow.png",
                                             "sequences/000000/scatterers/000002.npy",
                                             "sequences/000000/timeseries/000002.exr",
                                             "sequences/000000/timeseries/000002.npy"};
  CHECK(names == expected);
}

// Protects the content under each name: shapes, bit depths, and the right picture in the right
// file.
TEST_CASE("a ping's files hold what their names say") {
  const sample::TemporaryFolder folder;
  const auto info = sample::sequence_info(0);
  const auto result = sample::ping_result(info, 1);
  REQUIRE(write_ping(folder.path(), info, result, Workers(1)).ok());
  const fs::path dir = folder.path() / kSequence;

  CHECK(sample::read(dir / "timeseries/000001.npy") ==
        encode_npy(result.series, {sample::kBeams, sample::kSamples}));
  const auto png = [&](const char* name) {
    return parse_png_header(sample::read(dir / name)).value_or(PngHeader{});
  };
  CHECK(png("polar/000001_instance.png").bit_depth == 16);
  CHECK(png("polar/000001_instance.png").width == sample::kBeams);
  CHECK(png("polar/000001_semantic.png").bit_depth == 8);
  CHECK(png("cartesian/000001_instance.png").height == 7);
  CHECK(png("cartesian/000001_shadow.png").bit_depth == 16);
  CHECK(*encode_png(result.polar->shadow, sample::kSamples, sample::kBeams) ==
        sample::read(dir / "polar/000001_shadow.png"));
  CHECK(*encode_png(result.polar->semantic, sample::kSamples, sample::kBeams) ==
        sample::read(dir / "polar/000001_semantic.png"));
  CHECK(*encode_png(result.polar_grey->pixels, sample::kSamples, sample::kBeams) ==
        sample::read(dir / "png/000001_polar.png"));
  CHECK(*encode_png(result.cartesian_grey->pixels, 7, 8) ==
        sample::read(dir / "png/000001_cartesian.png"));
}

// Protects the choice of outputs: what is off leaves no file.
TEST_CASE("outputs that are off are not written") {
  const sample::TemporaryFolder folder;
  auto info = sample::sequence_info(0);
  info.output = {true, false, false, false, false};
  REQUIRE(write_ping(folder.path(), info, sample::ping_result(info, 0), Workers(1)).ok());
  const auto contents = sample::contents(folder.path() / kSequence);
  REQUIRE(contents.size() == 1);
  CHECK(contents.begin()->first == "timeseries/000000.npy");
}

// Protects disk and time: without the key Cartesian pictures are masks and grey, whatever float
// planes the pipeline left out.
TEST_CASE("a ping without float planes of its Cartesian image") {
  const sample::TemporaryFolder folder;
  auto info = sample::sequence_info(0);
  info.output.cartesian_exr = false;
  auto result = sample::ping_result(info, 0);
  for (auto* values :
       {&result.cartesian->level_db, &result.cartesian->clean_db, &result.cartesian->elevation_rad,
        &result.cartesian->elevation_std_rad, &result.cartesian->instance_fraction}) {
    values->clear();
  }
  REQUIRE(write_ping(folder.path(), info, result, Workers(1)).ok());
  const auto contents = sample::contents(folder.path() / kSequence);
  CHECK_FALSE(contents.contains("cartesian/000000.exr"));
  CHECK(contents.contains("cartesian/000000_instance.png"));
  CHECK(contents.contains("polar/000000.exr"));
}

// Protects data sets without shadows: their pings are whole, and one that should have them is not.
TEST_CASE("a ping without shadows") {
  const sample::TemporaryFolder folder;
  auto info = sample::sequence_info(0);
  auto result = sample::ping_result(info, 0);
  result.polar->shadow.clear();
  CHECK(write_ping(folder.path(), info, result, Workers(1)).error().kind == ErrorKind::bug);
  info.output.shadow = false;
  REQUIRE(write_ping(folder.path(), info, result, Workers(1)).ok());
  CHECK_FALSE(sample::contents(folder.path() / kSequence).contains("polar/000000_shadow.png"));
  CHECK_FALSE(sample::contents(folder.path() / kSequence).contains("cartesian/000000_shadow.png"));
}

// Protects continuing: a ping counts only with its record and with every file as long as recorded.
TEST_CASE("a ping is finished when its record and files are there") {
  const sample::TemporaryFolder folder;
  const auto info = sample::sequence_info(0);
  CHECK_FALSE(ping_is_finished(folder.path(), 0, 1, info));
  REQUIRE(write_ping(folder.path(), info, sample::ping_result(info, 1), Workers(1)).ok());
  CHECK(ping_is_finished(folder.path(), 0, 1, info));
  CHECK_FALSE(ping_is_finished(folder.path(), 0, 0, info));

  const fs::path file = folder.path() / kSequence / "polar/000001_semantic.png";
  const fs::path record = folder.path() / layout::record_path(0, 1);
  SECTION("a file cut short") { fs::resize_file(file, fs::file_size(file) - 1); }
  SECTION("a file missing") { fs::remove(file); }
  SECTION("a link in place of a file") {
    fs::rename(file, folder.path() / "elsewhere");
    fs::create_symlink(folder.path() / "elsewhere", file);
  }
  SECTION("record missing") { fs::remove(record); }
  SECTION("another digit in the record") {
    std::string text = sample::read(record);
    const std::size_t digit = text.find_first_of("0123456789", text.find("first_return_m"));
    text[digit] = text[digit] == '1' ? '2' : '1';
    sample::write(record, text);
  }
  SECTION("record without its hash") {
    const std::string text = sample::read(record);
    sample::write(record, text.substr(0, text.find('\n') + 1));
  }
  SECTION("record cut short") { fs::resize_file(record, fs::file_size(record) / 2); }
  SECTION("record of another ping") {
    fs::rename(record, folder.path() / layout::record_path(0, 0));
  }
  CHECK_FALSE(ping_is_finished(folder.path(), 0, 1, info));
  CHECK_FALSE(ping_is_finished(folder.path(), 0, 0, info));
}

// Protects "no file of a sequence is ever overwritten": a finished ping is left alone.
TEST_CASE("writing a finished ping again does nothing") {
  const sample::TemporaryFolder folder;
  const auto info = sample::sequence_info(0);
  REQUIRE(write_ping(folder.path(), info, sample::ping_result(info, 1), Workers(1)).ok());
  const auto before = sample::contents(folder.path());
  auto other = sample::ping_result(info, 1);
  other.series[0] = 99;
  other.time_s = 5;
  REQUIRE(write_ping(folder.path(), info, other, Workers(1)).ok());
  CHECK(sample::contents(folder.path()) == before);
}

// Protects independence of threads.
TEST_CASE("a ping's bytes do not depend on the number of threads") {
  const sample::TemporaryFolder one, many;
  const auto info = sample::sequence_info(0);
  REQUIRE(write_ping(one.path(), info, sample::ping_result(info, 1), Workers(1)).ok());
  REQUIRE(write_ping(many.path(), info, sample::ping_result(info, 1), Workers(4)).ok());
  CHECK(sample::contents(one.path()) == sample::contents(many.path()));
}

// Protects against pictures of the wrong size, which a reader would only notice much later.
TEST_CASE("a result that does not fit its sequence is a bug and writes nothing") {
  const sample::TemporaryFolder folder;
  const auto info = sample::sequence_info(0);
  auto result = sample::ping_result(info, 1);
  SECTION("series") { result.series.pop_back(); }
  SECTION("no polar picture") { result.polar.reset(); }
  SECTION("a layer too short") { result.polar->clean_db.pop_back(); }
  SECTION("transposed") { std::swap(result.cartesian->rows, result.cartesian->columns); }
  SECTION("grey") { result.polar_grey->pixels.pop_back(); }
  SECTION("no grey at all") {
    result.polar_grey.reset();
    result.cartesian_grey.reset();
  }
  SECTION("amplitudes") { result.amplitudes.pop_back(); }
  SECTION("first return") { result.first_return_m.pop_back(); }
  SECTION("a ping that the sequence does not have") { result.ping = sample::kPings; }
  check_fails(write_ping(folder.path(), info, result, Workers(1)), ErrorKind::bug);
  CHECK(sample::contents(folder.path()).empty());
}

// Protects the exit status 4 and the absence of a record when a file could not be written.
TEST_CASE("a ping that cannot be written is an io error without a record") {
  const sample::TemporaryFolder folder;
  const auto info = sample::sequence_info(0);
  sample::write(folder.path() / kSequence / "polar", "a file in place of the folder");
  check_fails(write_ping(folder.path(), info, sample::ping_result(info, 1), Workers(2)),
              ErrorKind::io, {"polar/000001"});
  CHECK_FALSE(ping_is_finished(folder.path(), 0, 1, info));
}
