#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "dataset/layout.h"
#include "dataset/render_manifest.h"
#include "dataset/schema.h"
#include "dataset/verify_parts.h"
#include "formats/jpeg.h"
#include "formats/json.h"
#include "formats/png.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

struct Image {
  std::uint64_t rows = 0, columns = 0;
};

Image whole_image(const SequenceShape& shape, bool polar) {
  return polar ? Image{shape.sizes.samples, shape.sizes.beams}
               : Image{shape.sizes.cartesian_height, shape.sizes.cartesian_width};
}

bool lies_within(const PartPixels& part, const Image& whole) {
  return part.top_px < whole.rows && part.height_px <= whole.rows - part.top_px &&
         part.left_px < whole.columns && part.width_px <= whole.columns - part.left_px;
}

// The first sequence that shows pixels which its images do not have.
std::string part_fault(const RenderManifest& render, std::span<const SequenceShape> shapes) {
  for (const RenderedSequence& rendered : render.sequences) {
    for (const SequenceShape& shape : shapes) {
      if (shape.sequence != rendered.sequence) continue;
      if ((rendered.polar && !lies_within(*rendered.polar, whole_image(shape, true))) ||
          (rendered.cartesian && !lies_within(*rendered.cartesian, whole_image(shape, false)))) {
        return fmt::format("shows pixels that sequence {} does not have", rendered.sequence);
      }
    }
  }
  return {};
}

// Images that the render must list, by path.
std::map<std::string, Image> expected_images(const RenderManifest& render,
                                             std::span<const SequenceShape> shapes) {
  std::map<std::string, Image> images;
  for (const SequenceShape& shape : shapes) {
    const auto rendered = std::find_if(
        render.sequences.begin(), render.sequences.end(),
        [&](const RenderedSequence& sequence) { return sequence.sequence == shape.sequence; });
    if (rendered == render.sequences.end()) continue;
    for (std::uint64_t ping = shape.first_ping; ping < shape.last_ping; ++ping) {
      for (const std::string& view : render.views) {
        const bool polar = view == view_name(ImageView::polar);
        const auto& part = polar ? rendered->polar : rendered->cartesian;
        const Image whole = whole_image(shape, polar);
        images[render_file(polar ? ImageView::polar : ImageView::cartesian, shape.sequence,
                           static_cast<std::uint32_t>(ping), render.jpeg_quality > 0)] =
            part ? Image{part->height_px, part->width_px} : whole;
      }
    }
  }
  return images;
}

std::string image_fault(const fs::path& path, const Image& image, const RenderManifest& render) {
  const auto bytes = read_file(path);
  if (render.jpeg_quality > 0) {
    if (!bytes) return "cannot be read";
    const auto jpeg = parse_grey_jpeg(*bytes, JpegSize{image.rows, image.columns});
    return jpeg ? "" : jpeg.error().message;
  }
  const bool in_color = !render.display.color_map.empty();
  const auto header = bytes ? parse_png_header(*bytes) : std::nullopt;
  if (!header) return "is not a PNG file";
  constexpr int kGray = 0, kPalette = 3;
  if (header->height != image.rows || header->width != image.columns || header->bit_depth != 8 ||
      header->color_type != (in_color ? kPalette : kGray)) {
    return "is not an image of the size and kind given in the manifests";
  }
  return {};
}

std::string sequences_fault(const RenderManifest& render, std::span<const SequenceEntry> entries) {
  for (const RenderedSequence& rendered : render.sequences) {
    const bool same = std::any_of(entries.begin(), entries.end(), [&](const SequenceEntry& entry) {
      return entry.sequence == rendered.sequence && entry.sha256 == rendered.sha256 &&
             entry.first_ping == rendered.first_ping && entry.last_ping == rendered.last_ping;
    });
    if (!same) {
      return fmt::format("was made from another version of sequence {}", rendered.sequence);
    }
  }
  return {};
}

struct RenderParts {
  const fs::path& dir;
  std::span<const SequenceShape> shapes;
  std::span<const SequenceEntry> entries;
  const Workers& workers;
};

