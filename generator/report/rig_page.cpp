#include "report/rig_page.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "core/units.h"
#include "formats/bytes.h"
#include "formats/output_place.h"
#include "formats/webp.h"
#include "report/page_text.h"
#include "report/small_picture.h"

namespace ensonify {
namespace {

constexpr std::size_t kMostCellSide = 360;
constexpr int kColorQuality = 75;

// What the page needs of a sequence of an instrument.
struct RigSequence {
  ShownSequence shown;
  std::vector<std::pair<double, std::uint32_t>> pings;  // times and numbers, in order
};

struct CameraPicture {
  std::size_t rows = 0, columns = 0;
  std::vector<std::uint8_t> rgb;
  std::vector<double> depth_m;  // of the middle of a pixel; NaN: none
};

struct RigCell {
  std::uint32_t ping = 0;
  double time_s = 0;
  std::optional<SmallPicture> level;
  CameraPicture camera;
};

struct RigInstrumentPart {
  StoredDataset dataset;
  std::map<std::uint32_t, RigSequence> sequences;  // those of the rows that it has
  std::vector<std::optional<RigCell>> cells;       // of each row
};

struct RigRow {
  std::uint32_t sequence = 0;
  double time_s = 0;
};

Status read_rig_sequence(std::uint32_t number, RigInstrumentPart& part) {
  const auto row = std::find_if(part.dataset.sequences.begin(), part.dataset.sequences.end(),
                                [&](const auto& entry) { return entry.sequence == number; });
  if (row == part.dataset.sequences.end()) return {};
  auto stored = read_sequence(part.dataset, *row);
  if (!stored) return stored.error();
  // What describes beams is read of a sonar alone.
  auto facts = has_levels(*stored) ? read_sequence_facts(part.dataset, *stored)
                                   : Result<SequenceFacts>(SequenceFacts{});
  if (!facts) return facts.error();
  RigSequence read{{std::move(*stored), std::move(*facts), {}}, {}};
  const Status done =
      for_each_ping(part.dataset, read.shown.stored, [&](const StoredPing& ping) -> Status {
        read.pings.emplace_back(ping.time_s, ping.ping);
        return {};
      });
  if (done) part.sequences.emplace(number, std::move(read));
  return done;
}

// The instrument whose pings begin the rows: the first one that has images.
Result<std::size_t> first_with_images(const std::vector<RigInstrumentPart>& parts) {
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto& sequences = parts[i].dataset.sequences;
    if (sequences.empty()) continue;
    const auto sequence = read_sequence(parts[i].dataset, sequences.front());
    if (!sequence) return sequence.error();
    if (has_levels(*sequence) || sequence->manifest.info.camera) return i;
  }
  return std::size_t{0};
}

// The rows, with the sequences of all instruments that they need.
Result<std::vector<RigRow>> choose_rows(std::vector<RigInstrumentPart>& parts,
                                        const RigInstrumentPart& first, std::uint64_t pings,
                                        std::uint64_t most) {
  std::vector<RigRow> rows;
  const auto& entries = first.dataset.sequences;
  auto entry = entries.begin();
  std::uint64_t before = 0;
  for (const std::uint64_t chosen : spread(pings, most)) {
    while (chosen - before >= entry->pings()) before += (entry++)->pings();
    if (rows.empty() || rows.back().sequence != entry->sequence) {
      for (RigInstrumentPart& part : parts) {
        if (const Status read = read_rig_sequence(entry->sequence, part); !read)
          return read.error();
      }
    }
    const auto& times = first.sequences.at(entry->sequence).pings;
    rows.push_back({entry->sequence, times[chosen - before].first});
  }
  return rows;
}

const std::pair<double, std::uint32_t>& nearest(const RigSequence& sequence, double time_s) {
  return *std::min_element(sequence.pings.begin(), sequence.pings.end(),
                           [&](const auto& a, const auto& b) {
                             return std::abs(a.first - time_s) < std::abs(b.first - time_s);
                           });
}

Status read_camera(const StoredDataset& dataset, const StoredSequence& sequence, std::uint32_t ping,
                   CameraPicture& picture) {
  const CatalogueRow *color = find_array("camera_color.npy"),
                     *depth = find_array("camera_depth_m.npy");
  const auto& camera = sequence.manifest.info.camera;
  if (!camera) return {};
  const auto columns = static_cast<std::size_t>(camera->optics.width_px);
  const auto rows = static_cast<std::size_t>(camera->optics.height_px);
  const std::size_t side = std::max(rows, columns);
  const std::size_t step = (side + kMostCellSide - 1) / kMostCellSide;
  picture.rows = (rows + step - 1) / step;
  picture.columns = (columns + step - 1) / step;
  CellReader reader(dataset, sequence, ping);
  const auto for_each_pixel = [&](auto use) {
    for (std::size_t row = step / 2; row < picture.rows * step; row += step) {
      for (std::size_t column = step / 2; column < picture.columns * step; column += step) {
        use(std::min(row, rows - 1) * columns + std::min(column, columns - 1));
      }
    }
  };
  if (can_read(sequence, *color)) {
    const auto bytes = reader.read(*color);
    if (!bytes) return bytes.error();
    for_each_pixel([&](std::size_t at) {
      for (std::size_t c = 0; c < 3; ++c) {
        picture.rgb.push_back(static_cast<std::uint8_t>((*bytes)[3 * at + c]));
      }
    });
  }
  if (can_read(sequence, *depth)) {
    const auto bytes = reader.read(*depth);
    if (!bytes) return bytes.error();
    const auto depth_m = values_in<float>(*bytes);
    for_each_pixel([&](std::size_t at) { picture.depth_m.push_back(depth_m[at]); });
  }
  return {};
}

Status read_cell(const RigRow& row, const Workers& workers, RigInstrumentPart& part,
                 std::optional<RigCell>& cell) {
  const auto known = part.sequences.find(row.sequence);
  if (known == part.sequences.end() || known->second.pings.empty()) return {};
  const RigSequence& sequence = known->second;
  const auto [time_s, ping] = nearest(sequence, row.time_s);
  cell = RigCell{ping, time_s, {}, {}};
  if (has_levels(sequence.shown.stored)) {
    const auto levels = levels_of_ping(part.dataset, sequence.shown, ping, workers);
    if (!levels) return levels.error();
    cell->level = smaller(sequence.shown, *levels, kMostCellSide);
  }
  return read_camera(part.dataset, sequence.shown.stored, ping, cell->camera);
}

// None without levels.
std::optional<PictureScale> scale_of_cells(const RigInstrumentPart& part) {
  LevelCounts levels;
  bool any = false;
  for (const auto& cell : part.cells) {
    if (!cell || !cell->level) continue;
    levels.add(cell->level->level_db);
    any = true;
  }
  return any ? std::optional(scale_of(levels)) : std::nullopt;
}

// Depths as codes of their logarithms between the least and the greatest.
Result<Json> depth_json(const CameraPicture& camera, Chunks& chunks) {
  double least_m = 1e300, greatest_m = 0;
  for (const double z_m : camera.depth_m) {
    if (!(z_m > 0)) continue;
    least_m = std::min(least_m, z_m);
    greatest_m = std::max(greatest_m, z_m);
  }
  if (greatest_m == 0) return Json(nullptr);
  std::vector<std::uint8_t> codes;
  for (const double z_m : camera.depth_m) {
    codes.push_back(z_m > 0
                        ? grey_code(std::log(z_m), std::log(least_m), std::log(greatest_m) + 1e-9)
                        : std::uint8_t{0});
  }
  auto webp = lossless_grey(codes, static_cast<int>(camera.columns), static_cast<int>(camera.rows));
  if (!webp) return webp.error();
  return Json{{"chunk", chunks.add(std::move(*webp))}, {"min_m", least_m}, {"max_m", greatest_m}};
}

Result<Json> cell_json(const std::optional<RigCell>& cell, const std::optional<PictureScale>& scale,
                       Chunks& chunks) {
  if (!cell) return Json(nullptr);
  const CameraPicture& camera = cell->camera;
  Json json = {{"ping", cell->ping},       {"time_s", cell->time_s}, {"level", nullptr},
               {"color", nullptr},         {"depth", nullptr},       {"rows", camera.rows},
               {"columns", camera.columns}};
  if (cell->level) {
    auto level = picture_json(*cell->level, *scale, chunks);
    if (!level) return level.error();
    json["level"] = std::move(*level);
  }
  if (!camera.rgb.empty()) {
    auto webp = lossy_rgb(camera.rgb, static_cast<int>(camera.columns),
                          static_cast<int>(camera.rows), kColorQuality);
    if (!webp) return webp.error();
    json["color"] = chunks.add(std::move(*webp));
  }
  auto depth = depth_json(camera, chunks);
  if (!depth) return depth.error();
  json["depth"] = std::move(*depth);
  return json;
}

Result<Json> instrument_json(const RigInstrument& of, const std::string& report,
                             const RigInstrumentPart& part, Chunks& chunks) {
  const auto scale = scale_of_cells(part);
  Json json = {{"name", of.name},
               {"report", report.empty() ? Json(nullptr) : Json(report)},
               {"position_m", nullptr},
               {"quaternion_wxyz", nullptr},
               {"ping_rate_hz", of.ping_rate_hz ? Json(*of.ping_rate_hz) : Json(nullptr)},
               {"time_offset_s", of.time_offset_s ? Json(*of.time_offset_s) : Json(nullptr)},
               {"scale", nullptr},
               {"cells", Json::array()}};
  if (scale) {
    json["scale"] = {{"min_db", scale->min_db},
                     {"max_db", scale->max_db},
                     {"show_min_db", scale->show_min_db},
                     {"show_max_db", scale->show_max_db}};
  }
  if (of.mount) {
    const Vec3 p = of.mount->position_m;
    const Quat q = of.mount->rotation;
    json["position_m"] = {p.x, p.y, p.z};
    json["quaternion_wxyz"] = {q.w, q.x, q.y, q.z};
  }
  for (const auto& cell : part.cells) {
    auto coded = cell_json(cell, scale, chunks);
    if (!coded) return coded.error();
    json["cells"].push_back(std::move(*coded));
  }
  return json;
}

Result<std::vector<RigInstrumentPart>> open_parts(const RigPage& page) {
  std::vector<RigInstrumentPart> parts;
  for (const RigInstrument& instrument : page.rig.instruments) {
    auto dataset = open_dataset(page.dir / instrument.name);
    if (!dataset) return dataset.error();
    parts.push_back({std::move(*dataset), {}, {}});
  }
  return parts;
}

}  // namespace

