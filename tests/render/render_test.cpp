#include "render/render.h"

#include <atomic>
#include <filesystem>
#include <limits>

#include "../dataset/damage.h"
#include "../dataset/sample.h"
#include "catch.h"
#include "dataset/overwrite.h"
#include "dataset/render_manifest.h"
#include "dataset/verify.h"
#include "formats/png.h"
#include "labels/display.h"
#include "results.h"

using namespace ensonify;
using damage::faults;
using damage::mentions;
namespace fs = std::filesystem;

namespace {

RenderOptions options_of(const fs::path& dir, const std::string& name) {
  RenderOptions options;
  options.dataset = dir;
  options.name = name;
  options.threads = 2;
  options.program_version = "0.1.0";
  options.program_commit = "abcdef";
  return options;
}

RenderReport rendered(const RenderOptions& options) { return value_of(render_dataset(options)); }

void refused(const RenderOptions& options, const std::string& what) {
  check_fails(render_dataset(options), {what});
}

struct Sample {
  sample::TemporaryFolder folder;
  const fs::path dir = folder.path() / "set";
  Sample() { sample::make_dataset(dir, 2); }
};

// Without what renders add.
std::map<std::string, std::string> own_files(const fs::path& dir) {
  auto files = sample::contents(dir);
  std::erase_if(files, [](const auto& file) { return file.first.starts_with("renders/"); });
  return files;
}

}  // namespace

// Protects the formula from the stored levels to the pixel, the map, and the data set itself.
TEST_CASE("a render shows the stored levels and leaves the data set as it is") {
  const Sample set;
  const auto before = own_files(set.dir);
  RenderOptions options = options_of(set.dir, "loud");
  options.limits_db = {{70, 110}};
  options.display.gain_db = 5;
  options.display.resampling = Resampling::nearest;
  const RenderReport report = rendered(options);
  CHECK(report.sequences == 2);
  CHECK(report.pings == 2 * sample::kPings);
  CHECK(own_files(set.dir) == before);
  CHECK(faults(set.dir).empty());
  const SequenceInfo info = sample::sequence_info(1);
  const LabelledImage polar = sample::image(sample::kSamples, sample::kBeams, 12);
  const std::vector<std::int32_t> map = sample::cartesian_map(info);
  const fs::path images = set.dir / "renders/loud/sequences/000001";
  const auto gray = read_grey8(images / "000002_polar.png", sample::kSamples, sample::kBeams);
  const auto seen = read_grey8(images / "000002_cartesian.png", 7, 8);
  REQUIRE(gray.ok());
  REQUIRE(seen.ok());
  std::size_t different = 0, lit = 0;
  for (std::size_t i = 0; i < gray->size(); ++i) {
    const float level = polar.level_db[i];
    const double value = level > -99 ? 255 * (level + 5.0 - 70) / 40 : 0;
    different += (*gray)[i] != std::floor(std::clamp(value, 0.0, 255.0) + 0.5);
    lit += (*gray)[i] > 0;
  }
  CHECK(different == 0);
  CHECK(lit > 10);
  for (std::size_t i = 0; i < seen->size(); ++i) {
    different += (*seen)[i] != (map[i] < 0 ? 0 : (*gray)[static_cast<std::size_t>(map[i])]);
  }
  CHECK(different == 0);
}

// Protects the choice of the resampling, which the manifest names.
TEST_CASE("renders are bilinear unless nearest is asked for") {
  const Sample set;
  RenderOptions options = options_of(set.dir, "smooth");
  options.limits_db = {{70, 110}};
  rendered(options);
  options.name = "nearest";
  options.display.resampling = Resampling::nearest;
  rendered(options);
  const fs::path renders = set.dir / "renders";
  CHECK(contains(sample::read(renders / "smooth/render.json"), R"("resampling": "bilinear")"));
  CHECK(contains(sample::read(renders / "nearest/render.json"), R"("resampling": "nearest")"));
  const auto image = [&](const char* name, const char* file) {
    return sample::read(renders / name / "sequences/000001" / file);
  };
  CHECK(image("smooth", "000002_polar.png") == image("nearest", "000002_polar.png"));
  CHECK(image("smooth", "000002_cartesian.png") != image("nearest", "000002_cartesian.png"));
  CHECK(faults(set.dir).empty());
}