void check_files(const RenderParts& parts, const RenderManifest& render, const std::string& folder,
                 const std::vector<FileEntry>& files, RenderFindings& found) {
  std::uint64_t pings = 0;
  for (const RenderedSequence& rendered : render.sequences) {
    pings += rendered.last_ping - rendered.first_ping;
  }
  if (pings * render.views.size() > files.size()) {
    // This check also prevents a manifest that claims billions of pings from filling the memory.
    return found.add(folder + "/" + layout::kRenderJson, "lists fewer files than its pings have");
  }
  const auto expected = expected_images(render, parts.shapes);
  std::vector<std::string> faults(files.size());
  parts.workers.for_each(files.size(), [&](std::size_t i) {
    const std::string path = folder + "/" + files[i].path;
    faults[i] = content_fault(parts.dir, path, files[i].bytes, files[i].sha256);
    if (!faults[i].empty()) return;
    const auto image = expected.find(files[i].path);
    faults[i] = image == expected.end() ? "is listed, but not a file of this render"
                                        : image_fault(parts.dir / path, image->second, render);
  });
  std::uint64_t bytes = 0;
  std::set<std::string> listed;
  for (std::size_t i = 0; i < files.size(); ++i) {
    found.add(folder + "/" + files[i].path, faults[i]);
    found.files.push_back(folder + "/" + files[i].path);
    if (!listed.insert(files[i].path).second) {
      found.add(folder + "/" + files[i].path, "is listed twice");
    }
    bytes += files[i].bytes;
  }
  for (const auto& [path, image] : expected) {
    if (!listed.contains(path)) {
      found.add(folder + "/" + path, "belongs to this render, but render.json does not list it");
    }
  }
  if (bytes != render.bytes) {
    found.add(folder + "/" + layout::kRenderJson,
              "its number of bytes is not the sum of its files");
  }
  found.bytes += bytes;
}

void check_render(const RenderParts& parts, const std::string& name, RenderFindings& found) {
  const std::string folder = render_folder(name);
  const std::string path = folder + "/" + layout::kRenderJson;
  const auto size = listed_file_size(parts.dir, path);
  if (!size) {
    return found.add(folder,
                     "is incomplete: its render was interrupted; run the same `ensonify render` "
                     "command again, or remove the folder");
  }
  found.files.push_back(path);
  found.bytes += *size;
  std::vector<FileEntry> files;
  std::string entry_fault;
  const SchemaCheck entry_check("render", "file");
  const auto text = read_file(parts.dir / path, kMaxManifestBytes);
  const auto head = !text ? std::nullopt : parse_manifest_entries(*text, [&](const Json& entry) {
    if (entry_fault.empty()) {
      entry_fault = entry_check.fault(entry, fmt::format("/files/{}", files.size()));
    }
    files.push_back(file_entry_of(entry).value_or(FileEntry{}));
  });
  const auto render = head ? read_render_head(*head) : std::nullopt;
  if (!render) return found.add(path, "is not a render's manifest");
  std::string fault = SchemaCheck("render").fault(*head);
  if (fault.empty()) fault = entry_fault;
  if (fault.empty() && render->name != name) fault = "does not have the name of its folder";
  if (fault.empty()) fault = sequences_fault(*render, parts.entries);
  if (fault.empty()) fault = part_fault(*render, parts.shapes);
  found.add(path, fault);
  if (fault.empty()) check_files(parts, *render, folder, files, found);
}

}  // namespace

void RenderFindings::add(const std::string& path, const std::string& fault) {
  if (!fault.empty()) faults.emplace_back(path, fault);
}

RenderFindings check_renders(const fs::path& dir, std::span<const SequenceShape> shapes,
                             std::span<const SequenceEntry> entries, const Workers& workers) {
  RenderFindings found;
  const RenderParts parts{dir, shapes, entries, workers};
  for (const std::string& name : render_names(dir)) check_render(parts, name, found);
  return found;
}

}  // namespace ensonify
