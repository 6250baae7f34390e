// Reads the files that exr.cpp writes, with OpenEXR.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>

#include <new>
#include <utility>

#include "formats/exr.h"

namespace ensonify {
namespace {

Error broken(const std::filesystem::path& path, const std::string& what) {
  return {ErrorKind::io, path.string() + ": not a readable EXR image: " + what};
}

// Where the pixels of a channel go.
struct Slot {
  const char* name;
  Imf::PixelType type;
  void* base;
  std::size_t column_bytes, row_bytes;  // from one pixel to the next
};

// Reads the pixels of a part; returns what is wrong with it, or nothing.
std::string read_part(Imf::MultiPartInputFile& file, int part, int rows, int columns,
                      const std::vector<Slot>& slots) {
  const Imf::Header& header = file.header(part);
  const auto window = header.dataWindow();
  if (window.min.x != 0 || window.min.y != 0 || window.max.x != columns - 1 ||
      window.max.y != rows - 1) {
    return "its size is not the one in sequence.json";
  }
  Imf::FrameBuffer buffer;
  for (const Slot& slot : slots) {
    const Imf::Channel* channel = header.channels().findChannel(slot.name);
    if (channel == nullptr || channel->type != slot.type || channel->xSampling != 1 ||
        channel->ySampling != 1) {
      const std::string type = slot.type == Imf::HALF ? "half" : "float";
      return "it has no " + type + " channel " + slot.name;
    }
    buffer.insert(slot.name, Imf::Slice(slot.type, static_cast<char*>(slot.base), slot.column_bytes,
                                        slot.row_bytes));
  }
  Imf::InputPart input(file, part);
  input.setFrameBuffer(buffer);
  input.readPixels(0, rows - 1);
  return {};
}

// The slots of each part in turn. Throws std::bad_alloc.
Status read_pixels(const std::filesystem::path& path, int rows, int columns,
                   const std::vector<std::vector<Slot>>& parts) {
  try {
    Imf::MultiPartInputFile file(path.c_str(), 0, false);
    if (std::cmp_not_equal(file.parts(), parts.size())) {
      return broken(path,
                    parts.size() == 1 ? "it does not have one part" : "it does not have two parts");
    }
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const std::string fault = read_part(file, static_cast<int>(i), rows, columns, parts[i]);
      if (!fault.empty()) return broken(path, fault);
    }
    return {};
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    return broken(path, error.what());
  }
}

}  // namespace

Result<std::vector<ExrPart>> read_exr_parts(const std::filesystem::path& path) {
  try {
    Imf::MultiPartInputFile file(path.c_str(), 0, false);
    std::vector<ExrPart> parts;
    for (int i = 0; i < file.parts(); ++i) {
      const Imf::Header& header = file.header(i);
      ExrPart part;
      part.name = header.hasName() ? header.name() : "";
      const auto window = header.dataWindow();
      part.width = window.max.x - window.min.x + 1;
      part.height = window.max.y - window.min.y + 1;
      for (auto c = header.channels().begin(); c != header.channels().end(); ++c) {
        auto& channels = c.channel().type == Imf::HALF    ? part.half_channels
                         : c.channel().type == Imf::FLOAT ? part.float_channels
                                                          : part.other_channels;
        channels.emplace_back(c.name());
      }
      parts.push_back(std::move(part));
    }
    return parts;
  } catch (const std::exception& error) {
    return Error{ErrorKind::damage, path.string() + ": not a readable EXR file: " + error.what()};
  }
}

Result<ExrHalves> read_half_channels(const std::filesystem::path& path, int rows, int columns,
                                     std::span<const ExrNames> parts) {
  const auto width = static_cast<std::size_t>(columns);
  ExrHalves halves;
  std::vector<std::vector<Slot>> slots;
  for (const ExrNames& names : parts) {
    slots.emplace_back();
    for (const char* name : names) {
      std::vector<std::uint16_t>& values = halves[name];
      values.resize(static_cast<std::size_t>(rows) * width);
      slots.back().push_back(
          {name, Imf::HALF, values.data(), sizeof(std::uint16_t), sizeof(std::uint16_t) * width});
    }
  }
  const Status read = read_pixels(path, rows, columns, slots);
  if (!read) return read.error();
  return halves;
}

Result<ExrFloats> read_float_channels(const std::filesystem::path& path, int rows, int columns,
                                      const ExrNames& names) {
  const auto width = static_cast<std::size_t>(columns);
  ExrFloats floats;
  std::vector<Slot> slots;
  for (const char* name : names) {
    std::vector<float>& values = floats[name];
    values.resize(static_cast<std::size_t>(rows) * width);
    slots.push_back({name, Imf::FLOAT, values.data(), sizeof(float), sizeof(float) * width});
  }
  const Status read = read_pixels(path, rows, columns, {slots});
  if (!read) return read.error();
  return floats;
}

Result<std::vector<std::complex<float>>> read_series_exr(const std::filesystem::path& path,
                                                         int samples, int beams) {
  constexpr std::size_t kPixel = sizeof(std::complex<float>);
  const std::size_t beam = static_cast<std::size_t>(samples) * kPixel;
  std::vector<std::complex<float>> series(static_cast<std::size_t>(samples) *
                                          static_cast<std::size_t>(beams));
  // The image's columns are the rows of the series.
  char* const base = static_cast<char*>(static_cast<void*>(series.data()));
  const Status read = read_pixels(path, samples, beams,
                                  {{{"p.re", Imf::FLOAT, base, beam, kPixel},
                                    {"p.im", Imf::FLOAT, base + sizeof(float), beam, kPixel}}});
  if (!read) return read.error();
  return series;
}

}  // namespace ensonify
