// NumPy's array format, version 1.0, little-endian and in C order.
// (https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html)
//
//   npy_header                     magic, version and dictionary, padded to a multiple of 64
//   encode_npy                     header and data of a whole array
//   encode_scatterers              the structured array of scatterers/*.npy
//   parse_npy_header               what a header says
#pragma once

#include <complex>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/scatterers.h"
#include "core/vec.h"

namespace ensonify {

inline constexpr char kNpyUint8[] = "'|u1'";
inline constexpr char kNpyUint16[] = "'<u2'";
inline constexpr char kNpyFloat16[] = "'<f2'";
inline constexpr char kNpyFloat32[] = "'<f4'";
inline constexpr char kNpyFloat64[] = "'<f8'";
inline constexpr char kNpyComplex64[] = "'<c8'";
inline constexpr char kNpyComplex128[] = "'<c16'";

// The dtype of scatterers/*.npy as it stands in the header: fields packed, in the order of
// docs and contract; 82 bytes an element.
extern const char* const kNpyScatterer;

using NpyShape = std::vector<std::uint64_t>;

// `descr` is the dtype as Python writes it, quotes included: '<f8' or [('x', '<f8'), ...].
std::string npy_header(std::string_view descr, const NpyShape& shape);

// Needs data.size() to be the product of the shape.
std::string encode_npy(std::span<const float> data, const NpyShape& shape);
std::string encode_npy(std::span<const double> data, const NpyShape& shape);
std::string encode_npy(std::span<const std::complex<float>> data, const NpyShape& shape);

// Amplitudes as drawn stand beside the list, one each; positions go to the world by the pose.
// Needs amplitudes.size() == scatterers.size(). Order is kept.
std::string encode_scatterers(const ScattererList& scatterers,
                              std::span<const std::complex<float>> amplitudes,
                              const Pose& sonar_in_world);

struct NpyHeader {
  std::string descr;
  bool fortran_order = false;
  NpyShape shape;
  std::uint64_t data_offset = 0;
};

// Reads the header at the start of a file's bytes; none if it is not one that ensonify writes.
std::optional<NpyHeader> parse_npy_header(std::string_view bytes);

// Bytes of one element of the dtypes above; none for others.
std::optional<std::uint64_t> npy_item_bytes(std::string_view descr);

}  // namespace ensonify
