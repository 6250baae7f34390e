#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "compare/read_pings.h"
#include "formats/files.h"
#include "formats/jpeg.h"
#include "formats/png.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

constexpr std::uint32_t kLeastSide = 24;
constexpr std::uint64_t kMostFileBytes = std::uint64_t{1} << 28;
constexpr std::size_t kCropBlocks = 10;

enum class ImageFile { none, png, jpeg };

ImageFile kind_of(const std::string& path) {
  std::string end = fs::path(path).extension().string();
  std::transform(end.begin(), end.end(), end.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (end == ".png") return ImageFile::png;
  return end == ".jpg" || end == ".jpeg" ? ImageFile::jpeg : ImageFile::none;
}

Result<Crops::Crop> read_crop(const fs::path& path, double gamma) {
  const auto bytes = read_file(path, kMostFileBytes);
  if (!bytes) return bytes.error();
  Crops::Crop crop;
  if (kind_of(path.string()) == ImageFile::png) {
    auto image = parse_bright_png(*bytes);
    if (!image) return Error{ErrorKind::usage, path.string() + ": " + image.error().message};
    crop.rows = static_cast<int>(image->rows);
    crop.columns = static_cast<int>(image->columns);
    crop.amplitude = std::move(image->brightness);
  } else {
    const auto image = parse_grey_jpeg(*bytes);
    if (!image) return Error{ErrorKind::usage, path.string() + ": " + image.error().message};
    crop.rows = static_cast<int>(image->rows);
    crop.columns = static_cast<int>(image->columns);
    for (const std::uint8_t grey : image->grey) {
      crop.amplitude.push_back(static_cast<float>(grey) / 255);
    }
  }
  const auto power = static_cast<float>(1 / gamma);
  if (power != 1) {
    for (float& value : crop.amplitude) value = std::pow(value, power);
  }
  return crop;
}

Result<ReadCrops> read_folder(const CropSource& source, const Workers& workers) {
  auto files = files_below(source.folder);
  if (!files) return files.error();
  std::erase_if(*files, [](const std::string& file) { return kind_of(file) == ImageFile::none; });
  if (files->size() < 2) {
    return Error{ErrorKind::usage, source.folder.string() +
                                       ": is neither a finished data set of ensonify nor a "
                                       "folder with two or more PNG or JPEG files"};
  }
  const auto most = std::min(files->size(), static_cast<std::size_t>(source.amount.images));
  std::vector<Result<Crops::Crop>> read(most, Crops::Crop{});
  workers.for_each(most, [&](std::size_t i) {
    if (source.stop != nullptr && source.stop()) {
      read[i] = Error{ErrorKind::interrupted, "interrupted"};
    } else {
      read[i] = read_crop(source.folder / (*files)[i * files->size() / most], source.gamma);
    }
  });
  ReadCrops result;
  for (auto& crop : read) {
    if (!crop) return crop.error();
    if (std::min(crop->rows, crop->columns) < static_cast<int>(kLeastSide)) continue;
    result.crops.crops.push_back(std::move(*crop));
  }
  const std::size_t count = result.crops.crops.size();
  if (count < most) {
    result.notes.push_back(
        fmt::format("{}: {} of {} images have fewer than {} rows or columns and "
                    "are not used",
                    source.folder.string(), most - count, most, kLeastSide));
  }
  if (count < 2) {
    return Error{ErrorKind::usage,
                 fmt::format("{}: has fewer than two images of {} x {} pixels or more",
                             source.folder.string(), kLeastSide, kLeastSide)};
  }
  const auto blocks =
      source.amount.blocks > 0 ? static_cast<std::size_t>(source.amount.blocks) : kCropBlocks;
  std::uint32_t block = 0;
  for (const std::size_t size : block_sizes(count, blocks)) {
    result.crops.block.insert(result.crops.block.end(), size, block++);
  }
  return result;
}

}  // namespace

Result<ReadCrops> read_crops(const CropSource& source, const Workers& workers) {
  return without_exceptions("reading " + source.folder.string(),
                            [&] { return read_folder(source, workers); });
}

}  // namespace ensonify
