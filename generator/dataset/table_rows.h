// Rows of the text tables, numbers in the shortest form that reads back to the same double.
// Private to dataset/.
//
//   poses.csv  poses.tum  objects.csv  boxes.csv  index.csv
//   table_rows    rows that a ping adds to the tables of its sequence
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/ping.h"
#include "core/vec.h"
#include "dataset/ping_record.h"

namespace ensonify {

inline constexpr char kPosesHeader[] = "ping,time_s,x,y,z,qw,qx,qy,qz\n";
inline constexpr char kObjectsHeader[] = "ping,instance,x,y,z,qw,qx,qy,qz\n";
inline constexpr char kBoxesHeader[] =
    "ping,instance,size_x,size_y,size_z,x,y,z,qw,qx,qy,qz,"
    "sonar_x,sonar_y,sonar_z,sonar_qw,sonar_qx,sonar_qy,sonar_qz\n";
inline constexpr char kIndexHeader[] = "sequence,ping,time_s,split,stem\n";

std::string poses_row(std::uint32_t ping, double time_s, const Pose& sonar_in_world);

// TUM's own order: time x y z qx qy qz qw, with blanks.
std::string tum_row(double time_s, const Pose& sonar_in_world);

// One row per instance, ids 1, 2, ...
std::string objects_rows(std::uint32_t ping, const std::vector<Pose>& object_in_world);

// One row for each instance that has a box: its size, and its center's pose in the world and in the
// sonar's frame.
std::string boxes_rows(std::uint32_t ping, const Pose& sonar_in_world,
                       const std::vector<Pose>& object_in_world,
                       const std::vector<Instance>& instances);

// Of poses.csv, poses.tum, objects.csv, boxes.csv, first_return_m.npy and annotations.jsonl.
std::array<std::string, 6> table_rows(const PingRecord& record,
                                      const std::vector<Instance>& instances);

std::string index_row(std::uint32_t sequence, std::uint32_t ping, double time_s,
                      const std::string& split);

}  // namespace ensonify