// Protects renders of untrusted data sets from work without end; all hashes are right.
TEST_CASE("a grid that is larger than its fan is refused unless images are nearest") {
  const Sample set;
  damage::reseal(set.dir, "sequences/000000/sequence.json", "\"metres_per_pixel\": 0.03",
                 "\"metres_per_pixel\": 3e+99");
  RenderOptions options = options_of(set.dir, "a");
  refused(options, "larger than its fan");
  options.display.resampling = Resampling::nearest;
  rendered(options);
}

// Protects renders from depending on the machine: every option on, any number of threads.
TEST_CASE("renders have the same bytes on any number of threads") {
  const Sample set;
  RenderOptions options = options_of(set.dir, "one");
  options.display = {GreyScale::amplitude, 0.5, 3, 20, true, true, {}, "magma", Flip::both};
  options.threads = 1;
  rendered(options);
  const auto one = sample::contents(set.dir / "renders/one");
  CHECK(one.size() == 2 * 2 * sample::kPings + 1);
  for (const int threads : {2, 5}) {
    options.overwrite = true;
    options.threads = threads;
    rendered(options);
    CHECK(sample::contents(set.dir / "renders/one") == one);
  }
  CHECK(faults(set.dir).empty());
}

// Protects what is there from a second render, and lets one that was cut off be repeated.
TEST_CASE("a render is replaced on request only, and begun anew after an interrupt") {
  const Sample set;
  RenderOptions options = options_of(set.dir, "a");
  rendered(options);
  const auto whole = sample::contents(set.dir);
  refused(options, "--overwrite");
  CHECK(sample::contents(set.dir) == whole);
  options.overwrite = true;
  std::atomic<int> asked = 0;
  options.stop = [&] { return ++asked > 3; };
  CHECK(render_dataset(options).error().kind == ErrorKind::interrupted);
  CHECK(mentions(faults(set.dir), "renders/a: is incomplete"));
  options.overwrite = false;
  options.stop = nullptr;
  rendered(options);
  CHECK(sample::contents(set.dir) == whole);
}

TEST_CASE("files of others in a render's place stay") {
  const Sample set;
  sample::write(set.dir / "renders/a/notes.txt", "mine");
  refused(options_of(set.dir, "a"), "not a file of a render");
  CHECK(sample::read(set.dir / "renders/a/notes.txt") == "mine");
}

// Protects verify's promise: every byte is as some manifest says.
TEST_CASE("verify looks at renders") {
  const Sample set;
  rendered(options_of(set.dir, "a"));
  REQUIRE(faults(set.dir).empty());
  const fs::path image = set.dir / "renders/a/sequences/000000/000001_polar.png";
  const std::string bytes = sample::read(image);
  sample::flip_bit(image, bytes.size() / 2, 3);
  CHECK(mentions(faults(set.dir),
                 "renders/a/sequences/000000/000001_polar.png: does not have the listed SHA-256"));
  fs::remove(image);
  CHECK_FALSE(faults(set.dir).empty());
  sample::write(image, bytes);
  sample::write(set.dir / "renders/a/sequences/000000/000009_polar.png", bytes);
  CHECK(mentions(faults(set.dir), "000009_polar.png: is not listed in any manifest"));
  fs::remove(set.dir / "renders/a/sequences/000000/000009_polar.png");
  fs::copy(set.dir / "renders/a", set.dir / "renders/b", fs::copy_options::recursive);
  CHECK(mentions(faults(set.dir), "does not have the name of its folder"));
}

// Protects `generate --overwrite`: renders are of the old data set, and go with it.
TEST_CASE("a render belongs to the data set that --overwrite removes") {
  const Sample set;
  rendered(options_of(set.dir, "a"));
  const auto inventory = value_of(take_inventory(set.dir));
  CHECK(inventory.strangers.empty());
  REQUIRE(remove_listed(set.dir, inventory).ok());
  CHECK_FALSE(fs::exists(set.dir / "renders"));
}

TEST_CASE("what cannot be rendered is refused before anything is written") {
  const Sample set;
  RenderOptions options = options_of(set.dir, "a");
  options.display.gamma = 2;
  refused(options, "use it with --scale amplitude");
  options = options_of(set.dir, "a");
  options.limits_db = {{10, 10}};
  refused(options, "the lower limit comes first");
  options = options_of(set.dir, "a");
  options.sequences = {7, 9};
  refused(options, "none of these sequences");
  for (const char* name : {"", ".a", "a/b", "..", "\xc3\xa4"}) {
    refused(options_of(set.dir, name), "--name");
  }
  refused(options_of(set.folder.path() / "none", "a"), "no such folder");
  CHECK_FALSE(fs::exists(set.dir / "renders"));
}

