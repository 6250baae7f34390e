#include "formats/npy.h"

#include <cstring>
#include <vector>

#include "catch.h"
#include "dataset/echo_arrays.h"
#include "dataset/sample.h"
#include "results.h"

using namespace ensonify;

namespace {

template <class T>
T at(const std::string& bytes, std::size_t offset) {
  T value;
  REQUIRE(offset + sizeof value <= bytes.size());
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

}  // namespace

// Protects the format itself: magic, version 1.0, little-endian length, a dictionary that Python
// can evaluate, newline at the end, data aligned to 64 whatever the shape's length.
TEST_CASE("npy header follows the format's description") {
  for (const NpyShape& shape :
       {NpyShape{}, NpyShape{7}, NpyShape{512, 2392}, NpyShape{123456789, 98765, 4321}}) {
    const std::string header = npy_header(kNpyComplex64, shape);
    CHECK(header.substr(0, 8) == std::string("\x93NUMPY\x01\x00", 8));
    CHECK(at<std::uint16_t>(header, 8) + 10u == header.size());
    CHECK(header.size() % 64 == 0);
    CHECK(header.back() == '\n');
  }
  const std::string one = npy_header(kNpyFloat32, {7});
  CHECK(one.substr(10, 59) == "{'descr': '<f4', 'fortran_order': False, 'shape': (7,), }  ");
  CHECK(contains(npy_header(kNpyFloat64, {2, 3}), "'shape': (2, 3), }"));
}

// Protects the order of elements: C order, real part before imaginary part.
TEST_CASE("npy data follow the header as they lie in memory") {
  const std::vector<std::complex<float>> data = {{1, 2}, {3, 4}, {5, 6}, {7, 8}, {9, 10}, {11, 12}};
  const std::string bytes = encode_npy(data, {2, 3});
  const std::size_t header = npy_header(kNpyComplex64, {2, 3}).size();
  REQUIRE(bytes.size() == header + 48);
  for (int i = 0; i < 12; ++i) CHECK(at<float>(bytes, header + 4 * i) == i + 1);
}

// Protects the names, types and order of the scatterers' fields, which outside readers rely on.
TEST_CASE("scatterer array has the promised fields") {
  const auto info = sample::sequence_info(0);
  const auto result = sample::ping_result(info, 1);
  const std::string bytes =
      encode_scatterers(result.scatterers, result.amplitudes, result.sonar_in_world);
  const auto header = value_of(parse_npy_header(bytes));
  CHECK(header.descr ==
        "[('delay_s', '<f8'), ('beam', '<i4'), ('azimuth_rad', '<f4'), ('elevation_rad', '<f4'), "
        "('amp_re', '<f4'), ('amp_im', '<f4'), ('mean_re', '<f4'), ('mean_im', '<f4'), "
        "('variance', '<f4'), ('gain', '<f4'), ('cos_incidence', '<f4'), ('doppler', '<f4'), "
        "('instance', '<u4'), ('path', '<u2'), ('x', '<f8'), ('y', '<f8'), ('z', '<f8')]");
  CHECK(header.shape == NpyShape{2});
  REQUIRE(bytes.size() == header.data_offset + 2 * 82);

  const std::size_t first = header.data_offset;
  CHECK(at<double>(bytes, first) == 1e-3);
  CHECK(at<double>(bytes, first + 82) == 2e-3);
  CHECK(at<std::int32_t>(bytes, first + 8) == 3);
  CHECK(at<float>(bytes, first + 12) == 0.05f);
  CHECK(at<float>(bytes, first + 16) == -0.1f);
  CHECK(at<float>(bytes, first + 20) == 1);
  CHECK(at<float>(bytes, first + 24) == 2);
  CHECK(at<float>(bytes, first + 28) == 0.1f);
  CHECK(at<float>(bytes, first + 32) == 0.2f);
  CHECK(at<float>(bytes, first + 36) == 9);  // the variance, not the deviation
  CHECK(at<float>(bytes, first + 40) == 0.5f);
  CHECK(at<float>(bytes, first + 44) == 0.9f);
  CHECK(at<float>(bytes, first + 48) == 1e-4f);
  CHECK(at<std::uint32_t>(bytes, first + 52) == 2);
  CHECK(at<std::uint16_t>(bytes, first + 56) == 1);
}

// Protects the frame of x, y, z: world, so the sonar's pose must have been applied. The sonar of
// ping 1 is at (1/3 + 1, 2, -3), turned by 90 degrees: its x is the world's y.
TEST_CASE("scatterer positions are in the world") {
  const auto result = sample::ping_result(sample::sequence_info(0), 1);
  const std::string bytes =
      encode_scatterers(result.scatterers, result.amplitudes, result.sonar_in_world);
  const std::size_t first = parse_npy_header(bytes)->data_offset;
  CHECK(at<double>(bytes, first + 58) == Approx(4.0 / 3 - 0.25));
  CHECK(at<double>(bytes, first + 66) == Approx(2 + 0.75));
  CHECK(at<double>(bytes, first + 74) == Approx(-3 - 0.5));
}

// Protects verify: a header that says something else than the writer's must be seen as that.
TEST_CASE("npy header reads back") {
  const auto header = value_of(parse_npy_header(encode_npy(std::vector<double>(6), {2, 3})));
  CHECK(header.descr == kNpyFloat64);
  CHECK_FALSE(header.fortran_order);
  CHECK(header.shape == NpyShape{2, 3});
  CHECK_FALSE(parse_npy_header("\x93NUMPY"));
  CHECK_FALSE(parse_npy_header(std::string(200, 'x')));
}
