// The keys of trajectories: poses, a file or a path by a formula, wave motion, and ping times.
#include <cmath>

#include <fmt/format.h>

#include "core/ping.h"
#include "scenario/sections.h"

namespace ensonify {
namespace {

// Time stamps of recordings may count from 1970.
constexpr NumberRange kPathTime = from_to(-1e12, 1e12);
constexpr NumberRange kSpeed = above_up_to(0, 1e4);
constexpr NumberRange kBearing = from_to(-36000, 36000);

Vec3 vector_of(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

// Between points closer than this there is no direction.
constexpr double kLeastStepM = 1e-6;
// The sum of two unit vectors is shorter than this where they are within 0.06 degrees of opposite.
constexpr double kLeastBisector = 1e-3;

void check_points(Faults& faults, const Value& list, const SplineSpec& spline) {
  for (std::size_t i = 1; i < spline.points_m.size(); ++i) {
    const Value point = item(list, i);
    const Vec3 step = vector_of(spline.points_m[i]) - vector_of(spline.points_m[i - 1]);
    if (length(step) < kLeastStepM) {
      add_fault(faults, point.place, point.path,
                "the point is at the place of the one before; expected neighboring points at least "
                "1e-6 m apart");
      return;
    }
    if (i + 1 == spline.points_m.size()) return;
    const Vec3 next = vector_of(spline.points_m[i + 1]) - vector_of(spline.points_m[i]);
    if (length(normalized(step) + normalized(next)) < kLeastBisector) {
      add_fault(faults, point.place, point.path,
                "the path doubles back here and has no direction; expected turns of less than 180 "
                "degrees, for example with one more point next to this one");
      return;
    }
  }
}

void points_fields(Fields& f, SplineSpec& spline) {
  const ReadWatch watch(f);
  const bool listed =
      f.list({"points_m", "Points",
              "Points [x, y, z], each apart from the one before; the path must not double back at "
              "any of them"},
             spline.points_m, {"", "a list of at least two points [x, y, z]", 2}, kRequired,
             [&](const std::string& at, std::array<double, 3>& point) {
               f.numbers(at, point, kPosition);
             });
  if (!listed || !watch.is_well()) return;
  check_points(f.reader()->faults(), *child(f.reader()->map(), "points_m"), spline);
}

void look_fields(Fields& f, SplineSpec& spline) {
  constexpr std::string_view kWords[] = {"along", "at_m"};
  constexpr KindText kTexts[] = {{"Along", "Along the path"},
                                 {"At a point", "At the point [x, y, z] in the world"}};
  std::size_t look = spline.look_at_m ? 1 : 0;
  if (!f.begin_kind({"look", "Look", "Where the x axis of the body points"}, kWords, kTexts,
                    look)) {
    return;
  }
  if (look == 1) {
    std::array<double, 3> at = spline.look_at_m.value_or(std::array<double, 3>{});
    f.numbers({"", "At a point", "[x, y, z] in the world", "m"}, at, kPosition);
    spline.look_at_m = at;
  }
  f.end();
}

// The time of a single pose does not matter; each of several poses needs one.
void poses_fields(Fields& f, std::vector<TimedPoseSpec>& poses) {
  std::optional<double> last_time;
  const ListWords words{"", "a list of at least one pose", 1};
  f.list({"poses", "Poses",
          "Poses at increasing times; positions and attitudes are interpolated between them"},
         poses, words, {.in_lines = true}, [&](const std::string& at, TimedPoseSpec& pose) {
           if (!f.begin(at)) return;
           const Need need = poses.size() > 1 ? Need::required : Need::optional;
           const bool timed = f.number(
               {"time_s", "Time", "Time of the pose; needed where there are several poses"},
               pose.time_s, kPathTime, {.need = need});
           if (timed && last_time && pose.time_s <= *last_time) {
             f.fault("time_s", fmt::format("{} s is not after the {} s of the pose before; "
                                           "expected times that increase from pose to pose",
                                           pose.time_s, *last_time));
           }
           if (timed) last_time = pose.time_s;
           fields(f, pose.pose);
           f.end();
         });
}

}  // namespace

static constexpr KeyText kSpeedText = {"speed_m_s", "Speed", "Speed along the path"};
static constexpr KeyText kStartTimeText = {
    "start_time_s", "Start time",
    "Time at the start of the path; it matters only where there is another trajectory, and without "
    "from_first_ping"};

static void fields(Fields& f, LawnmowerSpec& path) {
  f.numbers({"corner_m", "Corner", "[x, y, z] at which the first line starts"}, path.corner_m,
            kPosition, kRequired);
  f.number({"length_m", "Length", "Length of each line"}, path.length_m, kLength, kRequired);
  f.number({"width_m", "Width", "Width of the area to port of the first line, filled with lines"},
           path.width_m, from_to(0, kMaxLengthM), kRequired);
  f.number({"spacing_m", "Spacing", "Distance between neighboring lines"}, path.spacing_m, kLength,
           kRequired);
  f.number({"heading_deg", "Heading", "Heading of the first line, from x (east) toward y (north)"},
           path.heading_deg, kBearing);
  f.number(kSpeedText, path.speed_m_s, kSpeed, kRequired);
  f.number(kStartTimeText, path.start_time_s, kPathTime);
}

static void fields(Fields& f, OrbitSpec& path) {
  f.numbers({"center_m", "Center", "[x, y, z] of the center"}, path.center_m, kPosition, kRequired);
  f.number({"radius_m", "Radius", "Radius of the circle"}, path.radius_m, kLength, kRequired);
  f.number(kSpeedText, path.speed_m_s, kSpeed, kRequired);
  const bool has_turns = f.number(
      {"turns", "Turns", "Number of turns, not 0; below 0 the path is clockwise, seen from above"},
      path.turns, from_to(-1e6, 1e6));
  if (has_turns && std::abs(path.turns) < 1e-9) {
    f.fault("turns",
            "0 turns make no path; expected a number other than 0, negative for clockwise");
  }
  f.number({"start_deg", "Start bearing",
            "Bearing of the first position from the center, from x toward y"},
           path.start_deg, kBearing);
  f.choice<OrbitLook>({"look", "Look",
                       "Where the x axis of the body points: to the center (inward), away from it "
                       "(outward) or along the path (along)"},
                      path.look,
                      {{"inward", OrbitLook::inward},
                       {"outward", OrbitLook::outward},
                       {"along", OrbitLook::along}});
  f.number(kStartTimeText, path.start_time_s, kPathTime);
}

static void fields(Fields& f, SplineSpec& path) {
  points_fields(f, path);
  f.number(kSpeedText, path.speed_m_s, kSpeed, kRequired);
  look_fields(f, path);
  f.number(kStartTimeText, path.start_time_s, kPathTime);
}

static void fields(Fields& f, WaveMotionSpec& motion) {
  f.number({"roll_deg", "Roll", "Rms roll in the frame of the body"}, motion.roll_deg,
           from_to(0, 60));
  f.number({"pitch_deg", "Pitch", "Rms pitch in the frame of the body"}, motion.pitch_deg,
           from_to(0, 60));
  f.number({"yaw_deg", "Yaw", "Rms yaw in the frame of the body"}, motion.yaw_deg, from_to(0, 60));
  f.number({"heave_m", "Heave", "Rms displacement along the z axis of the world"}, motion.heave_m,
           from_to(0, 1000));
  f.number({"period_s", "Period", "Period at the peak of the spectrum"}, motion.period_s,
           above_up_to(0, 1e6), kRequired);
  f.number({"bandwidth", "Relative bandwidth",
            "Standard deviation of the spectrum divided by its peak frequency"},
           motion.bandwidth, from_to(0.01, 0.33));
}

namespace {

// Returns the path, which is new when reading and exists when writing.
template <class Path>
Path& path_as(const Fields& f, TrajectorySpec& trajectory) {
  if (!f.writing()) trajectory.path.emplace<Path>();
  return std::get<Path>(trajectory.path);
}

// The sonar may rest at the origin, but an object with a trajectory needs a path.
void path_fields(Fields& f, TrajectorySpec& trajectory, Need need) {
  constexpr std::string_view kPaths[] = {"poses", "file", "lawnmower", "orbit", "spline"};
  const auto which = f.only_key(kPaths, trajectory.path.index(),
                                "one of poses, file, lawnmower, orbit, spline", need);
  if (!f.writing()) trajectory.path = std::vector<TimedPoseSpec>(1);
  if (which == 0u) poses_fields(f, std::get<0>(trajectory.path));
  if (which == 1u) {
    f.file({"file", "Trajectory file", "TUM file (.tum, .txt) or CSV file (.csv)"},
           path_as<PathFileSpec>(f, trajectory).file, {".tum", ".txt", ".csv"}, kRequired);
  }
  if (which == 2u) {
    f.map({"lawnmower", "Lawnmower",
           "Parallel lines in alternating directions, joined by half circles"},
          path_as<LawnmowerSpec>(f, trajectory));
  }
  if (which == 3u) {
    f.map({"orbit", "Orbit", "A horizontal circle"}, path_as<OrbitSpec>(f, trajectory));
  }
  if (which == 4u) {
    f.map({"spline", "Spline", "A smooth curve through points, at constant speed"},
          path_as<SplineSpec>(f, trajectory));
  }
  f.renamed("jitter", "wave_motion");
  f.map({"wave_motion", "Wave motion",
         "Motion in waves that is added to the path: four independent sums of sinusoids; left out: "
         "none"},
        trajectory.wave_motion);
}

}  // namespace

void fields(Fields& f, TrajectorySpec& trajectory) {
  for (const std::string_view key : {"ping_rate_hz", "pings"}) {
    double unused = 0;
    if (f.peek(key) == nullptr) continue;
    f.number(key, unused, {}, {.useless = "on an object; expected in the trajectory of the sonar"});
  }
  path_fields(f, trajectory, Need::required);
  f.boolean({"from_first_ping", "From the first ping",
             "Whether the path starts with the first ping of the sonar, whatever its own times "
             "are; for relative times next to times of the epoch"},
            trajectory.from_first_ping, written_if(trajectory.from_first_ping));
}

void sonar_trajectory_fields(Fields& f, TrajectorySpec& trajectory) {
  if (FieldReader* reader = f.reader(); reader && reader->peek("from_first_ping") != nullptr) {
    bool unused = false;
    f.boolean("from_first_ping", unused,
              {.useless = "on the sonar, whose first ping is at the start of its path; expected in "
                          "the trajectory of an object"});
  }
  path_fields(f, trajectory, Need::optional);
  f.number({"ping_rate_hz", "Ping rate", "Pings per second"}, trajectory.ping_rate_hz,
           above_up_to(0, 1e6));
  if (!f.writing()) trajectory.pings.reset();
  const bool has_pings =
      f.integer({"pings", "Pings",
                 "Number of pings; left out: 1 with a single pose, else as many as fit the "
                 "duration of the path"},
                trajectory.pings, 1, kMaxPings);
  if (f.writing() || has_pings) return;
  const auto* poses = std::get_if<std::vector<TimedPoseSpec>>(&trajectory.path);
  if (poses != nullptr && poses->size() == 1) trajectory.pings = 1;
}

}  // namespace ensonify
