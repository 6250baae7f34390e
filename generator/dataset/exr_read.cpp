#include "dataset/exr.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>

#include <new>

namespace ensonify {
namespace {

Error broken(const std::filesystem::path& path, const std::string& what) {
  return {ErrorKind::io, path.string() + ": not a readable EXR picture: " + what};
}

bool is_of_size(const Imf::Header& header, int rows, int columns) {
  const auto window = header.dataWindow();
  return window.min.x == 0 && window.min.y == 0 && window.max.x == columns - 1 &&
         window.max.y == rows - 1;
}

bool has_channel(const Imf::Header& header, const char* name, Imf::PixelType type) {
  const Imf::Channel* channel = header.channels().findChannel(name);
  return channel != nullptr && channel->type == type && channel->xSampling == 1 &&
         channel->ySampling == 1;
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

Result<ExrHalves> read_exr_halves(const std::filesystem::path& path, int rows, int columns) {
  const auto size = static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
  const std::size_t stride = static_cast<std::size_t>(columns) * sizeof(std::uint16_t);
  ExrHalves halves;
  const std::vector<std::pair<const char*, std::vector<std::uint16_t>*>> channels[] = {
      {{"Y", &halves.level_db}},
      {{"clean_db", &halves.clean_db},
       {"elevation_rad", &halves.elevation_rad},
       {"elevation_std_rad", &halves.elevation_std_rad},
       {"instance_fraction", &halves.instance_fraction}}};
  try {
    Imf::MultiPartInputFile file(path.c_str(), 0, false);
    if (file.parts() != 2) return broken(path, "it has not two parts");
    for (int part = 0; part < 2; ++part) {
      const Imf::Header& header = file.header(part);
      if (!is_of_size(header, rows, columns)) {
        return broken(path, "it is not of the size that sequence.json tells");
      }
      Imf::FrameBuffer buffer;
      for (const auto& [name, values] : channels[part]) {
        if (!has_channel(header, name, Imf::HALF)) {
          return broken(path, std::string("it lacks the half channel ") + name);
        }
        values->resize(size);
        char* base = static_cast<char*>(static_cast<void*>(values->data()));
        buffer.insert(name, Imf::Slice(Imf::HALF, base, sizeof(std::uint16_t), stride));
      }
      Imf::InputPart input(file, part);
      input.setFrameBuffer(buffer);
      input.readPixels(0, rows - 1);
    }
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    return broken(path, error.what());
  }
  return halves;
}

Result<std::vector<std::complex<float>>> read_series_exr(const std::filesystem::path& path,
                                                         int samples, int beams) {
  using Value = std::complex<float>;
  std::vector<Value> series;
  try {
    Imf::MultiPartInputFile file(path.c_str(), 0, false);
    if (file.parts() != 1) return broken(path, "it has not one part");
    const Imf::Header& header = file.header(0);
    if (!is_of_size(header, samples, beams)) {
      return broken(path, "it is not of the size that sequence.json tells");
    }
    for (const char* name : {"p.re", "p.im"}) {
      if (!has_channel(header, name, Imf::FLOAT)) {
        return broken(path, std::string("it lacks the float channel ") + name);
      }
    }
    series.resize(static_cast<std::size_t>(samples) * static_cast<std::size_t>(beams));
    // The picture's columns are the rows of the series.
    char* base = static_cast<char*>(static_cast<void*>(series.data()));
    const std::size_t beam = static_cast<std::size_t>(samples) * sizeof(Value);
    Imf::FrameBuffer buffer;
    buffer.insert("p.re", Imf::Slice(Imf::FLOAT, base, beam, sizeof(Value)));
    buffer.insert("p.im", Imf::Slice(Imf::FLOAT, base + sizeof(float), beam, sizeof(Value)));
    Imf::InputPart input(file, 0);
    input.setFrameBuffer(buffer);
    input.readPixels(0, samples - 1);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    return broken(path, error.what());
  }
  return series;
}

}  // namespace ensonify
