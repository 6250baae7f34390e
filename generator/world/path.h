// The path of a body through the world: a pose at each instant.
//
//   SampledPath  SplinePath  make_path                  nominal paths; others are their specs
//   load_path_file                                      a sampled path from a file
//   WaveMotion  make_wave_motion  moved_by_waves        motion that waves add to a nominal path
//   CarriedPath                                         path of something fixed to a moving body
//   Path    load_path                                   a nominal path with its wave motion
//   pose_at  span_of                                    of any of them
//   FrameDrops  PingClock  ping_times                   transmission times of a trajectory's pings
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/error.h"
#include "core/vec.h"
#include "scenario/path_spec.h"

namespace ensonify {

struct PathPoint {
  double time_s = 0;
  Pose pose;
};

// At least one point, in strictly increasing time. Positions are interpolated linearly, rotations
// spherically.
struct SampledPath {
  std::vector<PathPoint> points;
  std::string warning = {};  // about the file: repeated times; empty: none
};

// One cubic a + u (b + u (c + u d)), u from 0 to 1, with its arc length at kParts + 1 even steps.
struct SplineSegment {
  static constexpr int kParts = 32;
  Vec3 a, b, c, d;
  std::array<double, kParts + 1> arc_m{};  // from the start of the whole spline
};

// Centripetal Catmull-Rom spline through all points, continued straight beyond the first and the
// last.
struct SplinePath {
  std::vector<SplineSegment> segments;
  double speed_m_s = 0;
  std::optional<Vec3> look_at_m;
  double start_time_s = 0;
};

SampledPath make_path(const std::vector<TimedPoseSpec>& poses);
SplinePath make_path(const SplineSpec& spec);

// Reads a TUM file (time x y z qx qy qz qw, separated by blanks, # comments) or a CSV file. The
// header of a CSV file names time_s, x, y, z, qw, qx, qy, qz in any order, like poses.csv of a data
// set, or has the names of EuRoC's ground truth (#timestamp in ns, p_RS_R_x [m], q_RS_w [], ...);
// other columns are ignored, but must hold numbers. Poses at the same time that lie no farther
// apart than poses at neighboring times (or 1 mm and 0.1 degrees) count as one, the first of them,
// with a warning. Errors (usage) give file:line and the reason.
Result<SampledPath> load_path_file(const std::filesystem::path& file);

// Line k of a lawnmower's path starts at k spacings to port; half circles with a radius of half a
// spacing join the lines, so that heading and speed never jump.
double line_count(const LawnmowerSpec& path);

// Before the start and after the end, the body rests at the ends of the path.
Pose pose_at(const SampledPath& path, double time_s);
Pose pose_at(const LawnmowerSpec& path, double time_s);
Pose pose_at(const OrbitSpec& path, double time_s);
Pose pose_at(const SplinePath& path, double time_s);

struct TimeSpan {
  double start_s = 0, end_s = 0;  // equal for a path of a single pose
};
TimeSpan span_of(const SampledPath& path);
TimeSpan span_of(const LawnmowerSpec& path);
TimeSpan span_of(const OrbitSpec& path);
TimeSpan span_of(const SplinePath& path);

// Attitude and heave from waves: a sum of sinusoids with equal amplitudes sqrt(2 / kTerms) rms, so
// that the mean square over time tends to rms^2.
struct WaveMotion {
  static constexpr int kTerms = 32;
  struct Sinusoid {
    double rad_s = 0, phase_rad = 0;
  };
  struct Axis {
    double rms = 0;  // radians or meters
    std::array<Sinusoid, kTerms> terms;
  };
  double start_time_s = 0;  // the time of the initial phases
  Axis roll, pitch, yaw, heave;
};

// Frequencies are drawn from a normal density around 1 / period with the standard deviation
// bandwidth / period, cut at three standard deviations. Each of kTerms strata of equal probability
// gets one frequency, so that each key has the whole spectrum and no two terms coincide.
WaveMotion make_wave_motion(const WaveMotionSpec& spec, std::uint64_t key, double start_time_s);

// Roll, pitch and yaw as a further rotation in the body's frame, heave along the world's z.
Pose moved_by_waves(const WaveMotion& motion, double time_s, const Pose& pose);

struct Path;

// The path of something fixed to a moving body.
struct CarriedPath {
  std::shared_ptr<const Path> carrier;
  Pose pose;  // in the carrier's frame
};
Pose pose_at(const CarriedPath& path, double time_s);
TimeSpan span_of(const CarriedPath& path);

struct Path {
  std::variant<SampledPath, LawnmowerSpec, OrbitSpec, SplinePath, CarriedPath> nominal;
  std::optional<WaveMotion> wave_motion;
};

// With `start_s`, the path is moved in time to start there. Errors (usage): those of
// load_path_file.
Result<Path> load_path(const TrajectorySpec& spec, std::uint64_t wave_key,
                       std::optional<double> start_s = {});

// The warning about the file of a path; empty if there is none.
std::string path_warning(const Path& path);

// Beyond its ends the body rests, except for its wave motion.
Pose pose_at(const Path& path, double time_s);
TimeSpan span_of(const Path& path);

// Frames that a recorder drops: each but the first with this probability, by draws of this key.
struct FrameDrops {
  std::uint64_t key = 0;
  double share = 0;
};

// Start of the path + k / rate for the frames k that are not dropped: the requested number of
// pings, or all of the path (both ends included). Errors (usage): more pings than fit into a path
// of more than one pose.
Result<std::vector<double>> ping_times(const TrajectorySpec& spec, const Path& path,
                                       const FrameDrops& drops = {});

// The clock of an instrument of a rig, next to that of the trajectory.
struct PingClock {
  double rate_hz = 1;
  double offset_s = 0;  // of the first ping, from the start of the path
};

// Start of the path + offset + k / rate for the frames k that are not dropped, as long as the run
// lasts: for the requested number of pings at the trajectory's rate, or for all of the path.
// Empty if the offset is beyond the end of the run. Errors (usage): those of the function above.
Result<std::vector<double>> ping_times(const TrajectorySpec& spec, const Path& path,
                                       const PingClock& clock, const FrameDrops& drops = {});

}  // namespace ensonify
