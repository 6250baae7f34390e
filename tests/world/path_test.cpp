#include "world/path.h"

#include "catch.h"
#include "core/units.h"
#include "temporary_folder.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

TrajectorySpec from_file(const std::filesystem::path& file) {
  TrajectorySpec spec;
  spec.path = PathFileSpec{file};
  return spec;
}

const std::vector<PathPoint>& points_of(const Path& path) {
  return std::get<SampledWay>(path.way).points;
}

}  // namespace

// Protects the order of columns: TUM writes qx qy qz qw, ours are w first.
TEST_CASE("TUM files") {
  const TemporaryFolder folder;
  const auto path =
      load_path(from_file(folder.write("a.tum",
                                       "# time x y z qx qy qz qw\n\n1.5 1 2 3 0 0 0.7071 0.7071\n"
                                       "2.5 3 2 3 0 0 0 1\n")),
                0);
  REQUIRE(path.ok());
  REQUIRE(points_of(*path).size() == 2);
  CHECK(points_of(*path)[0].time_s == 1.5);
  CHECK(points_of(*path)[0].pose.position_m == Vec3{1, 2, 3});
  CHECK(length(rotate(points_of(*path)[0].pose.rotation, {1, 0, 0}) - Vec3{0, 1, 0}) < 1e-12);
  CHECK(pose_at(*path, 2.0).position_m == Vec3{2, 2, 3});
  CHECK(length(rotate(pose_at(*path, 2.0).rotation, {1, 0, 0}) -
               Vec3{std::sqrt(0.5), std::sqrt(0.5), 0}) < 1e-9);
  CHECK(pose_at(*path, 0).position_m == Vec3{1, 2, 3});
  CHECK(pose_at(*path, 9).position_m == Vec3{3, 2, 3});
}

TEST_CASE("CSV files by the names in their header") {
  const TemporaryFolder folder;
  const auto path = load_path(
      from_file(folder.write(
          "a.csv", "ping,time_s,x,y,z,qw,qx,qy,qz\n0,10,1,2,3,1,0,0,0\n1,11,2,2,3,1,0,0,0\n")),
      0);
  REQUIRE(path.ok());
  CHECK(points_of(*path)[1].time_s == 11);
  CHECK(points_of(*path)[1].pose.position_m.x == 2);
}

TEST_CASE("broken path files are refused with the line") {
  const TemporaryFolder folder;
  const auto refuse = [&](const std::string& name, const std::string& text,
                          const std::string& where) {
    INFO(name);
    const auto path = load_path(from_file(folder.write(name, text)), 0);
    REQUIRE_FALSE(path.ok());
    CHECK(path.error().kind == ErrorKind::usage);
    CHECK(path.error().message.find(name + where) != std::string::npos);
  };
  refuse("back.tum", "2 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n", ":2: time 1 does not come after 2");
  refuse("word.tum", "1 0 0 zero 0 0 0 1\n", ":1: 'zero'");
  refuse("nan.tum", "1 0 0 nan 0 0 0 1\n", ":1: 'nan'");
  refuse("short.tum", "1 0 0 0 0 0 1\n", ":1: 7 numbers");
  refuse("norot.tum", "1 0 0 0 0 0 0 0\n", ":1: a quaternion of length 0");
  refuse("empty.tum", "# nothing\n", ": holds no poses");
  refuse("cell.csv", "time_s,x,y,z,qw,qx,qy,qz\n1,2,,3,1,0,0,0\n", ":2: '' is not");
  refuse("blank.csv", "time_s,x,y,z,qw,qx,qy,qz\n1,2 3,0,3,1,0,0,0\n", ":2: '2 3' is not");
  refuse("UPPER.CSV", "time_s,x,y,z,qw,qx,qy,qz\n1,a,0,3,1,0,0,0\n", ":2: 'a' is not");
  refuse("header.csv", "t,x,y,z,qw,qx,qy,qz\n", ":1: the header has no column time_s");
}

// Protects the number of pings: both ends of the path included, its first stamp the start, and
// nothing invented past its end.
TEST_CASE("ping times") {
  const Path path{SampledWay{{{100, {}}, {103, {}}}}, {}};
  TrajectorySpec spec;
  spec.ping_rate_hz = 10;
  const auto whole = ping_times(spec, path);
  REQUIRE(whole.ok());
  CHECK(whole->size() == 31);
  CHECK(whole->front() == 100);
  CHECK(whole->back() == Approx(103));
  spec.pings = 5;
  CHECK(ping_times(spec, path)->size() == 5);
  spec.pings = 32;
  CHECK_FALSE(ping_times(spec, path).ok());
  const Path still{SampledWay{{{0, {}}}}, {}};
  CHECK(ping_times(spec, still)->size() == 32);
}

// Protects recorded paths: at Unix times a stamp's last digit is 2e-7 s.
TEST_CASE("large stamps cost no ping") {
  const Path path{SampledWay{{{1700000000.0, {}}, {1700000000.6, {}}}}, {}};
  TrajectorySpec spec;
  spec.ping_rate_hz = 5;
  const auto times = ping_times(spec, path);
  REQUIRE(times.ok());
  CHECK(times->size() == 4);
}

// Protects `pings` left out: a way by a formula has a length of its own.
TEST_CASE("ways by formula hold as many pings as they last") {
  TrajectorySpec spec;
  spec.ping_rate_hz = 2;
  OrbitSpec orbit;
  orbit.radius_m = 5 / kPi;
  orbit.speed_m_s = 1;
  orbit.start_time_s = 50;
  spec.path = orbit;
  const auto path = load_path(spec, 0);
  REQUIRE(path.ok());
  const auto times = ping_times(spec, *path);
  REQUIRE(times.ok());
  CHECK(times->size() == 21);
  CHECK(times->front() == 50);
  CHECK(times->back() == Approx(60));
  spec.pings = 22;
  CHECK_FALSE(ping_times(spec, *path).ok());
  spec.ping_rate_hz = 1e6;
  spec.pings.reset();
  const auto many = ping_times(spec, *path);
  REQUIRE_FALSE(many.ok());
  CHECK(many.error().message.find("at most 1000000") != std::string::npos);
}
