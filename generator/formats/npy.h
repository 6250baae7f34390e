// NumPy's array format, little-endian and in C order where it is written here.
// (https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html)
//
//   npy_header          magic, version 1.0 and dictionary, padded to a multiple of 64
//   encode_npy          header and data of a whole array
//   encode_scatterers   the structured array of scatterers/*.npy
//   encode_via          that of scatterers/*_via.npy
//   encode_elevation    that of elevation/*.npy
//   parse_npy_header    what a header says, of any version and any writer
//   read_npy            an array of a data set, its shape checked
//   read_npy_row        one row of it
#pragma once

#include <complex>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "core/scatterers.h"
#include "core/vec.h"

namespace ensonify {

inline constexpr char kNpyUint8[] = "'|u1'";
inline constexpr char kNpyUint16[] = "'<u2'";
inline constexpr char kNpyInt32[] = "'<i4'";
inline constexpr char kNpyFloat16[] = "'<f2'";
inline constexpr char kNpyFloat32[] = "'<f4'";
inline constexpr char kNpyFloat64[] = "'<f8'";
inline constexpr char kNpyComplex64[] = "'<c8'";
inline constexpr char kNpyComplex128[] = "'<c16'";

// The dtype of scatterers/*.npy as it stands in the header: fields packed, in the order of
// docs and contract; 82 bytes an element.
extern const char* const kNpyScatterer;
// That of scatterers/*_via.npy.
extern const char* const kNpyVia;
// That of elevation/*.npy: the members of ElevationEcho, as they lie in memory.
extern const char* const kNpyElevation;

using NpyShape = std::vector<std::uint64_t>;

// `descr` is the dtype as Python writes it, quotes included: '<f8' or [('x', '<f8'), ...].
std::string npy_header(std::string_view descr, const NpyShape& shape);

// Needs data.size() to be the product of the shape.
std::string encode_npy(std::span<const std::int32_t> data, const NpyShape& shape);
std::string encode_npy(std::span<const float> data, const NpyShape& shape);
std::string encode_npy(std::span<const double> data, const NpyShape& shape);
std::string encode_npy(std::span<const std::complex<float>> data, const NpyShape& shape);

// `amplitudes` are the drawn ones, one per scatterer; the pose transforms positions to the world.
// Needs amplitudes.size() == scatterers.size(). Order is kept.
std::string encode_scatterers(const ScattererList& scatterers,
                              std::span<const std::complex<float>> amplitudes,
                              const Pose& sonar_in_world);

// Scatterer::via of each, in the order of the list.
std::string encode_via(const ScattererList& scatterers);

std::string encode_elevation(std::span<const ElevationEcho> echoes);

struct NpyHeader {
  std::string descr;  // as in npy_header
  bool fortran_order = false;
  NpyShape shape;
  std::uint64_t data_offset = 0;
};

// Reads the header at the start of a file's bytes. Error (usage), without the file's name: not an
// NPY file of versions 1 to 3, or an unreadable header.
Result<NpyHeader> parse_npy_header(std::string_view bytes);

// Bytes of one element of the dtypes above; none for others.
std::optional<std::uint64_t> npy_item_bytes(std::string_view descr);

struct NpyArray {
  NpyShape shape;
  std::string file;  // header and data
  std::size_t offset = 0;

  std::string_view data() const { return std::string_view(file).substr(offset); }
};

// The shape {0} stands for any length. Error (io): another type or shape, or cut off.
Result<NpyArray> read_npy(const std::filesystem::path& path, std::string_view descr,
                          const NpyShape& shape);

Result<std::string> read_npy_row(const std::filesystem::path& path, std::string_view descr,
                                 const NpyShape& shape, std::uint64_t row);

}  // namespace ensonify
