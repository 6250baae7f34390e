// The pixels that a render shows of an image: windows in range, blocks and maps.
#include "render/part.h"

#include "catch.h"
#include "results.h"

using namespace ensonify;

namespace {

// Samples at 1, 1.5, ... 4 m.
StoredSequence sequence_of(std::uint64_t samples = 7, std::uint64_t beams = 5) {
  StoredSequence sequence;
  sequence.samples = samples;
  sequence.beams = beams;
  sequence.first_range_m = 1;
  sequence.range_step_m = 0.5;
  return sequence;
}

SequencePart part_of(const ShownPart& shown) {
  return value_of(sequence_part(shown, sequence_of()));
}

std::string error_of(const ShownPart& shown) {
  return message_of(sequence_part(shown, sequence_of()));
}

}  // namespace

// Protects the window: both of its ends belong to it.
TEST_CASE("a window holds the samples within its ranges", "[part]") {
  const SequencePart part = part_of({{{1.5, 3}}, 1, 1, Decimation::pick});
  CHECK(part.first == 1);
  CHECK(part.end == 5);
  CHECK(part.polar.top_px == 1);
  CHECK(part.polar.height_px == 4);
  CHECK(part.polar.width_px == 5);
  CHECK(part_of({{{0, 99}}, 1, 1, Decimation::pick}).rows == 7);
  CHECK(contains(error_of({{{1.6, 1.9}}, 1, 1, Decimation::pick}), "1.00 to 4.00 m"));
  CHECK(contains(error_of({{{4.1, 9}}, 1, 1, Decimation::pick}), "no sample"));
}

// Protects both kinds of decimation, and the last block, which is smaller and has a middle of its
// own: of two pixels the nearer one, and the one to starboard.
TEST_CASE("blocks show their middle or their loudest pixel", "[part]") {
  std::vector<float> level_db(7 * 5, 10);
  level_db[2 * 5 + 4] = 60;  // block (0, 1) of samples 1 to 3 and beams 3 and 4
  level_db[1 * 5 + 3] = 50;
  level_db[5 * 5 + 1] = 70;  // block (1, 0), whose samples are 4 and 5
  level_db[6 * 5 + 1] = 99;  // beyond the window
  ShownPart shown{{{1.5, 3.5}}, 3, 3, Decimation::max};
  const SequencePart loudest = part_of(shown);
  CHECK(loudest.rows == 2);
  CHECK(loudest.columns == 2);
  const auto pixels = block_pixels(loudest, level_db);
  CHECK(pixels == std::vector<std::uint32_t>{5, 14, 26, 23});
  shown.decimation = Decimation::pick;
  const SequencePart middle = part_of(shown);
  CHECK(block_pixels(middle, level_db) == std::vector<std::uint32_t>{11, 13, 21, 23});
  const auto levels = held(loudest, pixels, level_db);
  CHECK(levels[3 * 5 + 3] == 60);
  CHECK(levels[1 * 5 + 4] == 60);
  CHECK(levels[4 * 5 + 2] == 70);
  CHECK(levels[6 * 5 + 1] == 99);
  CHECK(levels[0] == 10);
  CHECK(contains(error_of({{}, 8, 1, Decimation::pick}), "have 7 samples"));
  CHECK(contains(error_of({{}, 1, 6, Decimation::pick}), "have 5 beams"));
}

// Protects the gain of decimated rows.
TEST_CASE("rows have the gain of the middle of their block", "[part]") {
  const DisplayTable table = display_table({}, 0, 0.5, 7, 1);
  DisplayTable rising = table;
  for (std::size_t i = 0; i < 7; ++i) rising.tvg_db[i] = static_cast<double>(i);
  const DisplayTable cut = part_of_table(rising, part_of({{{1.5, 4}}, 4, 1, Decimation::pick}));
  CHECK(cut.tvg_db == std::vector<double>{2, 5});
}

// Protects Cartesian images of a part: what is outside of the window is cut off or black.
TEST_CASE("maps are cut to the window and name pixels of the render", "[part]") {
  StoredSequence sequence = sequence_of();
  sequence.cartesian_height = 3;
  sequence.cartesian_width = 4;
  // Sample * 5 + beam; rows from far to near.
  const std::vector<std::int32_t> map = {-1, 32, 30, -1,  //
                                         18, 12, 11, 10,  //
                                         -1, 6,  1,  -1};
  SequencePart part = part_of({{{1.5, 2.5}}, 2, 2, Decimation::pick});
  const auto cut_map = value_of(part_of_map(part, map, sequence));
  CHECK(part.cartesian.top_px == 1);
  CHECK(part.cartesian.left_px == 0);
  // Samples 1 and 2 are row 0 of three columns, sample 3 is row 1; pixel 1 is of sample 0.
  CHECK(cut_map == std::vector<std::int32_t>{4, 1, 0, 0, -1, 0, -1, -1});
  GreyImage image{3, 4, {}};
  for (std::uint8_t i = 1; i <= 12; ++i) image.pixels.push_back(i);
  const GreyImage shown = cut(part, image, cut_map);
  CHECK(shown.rows == 2);
  CHECK(shown.pixels == std::vector<std::uint8_t>{5, 6, 7, 8, 0, 10, 0, 0});
  SequencePart nothing = part_of({{{3, 3.5}}, 1, 1, Decimation::pick});
  check_fails(part_of_map(nothing, map, sequence), {"--view polar"});
}
