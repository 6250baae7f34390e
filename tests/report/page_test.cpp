// What a page shows is what the data set holds.
#include <cmath>

#include "catch.h"
#include "core/units.h"
#include "dataset/read_pictures.h"
#include "report/page.h"
#include "report/survey.h"
#include "results.h"

namespace ensonify {
namespace {

using test::Page;
using test::Picture;
using test::TemporaryFolder;
using PageJson = nlohmann::json;

StoredPixels pixels_of(const test::OpenSet& set, std::size_t sequence, std::uint32_t ping) {
  const StoredSequence& stored = set.sequences.at(sequence);
  return value_of(read_picture(set.dataset, stored, ImageView::polar, ping,
                               stored_planes(stored, ImageView::polar)));
}

// Mean of |shown - stored| over pixels between the limits of the codes, dB.
double level_error_db(const Page& page, const PageJson& number, const std::vector<float>& level_db) {
  const Picture picture = test::picture_at(page, number);
  REQUIRE(picture.pixels.size() == level_db.size());
  const double low = page.json.at("scale").at("min_db"), high = page.json.at("scale").at("max_db");
  double sum = 0, n = 0;
  for (std::size_t i = 0; i < level_db.size(); ++i) {
    if (level_db[i] < low + 5 || level_db[i] > high) continue;
    const double shown = low + (picture.pixels[i][1] - 1) / 254.0 * (high - low);
    sum += std::abs(shown - static_cast<double>(level_db[i]));
    ++n;
  }
  REQUIRE(n > 0);
  return sum / n;
}

// Protects the pictures: ids exact, levels as near as a lossy code of the best quality is.
TEST_CASE("pictures of a page are those of the data set") {
  const TemporaryFolder folder;
  const auto path = test::make_set(folder, "set", test::kScene);
  const auto set = test::open_set(path);
  const Page page = test::page_of(path);
  REQUIRE(page.json.at("pings").size() == 4);
  for (const PageJson& ping : page.json.at("pings")) {
    const StoredPixels pixels = pixels_of(set, 0, ping.at("ping"));
    const PageJson& pictures = ping.at("pictures");
    CHECK(level_error_db(page, pictures.at("level"), pixels.level_db) < 1.0);
    CHECK(level_error_db(page, pictures.at("clean"), pixels.clean_db) < 1.0);
    const Picture labels = test::picture_at(page, pictures.at("labels"));
    const Picture shadow = test::picture_at(page, pictures.at("shadow"));
    const Picture elevation = test::picture_at(page, pictures.at("elevation"));
    REQUIRE(labels.width == 48);
    REQUIRE(labels.pixels.size() == pixels.instance.size());
    const double least = page.json.at("elevation").at("min_rad");
    const double most = page.json.at("elevation").at("max_rad");
    std::size_t wrong = 0, shadowed = 0;
    for (std::size_t i = 0; i < pixels.instance.size(); ++i) {
      const auto [r, g, b] = labels.pixels[i];
      wrong += pixels.instance[i] != r + 256 * g || pixels.semantic[i] != b;
      wrong += pixels.shadow[i] != shadow.pixels[i][0] + 256 * shadow.pixels[i][1];
      shadowed += pixels.shadow[i] != 0;
      const int code = elevation.pixels[i][1];
      wrong += std::isnan(pixels.elevation_rad[i]) != (code == 0);
      if (code == 0) continue;
      const double shown = least + (code - 1) / 254.0 * (most - least);
      wrong +=
          std::abs(shown - static_cast<double>(pixels.elevation_rad[i])) > 0.01 * (most - least);
    }
    CHECK(wrong == 0);
    CHECK(shadowed > 10);
  }
}

// Protects an overlay that most data sets do not have: ids exact, null without multipath.
TEST_CASE("masks of multipath echoes on a page are those of the data set") {
  const TemporaryFolder folder;
  const auto path = test::make_set(folder, "set", test::kScene,
                                   {{"multipath", "{surface: {z_m: 0.5, reflection: -1}}"}});
  const auto set = test::open_set(path);
  const Page page = test::page_of(path);
  std::size_t wrong = 0, marked = 0;
  for (const PageJson& ping : page.json.at("pings")) {
    const StoredPixels pixels = pixels_of(set, 0, ping.at("ping"));
    const Picture multipath = test::picture_at(page, ping.at("pictures").at("multipath"));
    REQUIRE(multipath.pixels.size() == pixels.multipath.size());
    for (std::size_t i = 0; i < pixels.multipath.size(); ++i) {
      const auto [r, g, b] = multipath.pixels[i];
      wrong += pixels.multipath[i] != r + 256 * g;
      marked += pixels.multipath[i] != 0;
    }
  }
  CHECK(wrong == 0);
  CHECK(marked > 10);
  const Page direct = test::page_of(test::make_set(folder, "direct", test::kScene));
  CHECK(direct.json.at("pings").at(0).at("pictures").at("multipath").is_null());
}

std::int16_t hundredths_at(const std::string& bytes, std::size_t i) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(bytes.at(k)); };
  return static_cast<std::int16_t>(byte(2 * i) | byte(2 * i + 1) << 8);
}

