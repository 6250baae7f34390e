#include "dataset/geometry_files.h"

#include <cstring>

#include "catch.h"
#include "core/units.h"
#include "dataset/sample.h"
#include "results.h"

using namespace ensonify;

namespace {

template <class T>
T take(const char*& at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  at += sizeof value;
  return value;
}

}  // namespace

// Protects whoever opens the cloud: the header's properties, in their order and width, hold the
// points where they are in the world.
TEST_CASE("a point cloud holds every scatterer in the world") {
  const SequenceInfo info = sample::sequence_info(0);
  const PingResult ping = sample::ping_result(info, 1);
  const std::vector<std::uint8_t> classes{0, 1, 2};
  const std::string bytes = encode_points(ping.scatterers, ping.sonar_in_world, 1e5, classes);
  const std::string_view end = "end_header\n";
  const std::size_t header = bytes.find(end) + end.size();
  CHECK(bytes.starts_with("ply\nformat binary_little_endian 1.0\n"));
  CHECK(contains(bytes, "element vertex 2\n"));
  REQUIRE(bytes.size() == header + 2 * 53);
  const char* at = bytes.data() + header;
  // The sample's sonar looks along y from (4/3, 2, -3); the point is at (0.75, 0.25, -0.5) of it.
  CHECK(take<double>(at) == Approx(4.0 / 3 - 0.25));
  CHECK(take<double>(at) == Approx(2.75));
  CHECK(take<double>(at) == Approx(-3.5));
  // 20 log10(1e5 x sqrt(0.05 + 9) x 0.5) + 120
  CHECK(take<float>(at) == Approx(223.5456).margin(1e-3));
  CHECK(take<float>(at) == Approx(std::sqrt(0.875)));
  CHECK(take<float>(at) == 0.05f);
  CHECK(take<float>(at) == -0.1f);
  CHECK(take<float>(at) == 0.9f);
  CHECK(take<std::int32_t>(at) == 3);
  CHECK(take<std::uint16_t>(at) == 2);
  CHECK(take<std::uint8_t>(at) == 2);
  CHECK(take<std::uint16_t>(at) == 1);
}

// Protects verify: a cloud cut short, or with a header that promises more, is found.
TEST_CASE("a point cloud that is not whole is found") {
  const SequenceInfo info = sample::sequence_info(0);
  const PingResult ping = sample::ping_result(info, 1);
  const std::vector<std::uint8_t> classes{0, 1, 2};
  std::string bytes = encode_points(ping.scatterers, ping.sonar_in_world, 1e5, classes);
  const sample::TemporaryFolder folder;
  const auto fault = [&] {
    const auto path = folder.path() / "a.ply";
    sample::write(path, bytes);
    return ply_fault(path);
  };
  CHECK(fault().empty());
  SECTION("cut short") { bytes.pop_back(); }
  SECTION("more points") { bytes.replace(bytes.find("vertex 2"), 8, "vertex 3"); }
  SECTION("another property") { bytes.replace(bytes.find("double x"), 8, "double u"); }
  SECTION("text") { bytes = "points\n"; }
  CHECK_FALSE(fault().empty());
}
