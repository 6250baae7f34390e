#include "world/place.h"

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include <fmt/format.h>

#include "core/random.h"
#include "scenario/scenario.h"
#include "world/place_attempt.h"

namespace ensonify {
ParentTree parent_tree(const Scenario& scenario) {
  ParentTree tree;
  tree.parent.resize(scenario.objects.size());
  tree.children.resize(scenario.objects.size());
  std::map<std::string, std::size_t> index;
  for (std::size_t i = 0; i < scenario.objects.size(); ++i) {
    index.emplace(scenario.objects[i].name, i);
  }
  for (std::size_t i = 0; i < scenario.objects.size(); ++i) {
    if (scenario.objects[i].parent.empty()) continue;
    const std::size_t parent = index.at(scenario.objects[i].parent);
    tree.parent[i] = parent;
    tree.children[parent].push_back(i);
  }
  return tree;
}

std::vector<std::size_t> descendants(const ParentTree& tree, std::size_t object) {
  std::vector<std::size_t> found = tree.children[object];
  for (std::size_t i = 0; i < found.size(); ++i) {
    const std::vector<std::size_t>& next = tree.children[found[i]];
    found.insert(found.end(), next.begin(), next.end());
  }
  return found;
}

std::size_t root_of(const ParentTree& tree, std::size_t object) {
  while (tree.parent[object]) object = *tree.parent[object];
  return object;
}

void carry_children(const Scenario& scenario, const ParentTree& tree, std::size_t object,
                    World& world) {
  for (const std::size_t child : descendants(tree, object)) {
    const WorldObject& carrier = world.objects[*tree.parent[child]];
    const Pose pose = pose_of(scenario.objects[child].pose);
    WorldObject& carried = world.objects[child];
    carried.pose = compose(carrier.pose, pose);
    if (carrier.path == nullptr) continue;
    carried.path = std::make_shared<const Path>(Path{CarriedPath{carrier.path, pose}, {}});
  }
}

namespace {

constexpr std::uint32_t kAttempts = 200;

ErrorKind kind_of(PlaceFailure failure) {
  if (failure == PlaceFailure::redraw) return ErrorKind::redraw;
  return failure == PlaceFailure::error ? ErrorKind::final_usage : ErrorKind::incomplete;
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
  const PlaceSpec& place = *body.spec.place;
  std::string why;
  if (!place.volume_m) {
    why = fmt::format("{} times not entirely above {}{}", tally.without_ground, place.on,
                      place.touching ? " or without contact" : "");
  }
  if (all > 0) {
    why += fmt::format("{}{} times too close to another object, most often {}",
                       why.empty() ? "" : ", ", all, most);
  }
  const std::string room =
      place.volume_m ? "make volume_m" : fmt::format("make area_m on {}", place.on);
  const Vec3 size = box_of(body.shape)->size_m;
  return {
      kind_of(body.spec.place->on_failure),
      fmt::format("objects.{}.place: found no free place for {} ({:.3g} x {:.3g} x {:.3g} m) in {} "
                  "attempts: {}; {} larger, or reduce clearance_m or the number of objects",
                  index, body.spec.name, size.x, size.y, size.z, kAttempts, why, room)};
}

Error no_ground(std::size_t index, const ObjectSpec& spec) {
  return {kind_of(spec.place->on_failure),
          fmt::format("objects.{}.place: {} stands on {}, for which there is no free place", index,
                      spec.name, spec.place->on)};
}

// Grounds and occupied space while objects are placed.
class Site {
 public:
  Site(const Scenario& scenario, const ParentTree& tree, World& world)
      : scenario_(scenario), tree_(tree), world_(world) {
    for (std::size_t i = 0; i < scenario.objects.size(); ++i) {
      index_.emplace(scenario.objects[i].name, i);
      if (!scenario.objects[root_of(tree, i)].place) take(i);
    }
  }

  Status place(std::size_t index, std::uint64_t key) {
    const ObjectSpec& spec = scenario_.objects[index];
    WorldObject& object = world_.objects[index];
    if (left_out_.contains(spec.place->on)) return no_ground(index, spec);
    if (std::holds_alternative<PlaneShape>(object.shape)) {
      return Error{ErrorKind::usage,
                   fmt::format("objects.{}.place: {} is an infinite plane and cannot be placed; "
                               "expected `pose` instead",
                               index, spec.name)};
    }
    const Result<Body> body = body_of(spec, object.shape, surroundings(*spec.place));
    if (!body) {
      return Error{
          ErrorKind::usage,
          fmt::format("objects.{}.place.align: rest: {} has no face to lie on: {}; expected "
                      "up or surface",
                      index, spec.name, body.error().message)};
    }
    Tally tally;
    for (std::uint32_t i = 0; i < kAttempts; ++i) {
      Attempt attempt =
          attempt_to_place(*body, taken_, random_words(key, 0, name_key(spec.name), i));
      if (attempt.pose) {
        object.pose = *attempt.pose;
        carry_children(scenario_, tree_, index, world_);
        attempt.in_the_way = in_the_way_of_children(index, *body);
      }
      if (!attempt.in_the_way.empty()) {
        ++tally.in_the_way[attempt.in_the_way];
      } else if (attempt.pose) {
        take(index);
        for (const std::size_t child : descendants(tree_, index)) take(child);
        return {};
      } else {
        ++tally.without_ground;
      }
    }
    return no_room(index, *body, tally);
  }

