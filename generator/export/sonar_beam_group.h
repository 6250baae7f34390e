// The part of a SONAR-netCDF4 file that grows by pings: Sonar/Beam_group1, and the poses of the
// platform. Private to export/.
//
//   kPositionGroup  kAttitudeGroup  kGyroGroup   groups of the platform's only instrument, its pose
//   make_time_axis
//   SonarBeamGroup   make  write
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "export/job.h"
#include "export/netcdf_file.h"

namespace ensonify {

inline constexpr char kPositionGroup[] = "/Platform/Position/pose";
inline constexpr char kAttitudeGroup[] = "/Platform/Attitude/pose";
inline constexpr char kGyroGroup[] = "/Platform/Gyro/pose";

// A coordinate variable in nanoseconds, uint64.
void make_time_axis(NetcdfFile& file, const std::string& path, const char* long_name,
                    std::uint64_t pings);

class SonarBeamGroup {
 public:
  // Both must outlive it. The sequence has time series.
  SonarBeamGroup(NetcdfFile& file, const StoredSequence& sequence);

  // Makes /Sonar and all that lies in it, and the variables in the groups of the pose, which exist
  // and have their time axes.
  void make(const std::string& program_version);
  // Writes ping number `at` of the sequence, from 0. Error (io): its file is missing or damaged.
  Status write(const ExportJob& job, const StoredPing& ping, std::uint64_t at,
               std::uint64_t time_ns);

 private:
  // A variable that has the same values in every ping.
  struct Constant {
    std::string path;
    std::vector<float> values;
  };

  void make_types(const std::string& program_version);
  void make_dimensions();
  void make_ping_values();
  void make_series();
  void make_flags();
  void make_directions();
  void make_widths();
  void make_transmission();
  void make_equation();
  void add(const char* name, NetcdfType type, std::vector<std::string> dimensions,
           const NetcdfAttributes& attributes, const std::string& named = "");
  // A variable over (ping_time, `dimension`), with a value for each index, or one for all.
  void add_constant(const char* name, const char* dimension, const NetcdfAttributes& attributes,
                    std::vector<float> values);
  void add_constant(const char* name, const char* dimension, const NetcdfAttributes& attributes,
                    double value);
  void write_flags(std::uint64_t at);
  void write_pose(const Pose& pose, std::uint64_t at);
  double depth_of(const Vec3& place) const;

  NetcdfFile& file_;
  const StoredSequence& sequence_;
  const SequenceInfo& info_;
  const Sonar& sonar_;
  std::vector<Constant> constants_;
};

}  // namespace ensonify
