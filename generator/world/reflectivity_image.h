// An image whose brightness scales the reflectivity of a mesh.
//
//   ReflectivityImage  load_reflectivity_image  parse_reflectivity_image
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>
#include <vector>

#include "core/error.h"

namespace ensonify {

inline constexpr std::int64_t kMaxImagePixels = 16'777'216;  // 4096 x 4096

// Factors from 0 to 1, row-major from the uppermost row.
struct ReflectivityImage {
  int rows = 0, columns = 0;
  std::vector<float> factors;

  // The factor at texture coordinates: u increases along the columns, v from the lowest row to the
  // uppermost one. The image covers [0, 1] x [0, 1] and repeats beyond. The centers of its pixels
  // are at ((i + 1/2) / columns, (j + 1/2) / rows); the factor is bilinear between them.
  float at(double u, double v) const;

  std::size_t bytes() const { return factors.size() * sizeof(float); }
};

// Reads a PNG file, grayscale or color: the mean of red, green and blue over the highest value. The
// file is untrusted. Errors: usage, `file: what is wrong; what is expected`, for a file that is not
// a PNG file, is damaged or has more than kMaxImagePixels; io if the file cannot be read.
Result<ReflectivityImage> load_reflectivity_image(const std::filesystem::path& file);

// The same from a file's bytes. Errors do not contain the file's name.
Result<ReflectivityImage> parse_reflectivity_image(std::string_view bytes);

}  // namespace ensonify
