// Files of paths: TUM, CSV and EuRoC.
#include "world/path.h"

#include <algorithm>
#include <cmath>

#include "catch.h"
#include "core/units.h"
#include "is_refused.h"
#include "scenes.h"
#include "temporary_folder.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

const std::vector<PathPoint>& points_of(const Path& path) {
  return std::get<SampledPath>(path.nominal).points;
}

}  // namespace

// Protects the order of columns: TUM writes qx qy qz qw, ours are w first.
TEST_CASE("TUM files") {
  const TemporaryFolder folder;
  const auto path =
      load_path(path_from(folder.write("a.tum",
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
      path_from(folder.write(
          "a.csv", "ping,time_s,x,y,z,qw,qx,qy,qz\n0,10,1,2,3,1,0,0,0\n1,11,2,2,3,1,0,0,0\n")),
      0);
  REQUIRE(path.ok());
  CHECK(points_of(*path)[1].time_s == 11);
  CHECK(points_of(*path)[1].pose.position_m.x == 2);
  // As spreadsheets write UTF-8.
  const auto marked = load_path(
      path_from(folder.write("b.csv", "\xEF\xBB\xBFtime_s,x,y,z,qw,qx,qy,qz\n10,1,2,3,1,0,0,0\n")),
      0);
  CHECK(marked.ok());
}

// Protects names and cells as spreadsheets write them.
TEST_CASE("CSV files with quotes") {
  const TemporaryFolder folder;
  const auto path =
      load_path(path_from(folder.write("a.csv",
                                       "\"time_s\",\"x\",\"y\",\"z\",\"qw\",\"qx\",\"qy\",\"qz\"\n"
                                       "\"10\",1,\"2\",3,1,0,0,0\n")),
                0);
  REQUIRE(path.ok());
  CHECK(points_of(*path)[0].pose.position_m == Vec3{1, 2, 3});
}

// Protects EuRoC's ground truth: its header is a comment, and its times are nanoseconds.
TEST_CASE("CSV files of EuRoC") {
  const TemporaryFolder folder;
  const std::string header =
      "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], "
      "q_RS_z [], v_RS_R_x [m s^-1]\n";
  const std::string rows =
      "1403636580838555648,4,-1.5,0.5,0.7071,0,0,0.7071,9\n1403636581838555648,5,-1.5,0.5,1,0,0,0,"
      "9\n";
  for (const std::string& text : {"# of a laboratory\n" + header + rows, header.substr(1) + rows}) {
    INFO(text);
    const auto path = load_path(path_from(folder.write("a.csv", text)), 0);
    REQUIRE(path.ok());
    REQUIRE(points_of(*path).size() == 2);
    CHECK(points_of(*path)[0].time_s == Approx(1403636580.838555648).margin(1e-6));
    CHECK(points_of(*path)[1].time_s - points_of(*path)[0].time_s == Approx(1).margin(1e-6));
    CHECK(points_of(*path)[0].pose.position_m == Vec3{4, -1.5, 0.5});
    CHECK(length(rotate(points_of(*path)[0].pose.rotation, {1, 0, 0}) - Vec3{0, 1, 0}) < 1e-12);
  }
}

// Protects recordings in which a time stands twice: one pose, if the two may be one.
TEST_CASE("poses at the same time count once if they lie within a step") {
  const TemporaryFolder folder;
  const auto load = [&](const std::string& text) {
    return load_path(path_from(folder.write("a.tum", text)), 0);
  };
  const std::string turned = " 0 0 0.0436194 0.9990482\n";  // by 5 degrees
  const auto path = load(
      "1 0 0 0 0 0 0 1\n2 0.1 0 0 0 0 0 1\n2 0.15 0 0 0 0 0 1\n2 0.11 0 0 0 0 0 "
      "1\n3 0.2 0 0 0 0 0 1\n");
  REQUIRE(path.ok());
  REQUIRE(points_of(*path).size() == 3);
  CHECK(points_of(*path)[1].pose.position_m.x == 0.1);
  CHECK(
      path_warning(*path).ends_with("a.tum:3: time 2 is that of the pose before, too; used the "
                                    "first pose of each time (left out: 2 "
                                    "poses, up to 0.05 m away from it)"));
  // Neighbors on one side, or a millimeter at rest, are a step, too.
  CHECK(load("1 0 0 0 0 0 0 1\n1 0.1 0 0 0 0 0 1\n2 0.2 0 0 0 0 0 1\n").ok());
  CHECK(load("1 0 0 0 0 0 0 1\n1 0.0009 0 0 0 0 0 1\n").ok());
  CHECK(path_warning(*load("1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n")).empty());
  CHECK(is_refused(load("1 0 0 0 0 0 0 1\n2 0.1 0 0 0 0 0 1\n2 0.25 0 0 0 0 0 1\n"),
                   "a.tum:3: time 2 stands at the pose before, too, but the two are 0.15 m and 0 "
                   "degrees apart",
                   ErrorKind::usage));
  CHECK(is_refused(load("1 0 0 0 0 0 0 1\n2 1 0 0 0 0 0 1\n2 1 0 0" + turned), "5 degrees apart",
                   ErrorKind::usage));
}

TEST_CASE("broken path files are refused with the line") {
  const TemporaryFolder folder;
  const auto refuse = [&](const std::string& name, const std::string& text,
                          const std::string& where) {
    INFO(name);
    const auto path = load_path(path_from(folder.write(name, text)), 0);
    CHECK(is_refused(path, name + where, ErrorKind::usage));
  };
  refuse("back.tum", "2 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n", ":2: time 1 is not after 2");
  refuse("word.tum", "1 0 0 zero 0 0 0 1\n", ":1: 'zero'");
  refuse("nan.tum", "1 0 0 nan 0 0 0 1\n", ":1: 'nan'");
  refuse("far.tum", "1 0 0 -1.1e7 0 0 0 1\n", ":1: z is -11000000 m");
  refuse("short.tum", "1 0 0 0 0 0 1\n", ":1: found 7 numbers");
  refuse("norot.tum", "1 0 0 0 0 0 0 0\n", ":1: the quaternion has length 0");
  refuse("empty.tum", "# nothing\n", ": holds no poses");
  refuse("cell.csv", "time_s,x,y,z,qw,qx,qy,qz\n1,2,,3,1,0,0,0\n", ":2: '' is not");
  refuse("blank.csv", "time_s,x,y,z,qw,qx,qy,qz\n1,2 3,0,3,1,0,0,0\n", ":2: '2 3' is not");
  refuse("UPPER.CSV", "time_s,x,y,z,qw,qx,qy,qz\n1,a,0,3,1,0,0,0\n", ":2: 'a' is not");
  refuse("header.csv", "t,x,y,z,qw,qx,qy,qz\n",
         ":1: the header `t,x,y,z,qw,qx,qy,qz` has no column time_s");
}
