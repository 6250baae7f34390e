#include "dataset/render_manifest.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <system_error>

#include "dataset/json_members.h"
#include "dataset/layout.h"
#include "dataset/manifest_members.h"
#include "dataset/member_schema.h"

namespace ensonify {

static const char* name_of(Flip flip) { return flip_name(flip); }
static const char* name_of(Decimation decimation) { return decimation_name(decimation); }

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongestName = 64;

template <class Io, class Value>
void part_members(Io& io, Value& part) {
  io.sometimes(part.range_m.has_value(), "range_m", part.range_m);
  io.together_if(part.decimates(), [&](Io& also) {
    also.group("decimation", [&](Io& decimation) {
      decimation("samples", part.samples);
      decimation("beams", part.beams);
      decimation.word("shows", part.decimation, Decimation::max);
    });
  });
}

template <class Io, class Value>
void pixel_members(Io& io, const char* view, Value& pixels) {
  io.maybe(view, pixels, [](Io& item, auto& part) {
    item("top_px", part.top_px);
    item("left_px", part.left_px);
    item("height_px", part.height_px);
    item("width_px", part.width_px);
  });
}

template <class Io, class Value>
void members(Io& io, Value& render) {
  io("ensonify_render", render.version);
  io("name", render.name);
  io.group("program", [&](Io& program) {
    program("version", render.program_version);
    program("commit", render.program_commit);
  });
  io("views", render.views);
  io.group("display", [&](Io& display) {
    display_members(display, render.display, render.counts);
    display("color_map", render.display.color_map);
    display.word("flip", render.display.flip, Flip::both);
    part_members(display, render.part);
    display.sometimes(render.jpeg_quality > 0, "jpeg_quality", render.jpeg_quality);
    if constexpr (!Io::kReads) {
      display.said("formula",
                   grey_formula(render.display, "water.absorption_db_m of its sequence.json"));
    }
  });
  io.list("sequences", render.sequences, [](Io& item, auto& sequence) {
    item("sequence", sequence.sequence);
    item.pings(sequence.first_ping, sequence.last_ping);
    item("sha256", sequence.sha256);
    pixel_members(item, "polar", sequence.polar);
    pixel_members(item, "cartesian", sequence.cartesian);
  });
  io("bytes", render.bytes);
}

}  // namespace

Json render_json(const RenderManifest& manifest, const std::vector<FileEntry>& files) {
  Json json = Json::object();
  MemberWriter io(json);
  members(io, manifest);
  files_member(io, files);
  return json;
}

Json render_schema() {
  return MemberSchema::object_of([](MemberSchema& io) {
    RenderManifest manifest;
    members(io, manifest);
    files_member(io, {});
  });
}

std::optional<RenderManifest> read_render_head(const Json& head) {
  if (!count_at(head, "ensonify_render")) return std::nullopt;
  RenderManifest manifest;
  MemberReader io(head, manifest.fault);
  members(io, manifest);
  return manifest;
}

bool is_render_name(std::string_view name) {
  const auto is_good = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
           c == '_' || c == '.';
  };
  return !name.empty() && name.size() <= kLongestName && name.front() != '.' &&
         std::all_of(name.begin(), name.end(), is_good);
}

std::string render_folder(std::string_view name) {
  return fmt::format("{}/{}", layout::kRenders, name);
}

std::string render_file(ImageView view, std::uint32_t sequence, std::uint32_t ping, bool jpeg) {
  return fmt::format("{}/{}_{}.{}", layout::sequence_folder(sequence), layout::ping_stem(ping),
                     view_name(view), jpeg ? "jpg" : "png");
}

std::vector<std::string> render_names(const fs::path& dir) {
  std::vector<std::string> names;
  std::error_code error;
  const fs::path renders = dir / layout::kRenders;
  if (!fs::is_directory(fs::symlink_status(renders, error))) return names;
  for (fs::directory_iterator entry(renders, error), end; !error && entry != end;
       entry.increment(error)) {
    if (fs::is_directory(entry->symlink_status(error))) {
      names.push_back(entry->path().filename().string());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

Result<RenderManifest> read_render(const StoredDataset& dataset, const std::string& name) {
  const auto usage = [&](const std::string& what) {
    return Error{ErrorKind::usage, dataset.dir.string() + ": " + what};
  };
  const std::string relative = render_folder(name) + "/" + layout::kRenderJson;
  if (!is_render_name(name) || !listed_file_size(dataset.dir, relative)) {
    const std::vector<std::string> names = render_names(dataset.dir);
    return usage(fmt::format("has no render '{}'; {}", name,
                             names.empty()
                                 ? "`ensonify render` makes one"
                                 : fmt::format("expected one of {}", fmt::join(names, ", "))));
  }
  const fs::path path = dataset.dir / relative;
  const auto head = parse_manifest_file(path, [](const FileEntry&) {});
  auto manifest = head ? read_render_head(*head) : std::nullopt;
  if (!manifest || !manifest->fault.empty()) return damaged(path, "is not a render's manifest");
  if (manifest->version != 1) return usage("was rendered by a newer ensonify; use that version");
  for (const RenderedSequence& rendered : manifest->sequences) {
    const bool same = std::any_of(
        dataset.sequences.begin(), dataset.sequences.end(), [&](const StoredSequenceRow& row) {
          return row.sequence == rendered.sequence && row.sha256 == rendered.sha256;
        });
    if (!same) {
      return usage(
          fmt::format("render '{}' was made from another version of sequence {}; make it "
                      "again with --overwrite",
                      name, rendered.sequence));
    }
  }
  return std::move(*manifest);
}

}  // namespace ensonify
