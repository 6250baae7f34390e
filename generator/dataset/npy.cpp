#include "dataset/npy.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <bit>
#include <charconv>
#include <cstring>

#include "core/error.h"

static_assert(std::endian::native == std::endian::little,
              "arrays are written as they lie in memory");

namespace ensonify {

const char* const kNpyScatterer =
    "[('delay_s', '<f8'), ('beam', '<i4'), ('azimuth_rad', '<f4'), ('elevation_rad', '<f4'), "
    "('amp_re', '<f4'), ('amp_im', '<f4'), ('mean_re', '<f4'), ('mean_im', '<f4'), "
    "('variance', '<f4'), ('gain', '<f4'), ('cos_incidence', '<f4'), ('doppler', '<f4'), "
    "('instance', '<u4'), ('path', '<u2'), ('x', '<f8'), ('y', '<f8'), ('z', '<f8')]";

namespace {

constexpr std::string_view kMagic{"\x93NUMPY\x01\x00", 8};
constexpr std::size_t kPrefixBytes = 10;  // magic, version, two bytes of header length
constexpr std::size_t kAlignment = 64;
constexpr std::size_t kScattererBytes = 82;

std::uint64_t element_count(const NpyShape& shape) {
  std::uint64_t count = 1;
  for (const std::uint64_t n : shape) count *= n;
  return count;
}

template <class T>
std::string encode(std::span<const T> data, std::string_view descr, const NpyShape& shape) {
  ENSONIFY_ASSERT(data.size() == element_count(shape));
  std::string bytes = npy_header(descr, shape);
  bytes.reserve(bytes.size() + data.size_bytes());
  bytes.append(static_cast<const char*>(static_cast<const void*>(data.data())), data.size_bytes());
  return bytes;
}

// Appends numbers one after another without padding.
class Packer {
 public:
  explicit Packer(char* at) : at_(at) {}
  template <class T>
  void put(T value) {
    std::memcpy(at_, &value, sizeof value);
    at_ += sizeof value;
  }

 private:
  char* at_;
};

// The text after `key` in the header's dictionary.
std::optional<std::string_view> after(std::string_view text, std::string_view key) {
  const auto at = text.find(key);
  if (at == std::string_view::npos) return std::nullopt;
  return text.substr(at + key.size());
}

std::optional<NpyShape> parse_shape(std::string_view text) {
  NpyShape shape;
  while (!text.empty() && text.front() != ')') {
    std::uint64_t n = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), n);
    if (error != std::errc()) return std::nullopt;
    shape.push_back(n);
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    while (!text.empty() && (text.front() == ',' || text.front() == ' ')) text.remove_prefix(1);
  }
  if (text.empty()) return std::nullopt;
  return shape;
}

}  // namespace

std::string npy_header(std::string_view descr, const NpyShape& shape) {
  // Python writes a tuple of one with a comma behind it.
  const std::string tuple =
      fmt::format("({}{})", fmt::join(shape, ", "), shape.size() == 1 ? "," : "");
  std::string dictionary =
      fmt::format("{{'descr': {}, 'fortran_order': False, 'shape': {}, }}", descr, tuple);
  const std::size_t whole = kPrefixBytes + dictionary.size() + 1;
  dictionary.append((kAlignment - whole % kAlignment) % kAlignment, ' ');
  dictionary += '\n';
  ENSONIFY_ASSERT(dictionary.size() < 65536);

  std::string header(kMagic);
  header += static_cast<char>(dictionary.size() & 0xff);
  header += static_cast<char>(dictionary.size() >> 8);
  return header + dictionary;
}

std::string encode_npy(std::span<const float> data, const NpyShape& shape) {
  return encode(data, kNpyFloat32, shape);
}
std::string encode_npy(std::span<const double> data, const NpyShape& shape) {
  return encode(data, kNpyFloat64, shape);
}
std::string encode_npy(std::span<const std::complex<float>> data, const NpyShape& shape) {
  return encode(data, kNpyComplex64, shape);
}

std::string encode_scatterers(const ScattererList& scatterers,
                              std::span<const std::complex<float>> amplitudes,
                              const Pose& sonar_in_world) {
  ENSONIFY_ASSERT(amplitudes.size() == scatterers.size());
  std::string bytes = npy_header(kNpyScatterer, {scatterers.size()});
  const std::size_t header = bytes.size();
  bytes.resize(header + kScattererBytes * scatterers.size());
  Packer packer(bytes.data() + header);
  for (std::size_t i = 0; i < scatterers.size(); ++i) {
    const Scatterer& s = scatterers.items[i];
    packer.put(s.delay_s);
    packer.put(static_cast<std::int32_t>(s.beam));
    packer.put(s.arrival.azimuth_rad);
    packer.put(s.arrival.elevation_rad);
    packer.put(amplitudes[i].real());
    packer.put(amplitudes[i].imag());
    packer.put(s.mean.real());
    packer.put(s.mean.imag());
    packer.put(s.standard_deviation * s.standard_deviation);
    packer.put(s.gain);
    packer.put(s.cos_incidence);
    packer.put(s.doppler);
    packer.put(s.instance);
    packer.put(s.path);
    const Vec3 world = transform_point(sonar_in_world, s.position_m);
    packer.put(world.x);
    packer.put(world.y);
    packer.put(world.z);
  }
  return bytes;
}

std::optional<NpyHeader> parse_npy_header(std::string_view bytes) {
  if (bytes.size() < kPrefixBytes || bytes.substr(0, kMagic.size()) != kMagic) return std::nullopt;
  const std::size_t length = static_cast<unsigned char>(bytes[8]) +
                             std::size_t{256} * static_cast<unsigned char>(bytes[9]);
  if (bytes.size() < kPrefixBytes + length) return std::nullopt;
  const std::string_view text = bytes.substr(kPrefixBytes, length);
  NpyHeader header;
  header.data_offset = kPrefixBytes + length;

  const auto descr = after(text, "'descr': ");
  const auto order = after(text, "'fortran_order': ");
  const auto tuple = after(text, "'shape': (");
  const auto descr_end = descr ? descr->find(", 'fortran_order'") : std::string_view::npos;
  if (descr_end == std::string_view::npos || !order || !tuple) return std::nullopt;
  header.descr = descr->substr(0, descr_end);
  header.fortran_order = order->starts_with("True");
  const auto shape = parse_shape(*tuple);
  if (!shape) return std::nullopt;
  header.shape = *shape;
  return header;
}

std::optional<std::uint64_t> npy_item_bytes(std::string_view descr) {
  if (descr == kNpyUint8) return 1;
  if (descr == kNpyUint16) return 2;
  if (descr == kNpyFloat16) return 2;
  if (descr == kNpyFloat32) return 4;
  if (descr == kNpyFloat64) return 8;
  if (descr == kNpyComplex64) return 8;
  if (descr == kNpyComplex128) return 16;
  if (descr == kNpyScatterer) return kScattererBytes;
  return std::nullopt;
}

}  // namespace ensonify
