#include "dataset/footprint.h"

#include <string>
#include <utility>
#include <vector>

#include "dataset/catalogue.h"
#include "dataset/coco.h"
#include "dataset/layout.h"
#include "dataset/manifest_json.h"
#include "dataset/ping_record.h"
#include "dataset/table_rows.h"
#include "formats/npy.h"

namespace ensonify {
namespace {

std::uint64_t line_bytes(std::string file, std::uint64_t bytes) {
  return file_line({std::move(file), bytes, std::string(64, '0')}, false).size();
}

// A file of the sequence without the rows of its pings.
std::uint64_t fixed_bytes(const CatalogueRow& row, const GridSizes& sizes) {
  if (row.codec != FileCodec::npy) return 0;
  const std::uint64_t header = npy_header(row.type, grid_shape(row, sizes)).size();
  return row.grid == FileGrid::returns ? header : header + packed_bytes(row, sizes);
}

}  // namespace

Result<PingBytes> ping_bytes(const SequenceInfo& info, const EncodedPing& encoded) {
  const auto record = parse_ping_record(encoded.record);
  if (!record) return Error{ErrorKind::bug, "the record of a ping cannot be read back"};
  PingBytes bytes;
  bytes.record = encoded.record.size();
  for (const FileEntry& entry : record->files) {
    bytes.files += entry.bytes;
    if (entry.path == layout::ping_file(layout::kPiece, encoded.ping)) {
      bytes.piece = entry.bytes;
    } else {
      bytes.sequence_lines += file_line(entry, false).size();
    }
  }
  for (const std::string& row : table_rows(*record, info.instances)) {
    bytes.sequence_lines += row.size();
  }
  const Result<std::uint64_t> coco = coco_bytes(info, record->annotations);
  if (!coco) return coco.error();
  bytes.dataset_lines = *coco +
                        index_row(info.sequence, record->ping, record->time_s, info.split).size() +
                        layout::index_stem(info.sequence, record->ping).size() + 1;
  return bytes;
}

std::uint64_t sequence_bytes(const SequenceInfo& info, const EncodedPing& encoded) {
  std::vector<std::string> each_ping;
  for (const EncodedFile& file : encoded.files) {
    if (file.name_template != layout::kPiece) each_ping.push_back(file.name_template);
  }
  const FileSelection selection = selection_of(info);
  const GridSizes sizes = sizes_of(info);
  std::uint64_t bytes = files_opening(sequence_head(info, each_ping, 0)).size() +
                        files_closing().size() + std::char_traits<char>::length(kPosesHeader) +
                        std::char_traits<char>::length(kObjectsHeader) +
                        std::char_traits<char>::length(kBoxesHeader);
  for (const CatalogueRow& row : catalogue()) {
    if (row.scope != FileScope::sequence || !is_wanted(row, selection)) continue;
    if (row.file == layout::kSequenceJson) continue;
    const std::uint64_t own = fixed_bytes(row, sizes);
    bytes += own + line_bytes(row.file, own);
  }
  for (const CatalogueRow* array : arrays_of(selection)) {
    const std::uint64_t header = npy_header(array->type, array_shape(*array, sizes)).size();
    bytes += header + line_bytes(array->array, header + sizes.pings * packed_bytes(*array, sizes));
  }
  return bytes;
}

}  // namespace ensonify
