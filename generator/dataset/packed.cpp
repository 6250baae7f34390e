#include "dataset/packed.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>

#include "dataset/half_floats.h"
#include "dataset/layout.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

template <class T>
void copy_values(const std::vector<T>& values, char* out) {
  std::memcpy(out, values.data(), values.size() * sizeof(T));
}

template <auto Member>
void copy_layer(const LabelledImage& image, char* out) {
  copy_values(image.*Member, out);
}

template <auto Member>
void copy_halves(const LabelledImage& image, char* out) {
  std::vector<std::uint16_t> halves((image.*Member).size());
  to_halves(image.*Member, halves);
  copy_values(halves, out);
}

// What an image holds; each comes as polar_NAME and cartesian_NAME.
struct LabelArray {
  const char* name;
  const char* descr;
  void (*copy)(const LabelledImage&, char* out);
};
constexpr LabelArray kLabelArrays[] = {
    {"level_db", kNpyFloat16, copy_halves<&LabelledImage::level_db>},
    {"clean_db", kNpyFloat16, copy_halves<&LabelledImage::clean_db>},
    {"elevation_rad", kNpyFloat16, copy_halves<&LabelledImage::elevation_rad>},
    {"elevation_std_rad", kNpyFloat16, copy_halves<&LabelledImage::elevation_std_rad>},
    {"instance_fraction", kNpyFloat16, copy_halves<&LabelledImage::instance_fraction>},
    {"instance", kNpyUint16, copy_layer<&LabelledImage::instance>},
    {"semantic", kNpyUint8, copy_layer<&LabelledImage::semantic>}};
constexpr LabelArray kShadowArray = {"shadow", kNpyUint16, copy_layer<&LabelledImage::shadow>};
constexpr LabelArray kMultipathArray = {"multipath", kNpyUint16,
                                        copy_layer<&LabelledImage::multipath>};

std::vector<LabelArray> label_arrays(const OutputSelection& output) {
  std::vector<LabelArray> arrays(std::begin(kLabelArrays), std::end(kLabelArrays));
  if (output.shadow) arrays.push_back(kShadowArray);
  if (output.multipath) arrays.push_back(kMultipathArray);
  return arrays;
}

NpyShape shape_of(const SequenceInfo& info, PackedGrid grid) {
  const auto beams = static_cast<std::uint64_t>(info.sonar.beam_count);
  const auto samples = static_cast<std::uint64_t>(info.record.samples);
  if (grid == PackedGrid::series) return {beams, samples};
  if (grid == PackedGrid::channels) return {info.element_y_m.size(), samples};
  if (grid == PackedGrid::polar) return {samples, beams};
  const CartesianGrid cartesian = info.cartesian.value_or(CartesianGrid{});
  return {static_cast<std::uint64_t>(cartesian.height_px),
          static_cast<std::uint64_t>(cartesian.width_px)};
}

std::string layer_file(Layer layer) { return std::string("layers_") + layer_name(layer) + ".npy"; }

// Calls use(file, descr, grid, write) for every array, in order; write(result, out) puts a ping's
// part there.
template <class Use>
void for_each_array(const SequenceInfo& info, Use use) {
  const OutputSelection& output = info.output;
  if (output.timeseries) {
    use("timeseries.npy", kNpyComplex64, PackedGrid::series,
        [](const PingResult& r, char* out) { copy_values(r.series, out); });
  }
  if (output.channels) {
    use("channels.npy", kNpyComplex64, PackedGrid::channels,
        [](const PingResult& r, char* out) { copy_values(r.channels, out); });
  }
  for (std::size_t i = 0; i < info.layers.size(); ++i) {
    use(layer_file(info.layers[i]), kNpyComplex64, PackedGrid::series,
        [i](const PingResult& r, char* out) { copy_values(r.layers[i].pressure_pa, out); });
  }
  for (const LabelArray& array : label_arrays(output)) {
    if (!output.polar) break;
    use(std::string("polar_") + array.name + ".npy", array.descr, PackedGrid::polar,
        [array](const PingResult& r, char* out) { array.copy(*r.polar, out); });
  }
  for (const LabelArray& array : label_arrays(output)) {
    if (!output.cartesian) break;
    use(std::string("cartesian_") + array.name + ".npy", array.descr, PackedGrid::cartesian,
        [array](const PingResult& r, char* out) { array.copy(*r.cartesian, out); });
  }
  if (!output.png) return;
  use("polar_grey.npy", kNpyUint8, PackedGrid::polar,
      [](const PingResult& r, char* out) { copy_values(r.polar_grey->pixels, out); });
  if (!output.cartesian) return;
  use("cartesian_grey.npy", kNpyUint8, PackedGrid::cartesian,
      [](const PingResult& r, char* out) { copy_values(r.cartesian_grey->pixels, out); });
}

