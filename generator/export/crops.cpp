// An image of each object: SPLIT/CLASS/SSSSSS_PPPPPP_IIIII.png, by sequence, ping and instance, cut
// out of the 8-bit display image around the object's box. The folders are those that ImageFolder
// of torchvision reads.
#include <fmt/format.h>

#include <algorithm>

#include "dataset/mask.h"
#include "export/job.h"
#include "formats/files.h"
#include "formats/output_place.h"
#include "formats/png.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

constexpr int kDefaultMarginPx = 8;

// A folder for each class, by class id - 1. Folder names that would be equal end with the class id.
// Error (usage): two classes have one folder even so.
Result<std::vector<std::string>> class_folders(const std::vector<std::string>& classes) {
  std::vector<std::string> names;
  for (const std::string& name : classes) {
    names.push_back(plain_name(name, 100));
    if (names.back().starts_with('.')) names.back().front() = '_';
  }
  std::vector<std::string> folders;
  for (std::size_t k = 0; k < names.size(); ++k) {
    const bool is_alone = std::count(names.begin(), names.end(), names[k]) == 1;
    folders.push_back(is_alone ? names[k] : fmt::format("{}_{}", names[k], k + 1));
  }
  for (std::size_t k = 1; k < folders.size(); ++k) {
    const auto before = folders.begin() + static_cast<std::ptrdiff_t>(k);
    const auto same = std::find(folders.begin(), before, folders[k]);
    if (same == before) continue;
    return Error{ErrorKind::usage,
                 fmt::format("the classes \"{}\" and \"{}\" would both have the folder {}; "
                             "expected names that differ in letters and digits",
                             classes[static_cast<std::size_t>(same - folders.begin())], classes[k],
                             folders[k])};
  }
  return folders;
}

// The box with a margin, clipped to the image.
Result<std::string> crop_png(const std::vector<std::uint8_t>& grey, const StoredPicture& picture,
                             const Mask& mask, int margin_px) {
  const int width = static_cast<int>(picture.width), height = static_cast<int>(picture.height);
  const int left = std::max(mask.left - margin_px, 0), top = std::max(mask.top - margin_px, 0);
  const int right = std::min(mask.left + mask.width + margin_px, width);
  const int bottom = std::min(mask.top + mask.height + margin_px, height);
  std::vector<std::uint8_t> pixels;
  for (int row = top; row < bottom; ++row) {
    const auto begin = grey.begin() + static_cast<std::ptrdiff_t>(row) * width;
    pixels.insert(pixels.end(), begin + left, begin + right);
  }
  return encode_png(pixels, bottom - top, right - left);
}

Status write_crops_of(const ExportJob& job, const std::vector<std::string>& folders,
                      const fs::path& target, const StoredSequence& sequence,
                      const StoredPing& ping) {
  const auto picture = picture_of_view(job, sequence, ping, job.view());
  if (!picture) return picture.error();
  if (picture->annotations.empty()) return {};
  const auto path = path_of(job, sequence, ping, grey_of(job));
  if (!path) return path.error();
  const auto grey = grey_pixels(job, *path, picture->height, picture->width);
  if (!grey) return grey.error();
  const int margin_px = job.options.margin_px.value_or(kDefaultMarginPx);
  for (const StoredAnnotation& annotation : picture->annotations) {
    const Mask mask = mask_of(annotation.runs, static_cast<std::int64_t>(picture->height));
    const auto png = crop_png(*grey, *picture, mask, margin_px);
    if (!png) return png.error();
    const std::string name =
        fmt::format("{}_{:05}.png", item_name(job, sequence, ping), annotation.instance);
    const std::uint8_t class_id = sequence.instances[annotation.instance - 1U].class_id;
    const Status written =
        write_whole(target / sequence.row.split / folders[class_id - 1U] / name, *png);
    if (!written) return written;
  }
  return {};
}

}  // namespace

Status write_crops(const ExportJob& job, const fs::path& target) {
  const Result<std::vector<std::string>> named = class_folders(job.dataset.classes);
  if (!named) return named.error();
  const std::vector<std::string>& folders = *named;
  // ImageFolder numbers classes by the folders that it finds, so all splits need the same folders.
  for (const std::string& split : splits_of(job)) {
    for (std::size_t k = 0; k < folders.size(); ++k) {
      if (!job.objects.classes[k]) continue;
      std::error_code error;
      fs::create_directories(target / split / folders[k], error);
      if (error) return write_error(target / split / folders[k], error.value());
    }
  }
  return for_each_sequence(job, [&](const StoredSequence& sequence) -> Status {
    if (const Status there = need(job, sequence, grey_of(job)); !there) return there;
    return for_each_exported_ping(job, sequence, [&](const StoredPing& ping) {
      return write_crops_of(job, folders, target, sequence, ping);
    });
  });
}

}  // namespace ensonify
