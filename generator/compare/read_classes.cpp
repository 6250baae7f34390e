#include "compare/read_classes.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/counted.h"
#include "dataset/read_pictures.h"
#include "formats/files.h"
#include "formats/natural_order.h"
#include "formats/png.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

using Classes = std::vector<std::uint8_t>;

constexpr std::uint8_t kShadowInMask = 255;
constexpr std::uint64_t kMostMaskBytes = std::uint64_t{1} << 28;

std::uint8_t code(PixelClass which) { return static_cast<std::uint8_t>(which); }

Result<Classes> read_mask_of_ping(const fs::path& path, const StoredSequence& sequence) {
  const auto bytes = read_file(path, kMostMaskBytes);
  if (!bytes) return bytes.error();
  auto image = parse_grey_png(*bytes);
  if (!image) return Error{ErrorKind::usage, path.string() + ": " + image.error().message};
  if (image->grey8.empty() || image->rows != sequence.samples || image->columns != sequence.beams) {
    return Error{ErrorKind::usage,
                 fmt::format("{}: expected an 8-bit image of {} rows (samples) and {} columns "
                             "(beams), as the polar images",
                             path.string(), sequence.samples, sequence.beams)};
  }
  for (std::uint8_t& value : image->grey8) {
    value = code(value == 0               ? PixelClass::background
                 : value == kShadowInMask ? PixelClass::shadow
                                          : PixelClass::object);
  }
  return std::move(image->grey8);
}

// The files of the pings of each sequence, in the order of both.
Result<std::vector<std::string>> mask_files(const fs::path& folder,
                                            const std::vector<StoredSequence>& sequences) {
  auto files = files_below(folder);
  if (!files) return files.error();
  std::erase_if(*files, [](const std::string& file) { return !file.ends_with(".png"); });
  sort_naturally(*files);
  std::size_t pings = 0;
  for (const StoredSequence& sequence : sequences) pings += sequence.row.pings();
  if (files->size() != pings) {
    return Error{
        ErrorKind::usage,
        fmt::format("{}: has {}; expected one for each of the {} of the data set", folder.string(),
                    counted(files->size(), "PNG file"), counted(pings, "ping"))};
  }
  return files;
}

// By instance id: whether it is an object.
Result<std::vector<bool>> objects_of(const ClassSource& source, const StoredDataset& dataset,
                                     const StoredSequence& sequence) {
  for (const std::string& name : source.objects) {
    const auto& classes = dataset.classes;
    if (std::find(classes.begin(), classes.end(), name) != classes.end()) continue;
    std::string known;
    for (const std::string& each : classes) known += (known.empty() ? "" : ", ") + each;
    return Error{ErrorKind::usage, fmt::format("--objects: {} has no class {}; expected one of {}",
                                               dataset.dir.string(), name, known)};
  }
  std::vector<bool> is_object(1, false);
  for (const StoredInstance& instance : sequence.instances) {
    const std::size_t kind = std::size_t{instance.class_id} - 1;
    const bool is_thing =
        kind < dataset.class_kinds.size() && dataset.class_kinds[kind] == ClassKind::thing;
    const bool is_named = std::find(source.objects.begin(), source.objects.end(),
                                    instance.class_name) != source.objects.end();
    is_object.resize(std::max<std::size_t>(is_object.size(), std::size_t{instance.id} + 1));
    is_object[instance.id] =
        source.objects.empty() ? is_thing && instance.box.has_value() : is_named;
  }
  return is_object;
}

Result<Classes> labeled_classes(const StoredDataset& dataset, const StoredSequence& sequence,
                                std::uint32_t ping, const std::vector<bool>& is_object) {
  const auto pixels =
      read_picture(dataset, sequence, ImageView::polar, ping, {"instance", "shadow"});
  if (!pixels) return pixels.error();
  const auto is_in = [&](const std::vector<std::uint16_t>& ids, std::size_t i) {
    return i < ids.size() && ids[i] < is_object.size() && is_object[ids[i]];
  };
  Classes classes(pixels->instance.size(), code(PixelClass::background));
  for (std::size_t i = 0; i < classes.size(); ++i) {
    if (is_in(pixels->shadow, i)) classes[i] = code(PixelClass::shadow);
    if (is_in(pixels->instance, i)) classes[i] = code(PixelClass::object);
  }
  return classes;
}

}  // namespace

Result<std::vector<Classes>> read_classes(const ClassSource& source, const StoredDataset& dataset,
                                          const std::vector<StoredSequence>& sequences,
                                          const std::vector<PingPlace>& places,
                                          const Workers& workers) {
  if (!source.wanted) return std::vector<Classes>();
  std::vector<std::string> files;
  std::vector<std::vector<bool>> objects;
  std::vector<std::size_t> first_file;
  std::size_t next = 0;
  for (const StoredSequence& sequence : sequences) {
    first_file.push_back(next);
    next += sequence.row.pings();
    if (!source.masks.empty()) continue;
    if (!sequence.has(plane_row(ImageView::polar, "instance"))) return std::vector<Classes>();
    auto of_sequence = objects_of(source, dataset, sequence);
    if (!of_sequence) return of_sequence.error();
    objects.push_back(std::move(*of_sequence));
  }
  if (!source.masks.empty()) {
    auto found = mask_files(source.masks, sequences);
    if (!found) return found.error();
    files = std::move(*found);
  }
  std::vector<Result<Classes>> read(places.size(), Classes());
  workers.for_each(places.size(), [&](std::size_t i) {
    const auto [s, ping] = places[i];
    const StoredSequence& sequence = sequences[s];
    read[i] =
        source.masks.empty()
            ? labeled_classes(dataset, sequence, ping, objects[s])
            : read_mask_of_ping(
                  source.masks / files[first_file[s] + ping - sequence.row.first_ping], sequence);
  });
  std::vector<Classes> classes;
  for (auto& of_ping : read) {
    if (!of_ping) return of_ping.error();
    classes.push_back(std::move(*of_ping));
  }
  return classes;
}

}  // namespace ensonify