// A sequence with everything, for questions about names alone.
SequenceInfo sequence_of_all() {
  SequenceInfo info;
  info.output.layers = true;
  info.output.channels = true;
  info.output.multipath = true;
  info.layers = {Layer::noise,      Layer::volume,    Layer::target,
                 Layer::background, Layer::multipath, Layer::quantisation};
  return info;
}

// Reads a piece from its front to its end.
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

std::uint64_t PackedArray::ping_bytes() const {
  std::uint64_t bytes = npy_item_bytes(descr).value_or(0);
  for (const std::uint64_t n : shape) bytes *= n;
  return bytes;
}

std::vector<PackedArray> packed_arrays(const SequenceInfo& info) {
  std::vector<PackedArray> arrays;
  for_each_array(info, [&](std::string file, const char* descr, PackedGrid grid, auto) {
    arrays.push_back({std::move(file), descr, shape_of(info, grid)});
  });
  return arrays;
}

std::optional<PackedForm> packed_form(std::string_view file) {
  std::optional<PackedForm> form;
  for_each_array(sequence_of_all(),
                 [&](const std::string& name, const char* descr, PackedGrid grid, auto) {
                   if (name == file) form = PackedForm{descr, grid};
                 });
  return form;
}

std::string encode_piece(const SequenceInfo& info, const PingResult& result) {
  std::uint64_t size = 0;
  for (const PackedArray& array : packed_arrays(info)) size += array.ping_bytes();
  std::string piece(size, '\0');
  char* out = piece.data();
  for_each_array(info,
                 [&](const std::string& file, const char* descr, PackedGrid grid, auto write) {
                   write(result, out);
                   out += PackedArray{file, descr, shape_of(info, grid)}.ping_bytes();
                 });
  return piece;
}

Result<std::vector<FileEntry>> write_arrays(const fs::path& dir, const SequenceInfo& info) {
  const std::vector<PackedArray> arrays = packed_arrays(info);
  std::vector<std::unique_ptr<StreamedFile>> files;
  for (const PackedArray& array : arrays) {
    files.push_back(
        std::make_unique<StreamedFile>(dir, layout::in_sequence(info.sequence, array.file)));
    NpyShape shape = {info.last_ping - info.first_ping};
    shape.insert(shape.end(), array.shape.begin(), array.shape.end());
    files.back()->append(npy_header(array.descr, shape));
  }
  for (std::uint32_t ping = info.first_ping; ping < info.last_ping && !arrays.empty(); ++ping) {
    PieceReader piece(dir /
                      layout::in_sequence(info.sequence, layout::ping_file(layout::kPiece, ping)));
    for (std::size_t i = 0; i < arrays.size(); ++i) {
      if (Status copied = piece.copy(arrays[i].ping_bytes(), *files[i]); !copied) {
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

std::string image_array(const SequenceInfo& info, std::string_view view) {
  const bool polar = view == "polar";
  const std::string name(view);
  if (info.output.png && (polar || info.output.cartesian)) return name + "_grey.npy";
  return (polar ? info.output.polar : info.output.cartesian) ? name + "_level_db.npy" : "";
}

}  // namespace ensonify
