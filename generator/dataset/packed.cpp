#include "dataset/packed.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>

#include "dataset/catalogue.h"
#include "dataset/layout.h"
#include "formats/bytes.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

// Appends a ping's part of an array to `piece`.
void append_cells(const CatalogueRow& row, const PingResult& result, std::string& piece) {
  const auto append = [&](const auto& values) {
    const std::size_t bytes = values.size() * sizeof values[0];
    piece.resize(piece.size() + bytes);
    std::memcpy(piece.data() + piece.size() - bytes, values.data(), bytes);
  };
  const CatalogueRow::Cells cells = row.cells(result);
  const auto* floats = std::get_if<std::span<const float>>(&cells);
  if (floats == nullptr || row.type == kNpyFloat32) return std::visit(append, cells);
  std::vector<std::uint16_t> halves(floats->size());
  to_halves(*floats, halves);
  append(halves);
}

// Reads a piece from start to end.
class PieceReader {
 public:
  explicit PieceReader(fs::path path)
      : path_(std::move(path)), descriptor_(::open(path_.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (descriptor_ < 0) error_number_ = errno;
  }
  ~PieceReader() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  PieceReader(const PieceReader&) = delete;
  PieceReader& operator=(const PieceReader&) = delete;

  Status copy(std::uint64_t bytes, StreamedFile& file) {
    std::string buffer(kBufferBytes, '\0');
    while (error_number_ == 0 && bytes > 0) {
      const auto got =
          ::read(descriptor_, buffer.data(), std::min<std::uint64_t>(bytes, kBufferBytes));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) {
        error_number_ = got < 0 ? errno : EIO;
        break;
      }
      file.append({buffer.data(), static_cast<std::size_t>(got)});
      bytes -= static_cast<std::uint64_t>(got);
    }
    return error_number_ == 0 ? Status() : Status(read_error(path_, error_number_));
  }

 private:
  static constexpr std::size_t kBufferBytes = std::size_t{1} << 18;
  fs::path path_;
  int descriptor_;
  int error_number_ = 0;
};

}  // namespace

std::string encode_piece(const SequenceInfo& info, const PingResult& result) {
  const auto arrays = arrays_of(selection_of(info));
  const GridSizes sizes = sizes_of(info);
  std::uint64_t bytes = 0;
  for (const CatalogueRow* array : arrays) bytes += packed_bytes(*array, sizes);
  std::string piece;
  piece.reserve(bytes);
  for (const CatalogueRow* array : arrays) append_cells(*array, result, piece);
  ENSONIFY_ASSERT(piece.size() == bytes);
  return piece;
}

Result<std::vector<FileEntry>> write_arrays(const fs::path& dir, const SequenceInfo& info) {
  const auto arrays = arrays_of(selection_of(info));
  const GridSizes sizes = sizes_of(info);
  std::vector<std::unique_ptr<StreamedFile>> files;
  for (const CatalogueRow* array : arrays) {
    files.push_back(
        std::make_unique<StreamedFile>(dir, layout::in_sequence(info.sequence, array->array)));
    files.back()->append(npy_header(array->type, array_shape(*array, sizes)));
  }
  for (std::uint32_t ping = info.first_ping; ping < info.last_ping && !arrays.empty(); ++ping) {
    PieceReader piece(dir /
                      layout::in_sequence(info.sequence, layout::ping_file(layout::kPiece, ping)));
    for (std::size_t i = 0; i < arrays.size(); ++i) {
      if (Status copied = piece.copy(packed_bytes(*arrays[i], sizes), *files[i]); !copied) {
        return copied.error();
      }
    }
  }
  std::vector<FileEntry> entries;
  for (const auto& file : files) {
    auto entry = file->commit();
    if (!entry) return entry.error();
    entries.push_back(std::move(*entry));
  }
  return entries;
}

void remove_pieces(const fs::path& dir, std::uint32_t sequence) {
  const fs::path folder = dir / layout::in_sequence(sequence, layout::kPieceFolder);
  std::error_code error;
  if (!fs::is_directory(fs::symlink_status(folder, error))) return;
  std::vector<fs::path> pieces;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name =
        std::string(layout::kPieceFolder) + "/" + entry->path().filename().string();
    const auto file = layout::parse_ping_file(name);
    if (file && file->name_template == layout::kPiece) pieces.push_back(entry->path());
  }
  for (const fs::path& piece : pieces) ::unlink(piece.c_str());
  ::rmdir(folder.c_str());
}

}  // namespace ensonify
