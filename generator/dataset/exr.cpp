#include "dataset/exr.h"

#include <ImfChannelList.h>
#include <ImfCompression.h>
#include <ImfDoubleAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfPartType.h>
#include <ImfStringAttribute.h>
#include <ImfVersion.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <span>

#include "core/units.h"
#include "dataset/deflate.h"
#include "dataset/files.h"
#include "dataset/half_floats.h"

static_assert(std::endian::native == std::endian::little,
              "pixels are written as they lie in memory");

namespace ensonify {
namespace {

// Where OpenEXR writes headers to.
class MemoryStream : public Imf::OStream {
 public:
  explicit MemoryStream(std::string& bytes) : Imf::OStream("memory"), bytes_(bytes) {}

  void write(const char* data, int size) override {
    bytes_.append(data, static_cast<std::size_t>(size));
  }
  std::uint64_t tellp() override { return bytes_.size(); }
  void seekp(std::uint64_t) override { ENSONIFY_ASSERT(false); }

 private:
  std::string& bytes_;
};

struct Channel {
  const char* name;
  std::span<const float> values;
};

struct Part {
  const char* name;
  const char* units;
  std::vector<Channel> channels;  // sorted by name, as the file holds them
  Imf::Compression compression;
};

// Longer ones need another flag in the file's version.
constexpr std::size_t kMaxNameLength = 31;

// Rows that stand together in one chunk, as the format says.
int chunk_rows(const Part& part) { return part.compression == Imf::ZIP_COMPRESSION ? 16 : 1; }

int chunk_count(const Part& part, const LabelledImage& image) {
  return (image.rows + chunk_rows(part) - 1) / chunk_rows(part);
}

template <class T>
void put(std::string& bytes, T value) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes.append(raw, sizeof raw);
}

void insert(const ExrAttributes& attributes, Imf::Header& header) {
  for (const auto& [key, text] : attributes.texts) {
    ENSONIFY_ASSERT(key.size() <= kMaxNameLength);
    header.insert(key, Imf::StringAttribute(text));
  }
  for (const auto& [key, number] : attributes.numbers) {
    ENSONIFY_ASSERT(key.size() <= kMaxNameLength);
    header.insert(key, Imf::DoubleAttribute(number));
  }
}

Imf::Header part_header(const Part& part, const LabelledImage& image,
                        const ExrAttributes& attributes) {
  Imf::Header header(image.columns, image.rows);
  header.setName(part.name);
  header.setType(Imf::SCANLINEIMAGE);
  header.setChunkCount(chunk_count(part, image));
  header.compression() = part.compression;
  header.insert("units", Imf::StringAttribute(part.units));
  insert(attributes, header);
  for (const Channel& channel : part.channels) {
    header.channels().insert(channel.name, Imf::Channel(Imf::HALF));
  }
  return header;
}

// What ZIP makes of a chunk before it is deflated: bytes of even places, then those of odd ones,
// each as its difference from the one before.
void predict(std::span<const std::uint16_t> halves, std::vector<std::uint8_t>& planes,
             std::vector<std::uint8_t>& differences) {
  const std::size_t n = halves.size();
  planes.resize(2 * n);
  differences.resize(2 * n);
  for (std::size_t i = 0; i < n; ++i) planes[i] = static_cast<std::uint8_t>(halves[i]);
  for (std::size_t i = 0; i < n; ++i) planes[n + i] = static_cast<std::uint8_t>(halves[i] >> 8);
  differences[0] = planes[0];
  for (std::size_t i = 1; i < 2 * n; ++i) {
    differences[i] = static_cast<std::uint8_t>(planes[i] - planes[i - 1] + 128);
  }
}

class ChunkWriter {
 public:
  ChunkWriter(const LabelledImage& image, std::string& bytes) : image_(image), bytes_(bytes) {}

  // The chunks of a part, and where each begins into the table at `offsets`.
  void write_part(const Part& part, int number, std::size_t offsets) {
    for (int row = 0; row < image_.rows; row += chunk_rows(part), offsets += 8) {
      const std::uint64_t here = bytes_.size();
      std::memcpy(bytes_.data() + offsets, &here, sizeof here);
      put(bytes_, std::int32_t{number});
      put(bytes_, std::int32_t{row});
      gather(part, row, std::min(image_.rows, row + chunk_rows(part)));
      put_pixels(part.compression);
    }
  }

 private:
  void gather(const Part& part, int begin, int end) {
    const auto columns = static_cast<std::size_t>(image_.columns);
    halves_.resize(static_cast<std::size_t>(end - begin) * columns * part.channels.size());
    std::span<std::uint16_t> left = halves_;
    for (int row = begin; row < end; ++row) {
      for (const Channel& channel : part.channels) {
        to_halves(channel.values.subspan(static_cast<std::size_t>(row) * columns, columns),
                  left.first(columns));
        left = left.subspan(columns);
      }
    }
  }
  void put_pixels(Imf::Compression compression) {
    const std::size_t plain_size = halves_.size() * sizeof(std::uint16_t);
    put(bytes_, static_cast<std::int32_t>(plain_size));
    const std::size_t start = bytes_.size();
    if (compression == Imf::ZIP_COMPRESSION) {
      predict(halves_, planes_, differences_);
      append_zlib(differences_, Content::runs, bytes_);
      const std::size_t size = bytes_.size() - start;
      if (size < plain_size) {
        const auto stored = static_cast<std::int32_t>(size);
        std::memcpy(bytes_.data() + start - sizeof stored, &stored, sizeof stored);
        return;
      }
    }
    // Readers tell by its size that a chunk is not compressed.
    bytes_.resize(start + plain_size);
    std::memcpy(bytes_.data() + start, halves_.data(), plain_size);
  }

