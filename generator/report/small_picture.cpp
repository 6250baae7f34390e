#include "report/small_picture.h"

#include <algorithm>
#include <cmath>

#include "formats/webp.h"

namespace ensonify {
namespace {

constexpr int kPictureQuality = 75;

}  // namespace

bool has_levels(const StoredSequence& sequence) {
  return stored_planes(sequence, ImageView::polar).contains("level_db") || has_series(sequence);
}

Result<std::vector<float>> levels_of_ping(const StoredDataset& dataset, const ShownSequence& shown,
                                          std::uint32_t ping, const Workers& workers) {
  Survey survey;
  survey.sequences.push_back(shown);
  auto pixels = pixels_of({dataset, survey, workers}, {0, ping, 0, {}, {}, {}});
  if (!pixels) return pixels.error();
  return std::move(pixels->level_db);
}

SmallPicture smaller(const ShownSequence& shown, const std::vector<float>& level_db,
                     std::size_t side) {
  const StoredSequence& sequence = shown.stored;
  const Blocks down(sequence.samples, side), across(sequence.beams, side);
  SmallPicture picture;
  picture.rows = down.count;
  picture.columns = across.count;
  picture.range_step_m = sequence.range_step_m * static_cast<double>(down.size);
  picture.first_range_m =
      sequence.first_range_m + (static_cast<double>(down.size) - 1) / 2 * sequence.range_step_m;
  for (std::size_t column = 0; column < across.count; ++column) {
    picture.azimuth_rad.push_back(across.mean(shown.facts.azimuth_rad, column));
  }
  picture.level_db.assign(down.count * across.count, kNoEnergyDb);
  for (std::size_t sample = 0; sample < down.all; ++sample) {
    for (std::size_t beam = 0; beam < across.all; ++beam) {
      float& pixel = picture.level_db[sample / down.size * across.count + beam / across.size];
      pixel = std::max(pixel, level_db[sample * across.all + beam]);
    }
  }
  return picture;
}

Result<Json> picture_json(const SmallPicture& picture, const PictureScale& scale, Chunks& chunks) {
  std::vector<std::uint8_t> codes;
  for (const float db : picture.level_db) {
    codes.push_back(db > kNoEnergyDb ? grey_code(db, scale.min_db, scale.max_db) : std::uint8_t{0});
  }
  auto webp = lossy_grey(codes, static_cast<int>(picture.columns), static_cast<int>(picture.rows),
                         kPictureQuality);
  if (!webp) return webp.error();
  Json azimuth = Json::array();
  for (const double rad : picture.azimuth_rad) azimuth.push_back(std::round(rad * 1e6) / 1e6);
  return Json{{"level", chunks.add(std::move(*webp))},
              {"beams", picture.columns},
              {"samples", picture.rows},
              {"azimuth_rad", std::move(azimuth)},
              {"range_step_m", picture.range_step_m},
              {"first_range_m", picture.first_range_m}};
}

}  // namespace ensonify