// Protects default limits: those of the data set's own images, unless the gain over range differs.
TEST_CASE("limits come from the data set, or from its levels with another time-varied gain") {
  const Sample set;
  CHECK(rendered(options_of(set.dir, "a")).display.limits_db == std::array<double, 2>{60, 120});
  RenderOptions options = options_of(set.dir, "b");
  options.display.spreading = 20;
  EchoLevels levels;
  const SequenceInfo info = sample::sequence_info(0);
  const auto table = display_table(options.display, info.water.absorption_db_m,
                                   sample_range_m(info.sonar, info.water, 1), sample::kSamples);
  for (const int variant : {0, 10}) {
    const auto image = sample::image(sample::kSamples, sample::kBeams, variant);
    levels.add(echo_levels(table, image, info.noise_power_pa2));
  }
  CHECK(rendered(options).display.limits_db == default_limits_db(levels));
}

// Protects renders with fewer pixels: their manifest has the place, and verify the size.
TEST_CASE("a part of the pixels is rendered and verified") {
  const Sample set;
  RenderOptions options = options_of(set.dir, "part");
  options.part.samples = 2;
  options.part.decimation = Decimation::max;
  options.limits_db = {{70, 110}};
  options.display.flip = Flip::both;
  options.view = ImageView::polar;
  rendered(options);
  const fs::path images = set.dir / "renders/part/sequences/000001";
  const int rows = (sample::kSamples + 1) / 2;
  const auto gray = value_of(
      read_grey8(images / "000002_polar.png", static_cast<std::uint64_t>(rows), sample::kBeams));
  const LabelledImage polar = sample::image(sample::kSamples, sample::kBeams, 12);
  std::size_t different = 0;
  for (int row = 0; row < rows; ++row) {
    for (int beam = 0; beam < sample::kBeams; ++beam) {
      const auto at = [&](int sample) {
        return polar.level_db[static_cast<std::size_t>(sample * sample::kBeams + beam)];
      };
      const float level = std::max(at(2 * row), at(std::min(2 * row + 1, sample::kSamples - 1)));
      const double value = level > -99 ? 255 * (level - 70.0) / 40 : 0;
      const int from_end = (rows - row) * sample::kBeams - 1 - beam;
      different += gray[static_cast<std::size_t>(from_end)] !=
                   std::floor(std::clamp(value, 0.0, 255.0) + 0.5);
    }
  }
  CHECK(different == 0);
  CHECK(faults(set.dir).empty());
  options.view = {};
  options.name = "both";
  rendered(options);
  CHECK(faults(set.dir).empty());
  const fs::path manifest = set.dir / "renders/both/render.json";
  std::string text = sample::read(manifest);
  text.replace(text.find("\"left_px\": 0"), 12, "\"left_px\": 1");
  sample::write(manifest, text);
  CHECK(mentions(faults(set.dir), "shows pixels that sequence 0 does not have"));
}

// Protects JPEG files: their names, their place in an overwritten render, and verify.
TEST_CASE("a render can be of JPEG files") {
  const Sample set;
  RenderOptions options = options_of(set.dir, "a");
  rendered(options);
  options.jpeg_quality = 90;
  options.overwrite = true;
  rendered(options);
  const fs::path images = set.dir / "renders/a/sequences/000001";
  CHECK_FALSE(fs::exists(images / "000002_polar.png"));
  const std::string bytes = sample::read(images / "000002_polar.jpg");
  CHECK(bytes.starts_with("\xff\xd8"));
  CHECK(faults(set.dir).empty());
  options.jpeg_quality = 0;
  rendered(options);
  CHECK_FALSE(fs::exists(images / "000002_polar.jpg"));
}

TEST_CASE("what a part or JPEG files cannot be is refused") {
  const Sample set;
  RenderOptions options = options_of(set.dir, "a");
  options.jpeg_quality = 90;
  options.display.color_map = "magma";
  refused(options, "leave out --jpeg-quality or --color-map");
  options = options_of(set.dir, "a");
  options.part.range_m = {{3, 2}};
  refused(options, "FROM less than TO");
  options.part.range_m = {{0, std::numeric_limits<double>::infinity()}};
  refused(options, "FROM less than TO");
  options.part.range_m = {{1e4, 2e4}};
  refused(options, "holds no sample");
  options.part.range_m = {};
  options.part.decimation = Decimation::max;
  refused(options, "use it with --every-sample");
  options.part.beams = sample::kBeams + 1;
  refused(options, "--every-beam");
  CHECK_FALSE(fs::exists(set.dir / "renders"));
}
