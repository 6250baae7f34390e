// Data sets of every kind have a page.
#include <cmath>
#include <set>

#include "catch.h"
#include "formats/bytes.h"
#include "report/page.h"
#include "report/pictures.h"
#include "results.h"

namespace ensonify {
namespace {

using test::Page;
using test::TemporaryFolder;
using PageJson = nlohmann::json;

// Chunks of a ping's pictures in place of their numbers.
std::vector<std::string> pictures_of(const Page& page, const PageJson& ping) {
  std::vector<std::string> all;
  for (const auto& [name, number] : ping.at("pictures").items()) {
    all.push_back(name + (number.is_null() ? "" : page.chunks.at(number.get<std::size_t>())));
  }
  return all;
}

TEST_CASE("packed pings have the pictures of those in files") {
  const TemporaryFolder folder;
  const Page files = test::page_of(test::make_set(folder, "files", test::kScene));
  const Page packed = test::page_of(
      test::make_set(folder, "packed", test::kScene, {{"output.one_file_per", "sequence"}}));
  REQUIRE(packed.json.at("pings").size() == 4);
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(pictures_of(packed, packed.json.at("pings").at(i)) ==
          pictures_of(files, files.json.at("pings").at(i)));
  }
  CHECK(packed.json.at("counts") == files.json.at("counts"));
  CHECK(packed.json.at("speckle") == files.json.at("speckle"));
}

TEST_CASE("what a data set has not got is null") {
  const TemporaryFolder folder;
  const Page bare = test::page_of(test::make_set(
      folder, "bare", test::kScene, {{"output.shadow", "false"}, {"output.amodal", "false"}}));
  const PageJson& pictures = bare.json.at("pings").at(0).at("pictures");
  CHECK(pictures.at("shadow").is_null());
  CHECK(pictures.at("labels").is_number());
  CHECK(bare.json.at("pings").at(0).at("seen").at(0).at(2).is_null());

  // Levels of the series, which are those of the pictures but for rounding to halves.
  const Page whole = test::page_of(test::make_set(folder, "whole", test::kScene));
  const Page series =
      test::page_of(test::make_set(folder, "series", test::kScene, {{"output.polar", "false"}}));
  const PageJson& of_series = series.json.at("pings").at(0);
  CHECK(of_series.at("pictures").at("labels").is_null());
  CHECK(of_series.at("pictures").at("clean").is_null());
  CHECK(series.json.at("speckle").is_null());
  const auto a = test::picture_at(series, of_series.at("pictures").at("level"));
  const auto b = test::picture_at(whole, whole.json.at("pings").at(0).at("pictures").at("level"));
  const double scale_a = series.json.at("scale").at("max_db");
  REQUIRE(a.pixels.size() == b.pixels.size());
  double difference = 0;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const double offset = (scale_a - whole.json.at("scale").at("max_db").get<double>()) / 100 * 254;
    difference += std::abs(a.pixels[i][1] + offset - b.pixels[i][1]) / 254 * 100;
  }
  CHECK(difference / static_cast<double>(a.pixels.size()) < 1);

  const Page nothing = test::page_of(test::make_set(
      folder, "nothing", test::kScene,
      {{"output.polar", "false"}, {"output.timeseries", "none"}, {"output.scatterers", "true"}}));
  CHECK(nothing.json.at("pings").size() == 4);
  CHECK(nothing.json.at("pings").at(0).at("pictures").at("level").is_null());
  CHECK(nothing.chunks.empty());
}

TEST_CASE("drawn sequences have sizes, draws and splits of their own") {
  const TemporaryFolder folder;
  const Page page = test::page_of(test::make_set(folder, "drawn", test::kScene,
                                                 {{"sequences", "5"},
                                                  {"sonar.range_max_m", "{choice: [4, 5]}"},
                                                  {"splits", "{train: 0.6, val: 0.2, test: 0.2}"}}),
                                  10);
  const PageJson& sequences = page.json.at("sequences");
  REQUIRE(sequences.size() == 5);
  CHECK(page.json.at("totals") == PageJson({{"sequences", 5}, {"pings", 20}}));
  CHECK(page.json.at("pings").size() == 10);
  std::set<std::uint64_t> sizes;
  for (const PageJson& sequence : sequences) {
    sizes.insert(sequence.at("samples").get<std::uint64_t>());
    CHECK(sequence.at("draws").size() > 0);
    CHECK(sequence.at("azimuth_rad").size() == 48);
  }
  CHECK(sizes.size() == 2);
  for (const PageJson& ping : page.json.at("pings")) {
    const PageJson& sequence = sequences.at(ping.at("sequence").get<std::size_t>());
    CHECK(test::picture_at(page, ping.at("pictures").at("level")).height ==
          sequence.at("samples").get<int>());
    CHECK(ping.at("split") == sequence.at("split"));
  }
  std::uint64_t pings = 0;
  for (const PageJson& split : page.json.at("splits")) {
    pings += split.at("pings").get<std::uint64_t>();
  }
  CHECK(pings == 20);
}

TEST_CASE("statistics without pings are shown as pictures") {
  const TemporaryFolder folder;
  const Page page = test::page_of(test::make_set(
      folder, "statistics", test::kScene,
      {{"output.statistics", "true"}, {"output.pings", "false"}, {"trajectory.pings", "30"}}));
  CHECK(page.json.at("pings").empty());
  CHECK(page.json.at("totals").at("pings") == 30);
  REQUIRE(page.json.at("statistics").size() == 1);
  const PageJson& statistics = page.json.at("statistics").at(0);
  CHECK(statistics.at("realisations") == 30);
  REQUIRE(statistics.at("arrays").size() == 2);
  double sum = 0, n = 0;
  for (const PageJson& array : statistics.at("arrays")) {
    if (array.at("name") != "contrast") continue;
    CHECK(array.at("max") == 2.0);
    for (const auto& [r, g, b] : test::picture_at(page, array.at("chunk")).pixels) {
      if (g == 0) continue;
      sum += (g - 1) / 254.0 * 2;
      ++n;
    }
  }
  // Noise and echoes are Gaussian. Of 30 draws the contrast is biased by less than 0.05.
  CHECK(sum / n == Approx(1).margin(0.1));
}

// Protects the size: what does not fit comes at a lower quality, or with fewer elevations.
TEST_CASE("pictures fit the bytes that they are given") {
  const TemporaryFolder folder;
  const auto path = test::make_set(folder, "set", test::kScene, {{"trajectory.pings", "20"}});
  const auto set = test::open_set(path);
  const Workers workers(2);
  const auto tables = value_of(survey(set.dataset, 200, workers));
  const PictureJob job{set.dataset, tables, workers, nullptr};
  const auto look = value_of(look_at(job));
  const auto bytes_at = [&](std::uint64_t budget, int& quality) {
    Chunks chunks;
    const auto book = value_of(encode_pictures(job, look.scale, budget, chunks));
    quality = book.quality;
    std::uint64_t bytes = 0;
    for (std::size_t i = 0; i < chunks.size(); ++i) bytes += base64_bytes(chunks[i].size());
    return bytes;
  };
  int best = 0, worse = 0;
  const std::uint64_t all = bytes_at(1'000'000'000, best);
  CHECK(best == 90);
  const std::uint64_t budget = all * 2 / 3;
  CHECK(bytes_at(budget, worse) <= budget * 103 / 100);
  CHECK(worse < best);
  CHECK(worse > 1);
}

}  // namespace
}  // namespace ensonify