  void leave_out(std::size_t index) {
    left_out_.insert(scenario_.objects[index].name);
    world_.left_out.push_back(scenario_.objects[index].name);
    for (const std::size_t child : descendants(tree_, index)) {
      left_out_.insert(scenario_.objects[child].name);
      world_.left_out.push_back(scenario_.objects[child].name);
    }
  }

 private:
  // Children use the clearance of the placed object that they belong to.
  Taken taken(std::size_t index) const {
    const WorldObject& object = world_.objects[index];
    Taken room = taken_by(scenario_.objects[index], outline_of(object.shape, object.pose.rotation),
                          object.pose.position_m);
    const auto& place = scenario_.objects[root_of(tree_, index)].place;
    if (place) room.clearance_m = place->clearance_m;
    return room;
  }

  void take(std::size_t index) {
    if (takes_room(world_.objects[index].shape)) taken_.push_back(taken(index));
  }

  std::string in_the_way_of_children(std::size_t index, const Body& body) const {
    for (const std::size_t child : descendants(tree_, index)) {
      if (!takes_room(world_.objects[child].shape)) continue;
      const Taken own = taken(child);
      if (const Taken* other = in_the_way(body, own, taken_, nullptr)) return other->name;
    }
    return "";
  }

  const Ground& ground(std::size_t index) {
    auto& made = grounds_[index];
    const WorldObject& object = world_.objects[index];
    if (!made) made = std::make_unique<Ground>(object.shape, object.pose);
    return *made;
  }

  PlaceGround surroundings(const PlaceSpec& place) {
    PlaceGround around;
    if (place.volume_m) {
      for (std::size_t i = 0; i < world_.objects.size(); ++i) {
        const Shape& shape = world_.objects[i].shape;
        const auto* mesh = std::get_if<MeshShape>(&shape);
        const bool is_plane = std::holds_alternative<PlaneShape>(shape);
        if (is_plane) around.planes.emplace_back(scenario_.objects[i].name, world_.objects[i].pose);
        if (mesh != nullptr && mesh->ground) add_ground(i, around);
      }
      return around;
    }
    add_ground(index_.at(place.on), around);
    for (const Taken& taken : taken_) {
      if (taken.name == place.on) around.ground_taken = taken;
      if (place.heap && taken.on == place.on) add_ground(index_.at(taken.name), around);
    }
    return around;
  }

  void add_ground(std::size_t index, PlaceGround& around) {
    around.grounds.push_back({scenario_.objects[index].name, &ground(index),
                              &world_.objects[index].shape, world_.objects[index].pose});
  }

  const Scenario& scenario_;
  const ParentTree& tree_;
  World& world_;
  std::map<std::string, std::size_t> index_;
  std::map<std::size_t, std::unique_ptr<Ground>> grounds_;
  std::vector<Taken> taken_;
  std::set<std::string> left_out_;
};

// Renumbers the other ids without gaps.
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

Status place_objects(const Scenario& scenario, SequenceDraw draw, const ParentTree& tree,
                     World& world) {
  const bool any = std::any_of(scenario.objects.begin(), scenario.objects.end(),
                               [](const ObjectSpec& spec) { return spec.place.has_value(); });
  if (!any) return {};
  const std::uint64_t key = stream_key(scenario.seed, Stream::place, draw);
  Site site(scenario, tree, world);
  for (std::size_t i = 0; i < scenario.objects.size(); ++i) {
    const ObjectSpec& spec = scenario.objects[i];
    if (!spec.place) continue;
    Status placed = site.place(i, key);
    if (placed) continue;
    const bool has_no_room = placed.error().kind != ErrorKind::usage;
    if (!has_no_room || spec.place->on_failure != PlaceFailure::skip_object) return placed;
    site.leave_out(i);
  }
  if (!world.left_out.empty()) remove_left_out(world);
  return {};
}

}  // namespace ensonify