Result<WrittenRig> write_rig_page(const RigPage& page, const std::filesystem::path& path,
                                  const Workers& workers, bool (*stop)()) {
  auto parts = open_parts(page);
  if (!parts) return parts.error();
  const auto first = first_with_images(*parts);
  if (!first) return first.error();
  const RigInstrumentPart& leading = (*parts)[*first];
  const auto facts = read_facts(leading.dataset);
  if (!facts) return facts.error();
  std::uint64_t pings = 0;
  for (const auto& sequence : leading.dataset.sequences) pings += sequence.pings();
  const auto rows = choose_rows(*parts, leading, pings, page.most_rows);
  if (!rows) return rows.error();
  for (RigInstrumentPart& part : *parts) {
    part.cells.resize(rows->size());
    const Status read = for_each_picture(workers, stop, rows->size(), [&](std::size_t i) -> Status {
      return read_cell((*rows)[i], workers, part, part.cells[i]);
    });
    if (!read) return read.error();
  }
  Chunks chunks;
  Json json = {{"page", 1},
               {"program", facts->program},
               {"name", page.rig.name},
               {"first", *first},
               {"colour_maps", colour_maps_json()},
               {"rows", Json::array()},
               {"instruments", Json::array()}};
  for (const RigRow& row : *rows) {
    json["rows"].push_back({{"sequence", row.sequence}, {"time_s", row.time_s}});
  }
  for (std::size_t i = 0; i < parts->size(); ++i) {
    auto part = instrument_json(page.rig.instruments[i], page.reports[i], (*parts)[i], chunks);
    if (!part) return part.error();
    json["instruments"].push_back(std::move(*part));
  }
  const PageFrame frame = page_frame("rig_page", "rig_order");
  StreamedFile output(path);
  output.append(frame.before);
  append_data(without_angles(json.dump(-1, ' ', false, Json::error_handler_t::replace)), chunks,
              output);
  output.append(frame.after);
  if (const Status written = output.close(); !written) return written.error();
  return WrittenRig{pings, rows->size(), output.bytes()};
}

}  // namespace ensonify