TEST_CASE("the beam that is told exactly is that of the smallest object") {
  const TemporaryFolder folder;
  const auto path = test::make_set(folder, "set", test::kScene);
  const auto set = test::open_set(path);
  const Page page = test::page_of(path);
  const PageJson& ping = page.json.at("pings").at(1);
  const StoredPixels pixels = pixels_of(set, 0, 1);
  const std::size_t beam = ping.at("beam").at("beam");
  // The strongest expected echo of the ball, which is instance 2.
  std::size_t best = 0;
  float best_db = -1000;
  for (std::size_t i = 0; i < pixels.instance.size(); ++i) {
    if (pixels.instance[i] != 2 || !(pixels.clean_db[i] > best_db)) continue;
    best = i;
    best_db = pixels.clean_db[i];
  }
  CHECK(beam == best % 48);
  const std::string& levels = page.chunks.at(ping.at("beam").at("level_db").get<std::size_t>());
  REQUIRE(levels.size() == 2 * pixels.rows);
  for (std::size_t sample = 0; sample < pixels.rows; ++sample) {
    const float level_db = pixels.level_db[sample * 48 + beam];
    const int expected =
        level_db > kNoEnergyDb ? static_cast<int>(std::lround(level_db * 100)) : -32768;
    CHECK(hundredths_at(levels, sample) == expected);
  }
}

// Protects the tables: they come from run lengths in annotations.jsonl, these from the masks.
TEST_CASE("counts over all pings are those of the masks") {
  const TemporaryFolder folder;
  const auto path = test::make_set(folder, "set", test::kScene, {{"trajectory.pings", "9"}});
  const auto set = test::open_set(path);
  const Page page = test::page_of(path, 3);
  CHECK(page.json.at("totals").at("pings") == 9);
  REQUIRE(page.json.at("pings").size() == 3);
  CHECK(page.json.at("pings").at(1).at("ping") == 4);
  std::vector<std::uint64_t> pixels(3), pictures(3);
  std::vector<double> rows(3);
  std::vector<std::vector<std::uint64_t>> ranges(3);
  const auto edges = page.json.at("ranges").at("edges_m").get<std::vector<double>>();
  for (auto& r : ranges) r.resize(edges.size() - 1);
  for (std::uint32_t ping = 0; ping < 9; ++ping) {
    const StoredPixels picture = pixels_of(set, 0, ping);
    std::vector<std::uint64_t> here(3);
    std::vector<double> range_sum(3);
    for (std::size_t i = 0; i < picture.semantic.size(); ++i) {
      ++here[picture.semantic[i]];
      range_sum[picture.semantic[i]] +=
          static_cast<double>(i / picture.columns) * set.sequences[0].range_step_m;
    }
    for (std::size_t k = 1; k < 3; ++k) {
      pixels[k] += here[k];
      pictures[k] += here[k] > 0;
      const double range_m = range_sum[k] / static_cast<double>(here[k]);
      ++ranges[k][static_cast<std::size_t>(range_m / edges[1])];
    }
  }
  for (std::size_t k = 1; k < 3; ++k) {
    const PageJson& count = page.json.at("counts").at(k - 1);
    CHECK(count.at("class") == set.dataset.classes[k - 1]);
    CHECK(count.at("instances") == 1);
    CHECK(count.at("pixels") == pixels[k]);
    CHECK(count.at("pictures") == pictures[k]);
    CHECK(page.json.at("ranges").at("counts").at(set.dataset.classes[k - 1]) == ranges[k]);
  }
  CHECK(page.json.at("pings").at(2).at("seen").size() == 2);
  CHECK(page.json.at("pings").at(2).at("boxes").size() == 2);
}

TEST_CASE("few of many are the first, the last and others evenly between") {
  CHECK(spread(3, 200) == std::vector<std::uint64_t>{0, 1, 2});
  CHECK(spread(0, 5).empty());
  CHECK(spread(9, 1) == std::vector<std::uint64_t>{0});
  CHECK(spread(9, 3) == std::vector<std::uint64_t>{0, 4, 8});
  const auto some = spread(100'000, 200);
  REQUIRE(some.size() == 200);
  CHECK(some.front() == 0);
  CHECK(some.back() == 99'999);
  for (std::size_t i = 1; i < some.size(); ++i) {
    const std::uint64_t step = some[i] - some[i - 1];
    CHECK((step == 502 || step == 503));
  }
}

TEST_CASE("the bytes of a page do not depend on the threads") {
  const TemporaryFolder folder;
  const auto path = test::make_set(folder, "set", test::kScene);
  CHECK(test::page_of(path, 200, 1).text == test::page_of(path, 200, 4).text);
}

// Protects who opens the page of another's data set: names are text, and never markup.
TEST_CASE("a name cannot end the script that it stands in") {
  const TemporaryFolder folder;
  const std::string name = "</script><script>alert(1)</script><!--";
  const auto path = test::make_set(folder, "set", test::kScene,
                                   {{"objects.1.class", "\"" + name + "\""},
                                    {"objects.1.name", "\"" + name + "\""},
                                    {"name", "\"<!--<script>\""}});
  const Page page = test::page_of(path);
  CHECK(page.json.at("classes").at(1) == name);
  CHECK(page.json.at("sequences").at(0).at("instances").at(1).at("name") == name);
  CHECK(page.json.at("name") == "<!--<script>");
  CHECK_FALSE(contains(page.text, "<script>alert"));
  CHECK_FALSE(contains(page.text, "<!--<script>"));
}

}  // namespace
}  // namespace ensonify
