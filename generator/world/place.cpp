#include "world/place.h"

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "core/random.h"
#include "world/place_attempt.h"

namespace ensonify {
namespace {

constexpr std::uint32_t kAttempts = 200;

ErrorKind kind_of(PlaceFailure failure) {
  if (failure == PlaceFailure::redraw) return ErrorKind::redraw;
  return failure == PlaceFailure::error ? ErrorKind::final_usage : ErrorKind::usage;
}

struct Tally {
  std::uint32_t without_ground = 0;
  std::map<std::string, std::uint32_t> in_the_way;
};

Error no_room(std::size_t index, const Body& body, const Tally& tally) {
  std::string most;
  std::uint32_t count = 0, all = 0;
  for (const auto& [name, times] : tally.in_the_way) {
    all += times;
    if (times > count) most = name, count = times;
  }
  std::string why =
      fmt::format("{} times not all of it above {}{}", tally.without_ground,
                  body.spec.place->on, body.spec.place->touching ? ", or nothing to touch" : "");
  if (all > 0) {
    why += fmt::format(", {} times too near to another object, most often {}", all, most);
  }
  const Vec3 size = box_of(body.shape)->size_m;
  return {kind_of(body.spec.place->on_failure),
          fmt::format("objects.{}.place: no free place for {} ({:.3g} x {:.3g} x {:.3g} m) in {} "
                      "draws: {}; accepted is an area_m with room for it on {}: make it larger, or "
                      "clearance_m or the number of objects smaller",
                      index, body.spec.name, size.x, size.y, size.z, kAttempts, why,
                      body.spec.place->on)};
}

Error no_ground(std::size_t index, const ObjectSpec& spec) {
  return {kind_of(spec.place->on_failure),
          fmt::format("objects.{}.place: {} was to stand on {}, for which there is no free place",
                      index, spec.name, spec.place->on)};
}

// Grounds and what is taken, while objects are being placed.
class Site {
 public:
  Site(const Scenario& scenario, World& world) : scenario_(scenario) {
    for (WorldObject& object : world.objects) {
      by_name_.emplace(world.instances[object.instance - 1].name, &object);
    }
    for (const ObjectSpec& spec : scenario.objects) {
      if (!spec.place) take(spec);
    }
  }

  Status place(std::size_t index, std::uint64_t key) {
    const ObjectSpec& spec = scenario_.objects[index];
    WorldObject& object = *by_name_.at(spec.name);
    if (left_out_.contains(spec.place->on)) return no_ground(index, spec);
    if (std::holds_alternative<PlaneShape>(object.shape)) {
      return Error{ErrorKind::final_usage,
                   fmt::format("objects.{}.place: {} is a plane without end and cannot be placed, "
                               "accepted is a pose",
                               index, spec.name)};
    }
    const std::optional<Taken> around = around_ground(spec.place->on);
    const Result<Body> body = body_of(spec, object.shape, ground(spec.place->on), around);
    if (!body) {
      return Error{ErrorKind::final_usage,
                   fmt::format("objects.{}.place.align: rest: {} has no face to lie on: {}; accepted "
                               "are up and surface",
                               index, spec.name, body.error().message)};
    }
    Tally tally;
    for (std::uint32_t i = 0; i < kAttempts; ++i) {
      const Attempt attempt =
          attempt_to_place(*body, taken_, random_words(key, 0, name_key(spec.name), i));
      if (attempt.pose) {
        object.pose = *attempt.pose;
        take(spec);
        return {};
      }
      if (attempt.in_the_way != nullptr) {
        ++tally.in_the_way[attempt.in_the_way->name];
      } else {
        ++tally.without_ground;
      }
    }
    return no_room(index, *body, tally);
  }

  void leave_out(const ObjectSpec& spec) { left_out_.insert(spec.name); }

 private:
  void take(const ObjectSpec& spec) {
    const WorldObject& object = *by_name_.at(spec.name);
    if (!takes_room(object.shape)) return;
    const Outline outline = outline_of(object.shape, object.pose.rotation);
    taken_.push_back(taken_by(spec, outline, object.pose.position_m));
  }

  const Ground& ground(const std::string& name) {
    auto& made = grounds_[name];
    const WorldObject& object = *by_name_.at(name);
    if (!made) made = std::make_unique<Ground>(object.shape, object.pose);
    return *made;
  }

  std::optional<Taken> around_ground(const std::string& name) const {
    const auto found = std::find_if(taken_.begin(), taken_.end(),
                                    [&](const Taken& taken) { return taken.name == name; });
    if (found == taken_.end()) return std::nullopt;
    return *found;
  }

  const Scenario& scenario_;
  std::map<std::string, WorldObject*> by_name_;
  std::map<std::string, std::unique_ptr<Ground>> grounds_;
  std::vector<Taken> taken_;
  std::set<std::string> left_out_;
};

// The ids of the others close up.
void remove_left_out(World& world) {
  const auto is_left_out = [&](const std::string& name) {
    return std::find(world.left_out.begin(), world.left_out.end(), name) != world.left_out.end();
  };
  std::erase_if(world.objects, [&](const WorldObject& object) {
    return is_left_out(world.instances[object.instance - 1].name);
  });
  std::vector<std::uint16_t> new_id(world.instances.size() + 1);
  std::uint16_t next = 0;
  for (Instance& instance : world.instances) {
    if (is_left_out(instance.name)) continue;
    new_id[instance.id] = ++next;
    instance.id = next;
  }
  std::erase_if(world.instances,
                [&](const Instance& instance) { return is_left_out(instance.name); });
  for (WorldObject& object : world.objects) object.instance = new_id[object.instance];
}

}  // namespace

Status place_objects(const Scenario& scenario, SequenceDraw draw, World& world) {
  const bool any = std::any_of(scenario.objects.begin(), scenario.objects.end(),
                               [](const ObjectSpec& spec) { return spec.place.has_value(); });
  if (!any) return {};
  const std::uint64_t key = stream_key(scenario.seed, Stream::place, draw);
  Site site(scenario, world);
  for (std::size_t i = 0; i < scenario.objects.size(); ++i) {
    const ObjectSpec& spec = scenario.objects[i];
    if (!spec.place) continue;
    Status placed = site.place(i, key);
    if (placed) continue;
    const bool may_go = placed.error().kind != ErrorKind::final_usage;
    if (!may_go || spec.place->on_failure != PlaceFailure::skip_object) return placed;
    site.leave_out(spec);
    world.left_out.push_back(spec.name);
  }
  if (!world.left_out.empty()) remove_left_out(world);
  return {};
}

}  // namespace ensonify