  const LabelledImage& image_;
  std::string& bytes_;
  std::vector<std::uint16_t> halves_;
  std::vector<std::uint8_t> planes_, differences_;
};

Imf::Header series_header(int samples, int beams, const ExrAttributes& attributes) {
  Imf::Header header(beams, samples);
  header.compression() = Imf::NO_COMPRESSION;
  header.insert("units", Imf::StringAttribute("p.re, p.im: Pa (rms), complex baseband"));
  insert(attributes, header);
  for (const char* name : {"p.im", "p.re"}) {
    header.channels().insert(name, Imf::Channel(Imf::FLOAT));
  }
  return header;
}

// The rows of a series, each a chunk of its own: y, size, p.im of all beams, p.re of all beams.
// The table of their places comes first.
void append_series_chunks(std::span<const std::complex<float>> series, int samples, int beams,
                          std::string& bytes) {
  const std::size_t table = bytes.size(), first = table + 8 * std::size_t(samples);
  const std::size_t row_bytes = 2 * sizeof(float) * std::size_t(beams);
  const std::size_t chunk_bytes = 2 * sizeof(std::int32_t) + row_bytes;
  bytes.resize(first + samples * chunk_bytes);
  for (std::int32_t n = 0; n < samples; ++n) {
    const std::uint64_t here = first + n * chunk_bytes;
    const std::int32_t head[] = {n, static_cast<std::int32_t>(row_bytes)};
    std::memcpy(bytes.data() + table + 8 * std::size_t(n), &here, sizeof here);
    std::memcpy(bytes.data() + here, head, sizeof head);
  }
  // Samples of one beam lie side by side: a few of them at once, so that none is fetched twice.
  constexpr int kBlockSamples = 16;
  for (int begin = 0; begin < samples; begin += kBlockSamples) {
    const int end = std::min(samples, begin + kBlockSamples);
    for (int j = 0; j < beams; ++j) {
      for (int n = begin; n < end; ++n) {
        const std::complex<float> p = series[std::size_t(j) * samples + n];
        const float parts[] = {p.imag(), p.real()};
        char* row = bytes.data() + first + n * chunk_bytes + 2 * sizeof(std::int32_t);
        std::memcpy(row + sizeof(float) * j, &parts[0], sizeof(float));
        std::memcpy(row + sizeof(float) * (std::size_t(beams) + j), &parts[1], sizeof(float));
      }
    }
  }
}

}  // namespace

Result<std::string> encode_series_exr(std::span<const std::complex<float>> series, int samples,
                                      int beams, const ExrAttributes& attributes) {
  ENSONIFY_ASSERT(samples > 0 && beams > 0);
  ENSONIFY_ASSERT(series.size() == std::size_t(samples) * std::size_t(beams));
  return without_exceptions("encoding a series as EXR", [&]() -> Result<std::string> {
    std::string bytes;
    put(bytes, std::int32_t{Imf::MAGIC});
    put(bytes, std::int32_t{Imf::EXR_VERSION});
    MemoryStream stream(bytes);
    series_header(samples, beams, attributes).writeTo(stream);
    append_series_chunks(series, samples, beams, bytes);
    return bytes;
  });
}

Result<std::string> encode_exr(const LabelledImage& image, const ExrAttributes& attributes) {
  const Part parts[] = {
      {"level", "dB re 1 uPa", {{"Y", image.level_db}}, Imf::NO_COMPRESSION},
      {"labels",
       "clean_db: dB re 1 uPa; elevation_rad, elevation_std_rad: rad; instance_fraction: 1",
       {{"clean_db", image.clean_db},
        {"elevation_rad", image.elevation_rad},
        {"elevation_std_rad", image.elevation_std_rad},
        {"instance_fraction", image.instance_fraction}},
       Imf::ZIP_COMPRESSION}};
  ENSONIFY_ASSERT(image.rows > 0 && image.columns > 0);
  const auto pixels =
      static_cast<std::size_t>(image.rows) * static_cast<std::size_t>(image.columns);
  for (const Part& part : parts) {
    for (const Channel& channel : part.channels) ENSONIFY_ASSERT(channel.values.size() == pixels);
  }

  return without_exceptions("encoding an EXR picture", [&]() -> Result<std::string> {
    ExrAttributes common = attributes;
    common.texts.emplace_back("no_energy", "-99 dB; NaN for angles");
    std::string bytes;
    bytes.reserve(pixels * sizeof(std::uint16_t) * 5 / 2);
    put(bytes, std::int32_t{Imf::MAGIC});
    put(bytes, std::int32_t{Imf::EXR_VERSION | Imf::MULTI_PART_FILE_FLAG});
    MemoryStream stream(bytes);
    for (const Part& part : parts) part_header(part, image, common).writeTo(stream);
    bytes += '\0';

    std::size_t offsets = bytes.size();
    for (const Part& part : parts) {
      bytes.resize(bytes.size() + 8 * static_cast<std::size_t>(chunk_count(part, image)));
    }
    ChunkWriter writer(image, bytes);
    for (int i = 0; i < 2; ++i) {
      writer.write_part(parts[i], i, offsets);
      offsets += 8 * static_cast<std::size_t>(chunk_count(parts[i], image));
    }
    return bytes;
  });
}

}  // namespace ensonify
