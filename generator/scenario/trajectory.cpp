// Trajectories: poses, a file, or a path by a formula; jitter; when the pings go out.
#include <cmath>

#include <fmt/format.h>

#include "core/ping.h"
#include "scenario/sections.h"

namespace ensonify {
namespace {

// Recorded stamps count from 1970.
constexpr NumberRange kPathTime = from_to(-1e12, 1e12);
constexpr NumberRange kSpeed = above_up_to(0, 1e4);
constexpr NumberRange kBearing = from_to(-36000, 36000);

Vec3 vector_of(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

// Nearer points have no direction between them.
constexpr double kLeastStepM = 1e-6;
// Of the sum of two unit vectors: directions closer to opposite than 0.06 degrees.
constexpr double kLeastBisector = 1e-3;

void check_points(Faults& faults, const Value& list, const SplineSpec& spline) {
  for (std::size_t i = 1; i < spline.points_m.size(); ++i) {
    const Value point = item(list, i);
    const Vec3 step = vector_of(spline.points_m[i]) - vector_of(spline.points_m[i - 1]);
    if (length(step) < kLeastStepM) {
      add_fault(faults, point.place, point.path,
                "stands where the point before it stands, accepted are points at least 1e-6 m "
                "apart from one to the next");
      return;
    }
    if (i + 1 == spline.points_m.size()) return;
    const Vec3 next = vector_of(spline.points_m[i + 1]) - vector_of(spline.points_m[i]);
    if (length(normalized(step) + normalized(next)) < kLeastBisector) {
      add_fault(faults, point.place, point.path,
                "the way doubles back here and has no direction, accepted are turns of less than "
                "180 degrees; set one more point beside this one");
      return;
    }
  }
}

void points_fields(Fields& f, SplineSpec& spline) {
  const ReadWatch watch(f);
  const bool listed =
      f.list("points_m", spline.points_m, {"", "is a list of at least two points [x, y, z]", 2},
             kRequired, [&](const std::string& at, std::array<double, 3>& point) {
               f.numbers(at, point, kPosition);
             });
  if (!listed || !watch.is_well()) return;
  check_points(f.reader()->faults(), *child(f.reader()->map(), "points_m"), spline);
}

void look_fields(Fields& f, SplineSpec& spline) {
  constexpr std::string_view kWords[] = {"along", "at_m"};
  std::size_t look = spline.look_at_m ? 1 : 0;
  if (!f.begin_kind("look", kWords, look)) return;
  if (look == 1) {
    std::array<double, 3> at = spline.look_at_m.value_or(std::array<double, 3>{});
    f.numbers("", at, kPosition);
    spline.look_at_m = at;
  }
  f.end();
}

// The first pose's time does not matter, but with several each needs its own.
void poses_fields(Fields& f, std::vector<TimedPoseSpec>& poses) {
  std::optional<double> last_time;
  const ListWords words{"", "is a list of at least one pose", 1};
  f.list("poses", poses, words, {.in_lines = true},
         [&](const std::string& at, TimedPoseSpec& pose) {
           if (!f.begin(at)) return;
           const Need need = poses.size() > 1 ? Need::required : Need::optional;
           const bool timed = f.number("time_s", pose.time_s, kPathTime, {.need = need});
           if (timed && last_time && pose.time_s <= *last_time) {
             f.fault("time_s", fmt::format("{} s does not come after the {} s before it, accepted "
                                           "are times that increase from pose to pose",
                                           pose.time_s, *last_time));
           }
           if (timed) last_time = pose.time_s;
           fields(f, pose.pose);
           f.end();
         });
}

}  // namespace

static void fields(Fields& f, LawnmowerSpec& path) {
  f.numbers("corner_m", path.corner_m, kPosition, kRequired);
  f.number("length_m", path.length_m, kLength, kRequired);
  f.number("width_m", path.width_m, from_to(0, kMaxLengthM), kRequired);
  f.number("spacing_m", path.spacing_m, kLength, kRequired);
  f.number("heading_deg", path.heading_deg, kBearing);
  f.number("speed_m_s", path.speed_m_s, kSpeed, kRequired);
  f.number("start_time_s", path.start_time_s, kPathTime);
}

static void fields(Fields& f, OrbitSpec& path) {
  f.numbers("center_m", path.center_m, kPosition, kRequired);
  f.number("radius_m", path.radius_m, kLength, kRequired);
  f.number("speed_m_s", path.speed_m_s, kSpeed, kRequired);
  if (f.number("turns", path.turns, from_to(-1e6, 1e6)) && std::abs(path.turns) < 1e-9) {
    f.fault("turns", "no way to go, accepted is a number other than 0, below 0 for clockwise");
  }
  f.number("start_deg", path.start_deg, kBearing);
  f.choice<OrbitLook>("look", path.look,
                      {{"inward", OrbitLook::inward},
                       {"outward", OrbitLook::outward},
                       {"along", OrbitLook::along}});
  f.number("start_time_s", path.start_time_s, kPathTime);
}

static void fields(Fields& f, SplineSpec& path) {
  points_fields(f, path);
  f.number("speed_m_s", path.speed_m_s, kSpeed, kRequired);
  look_fields(f, path);
  f.number("start_time_s", path.start_time_s, kPathTime);
}

static void fields(Fields& f, JitterSpec& jitter) {
  f.number("roll_deg", jitter.roll_deg, from_to(0, 60));
  f.number("pitch_deg", jitter.pitch_deg, from_to(0, 60));
  f.number("yaw_deg", jitter.yaw_deg, from_to(0, 60));
  f.number("heave_m", jitter.heave_m, from_to(0, 1000));
  f.number("period_s", jitter.period_s, above_up_to(0, 1e6), kRequired);
  f.number("bandwidth", jitter.bandwidth, from_to(0.01, 0.33));
}

namespace {

// A path that is entered anew while reading, and is there while writing.
template <class Path>
Path& path_as(const Fields& f, TrajectorySpec& trajectory) {
  if (!f.writing()) trajectory.path.emplace<Path>();
  return std::get<Path>(trajectory.path);
}

// The sonar may rest at the origin; an object with a trajectory has a path.
void path_fields(Fields& f, TrajectorySpec& trajectory, Need need) {
  constexpr std::string_view kPaths[] = {"poses", "file", "lawnmower", "orbit", "spline"};
  const auto which = f.only_key(kPaths, trajectory.path.index(),
                                "one of poses, file, lawnmower, orbit, spline", need);
  if (!f.writing()) trajectory.path = std::vector<TimedPoseSpec>(1);
  if (which == 0u) poses_fields(f, std::get<0>(trajectory.path));
  if (which == 1u) {
    f.file("file", path_as<PathFileSpec>(f, trajectory).file, {".tum", ".txt", ".csv"}, kRequired);
  }
  if (which == 2u) f.map("lawnmower", path_as<LawnmowerSpec>(f, trajectory));
  if (which == 3u) f.map("orbit", path_as<OrbitSpec>(f, trajectory));
  if (which == 4u) f.map("spline", path_as<SplineSpec>(f, trajectory));
  f.map("jitter", trajectory.jitter);
}

}  // namespace

void fields(Fields& f, TrajectorySpec& trajectory) {
  for (const std::string_view key : {"ping_rate_hz", "pings"}) {
    double unused = 0;
    if (f.peek(key) == nullptr) continue;
    f.number(key, unused, {}, {.useless = "on an object, accepted in the sonar's own trajectory"});
  }
  path_fields(f, trajectory, Need::required);
}

void sonar_trajectory_fields(Fields& f, TrajectorySpec& trajectory) {
  path_fields(f, trajectory, Need::optional);
  f.number("ping_rate_hz", trajectory.ping_rate_hz, above_up_to(0, 1e6));
  if (!f.writing()) {
    trajectory.pings.reset();
    const auto* poses = std::get_if<std::vector<TimedPoseSpec>>(&trajectory.path);
    if (poses != nullptr && poses->size() == 1) trajectory.pings = 1;
  }
  f.integer("pings", trajectory.pings, 1, kMaxPings);
}

}  // namespace ensonify
