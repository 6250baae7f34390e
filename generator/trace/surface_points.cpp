#include "trace/surface_points.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/random.h"
#include "trace/echo.h"
#include "trace/sector_lists.h"

namespace ensonify {
namespace {

// A hit within this part of the range, or this distance, is the leaf's own surface. Ranges are
// compared, not triangles: Embree computes in float and may return a neighbor of the intended
// triangle.
constexpr double kSameRange = 1e-6, kSameRange_m = 1e-5;
// If no more levels than this remain, a test of the enclosing ball costs more than it saves.
constexpr std::uint32_t kLeavesAtOnce = 3;
// Rays that are traced together, and tiles that one task handles.
constexpr std::size_t kBundle = 1024, kBlock = 32;
// Draw 0 of a scatterer is its amplitude.
constexpr std::uint32_t kPlaceDraw = 1, kPatternDraw = 2;

template <class P>
SurfaceLeaf leaf_of(const P& patch, const SurfaceTile& tile, std::uint64_t path, double area_m2,
                    std::uint64_t places_key) {
  SurfaceLeaf leaf;
  leaf.key = leaf_key(tile.root, path);
  leaf.area_m2 = area_m2;
  const Philox4 words = random_words(places_key, 0, leaf.key, kPlaceDraw);
  const PatchPoint point =
      point_of(patch, uniform_from_word(words.v[0]), uniform_from_word(words.v[1]));
  leaf.position_m = point.position_m;
  leaf.normal = point.normal;
  return leaf;
}

// Visits the leaves `levels` halvings below a patch, without parts of which part_in(ball) says that
// nothing is heard. Of a part that is heard as a whole, no smaller part is asked for.
template <class P, class PartIn, class Visit>
void descend(const P& patch, std::uint32_t levels, std::uint64_t path, FanPart part,
             const PartIn& part_in, const Visit& visit) {
  if (levels == 0) return visit(patch, path);
  if (part == FanPart::some && levels > kLeavesAtOnce) {
    part = part_in(ball_of(patch));
    if (part == FanPart::none) return;
  }
  const auto halves = halves_of(patch);
  descend(halves[0], levels - 1, 2 * path, part, part_in, visit);
  descend(halves[1], levels - 1, 2 * path + 1, part, part_in, visit);
}

template <class PartIn, class Visit>
void for_even_leaves(const SurfaceTile& tile, const EvenPlane& plane, std::uint64_t places_key,
                     FanPart part, const PartIn& part_in, const Visit& visit) {
  const Philox4 words = random_words(places_key, 0, 0, kPatternDraw);
  constexpr double kPeriod = EvenPattern::kSide;
  const EvenOrigin origin = {kPeriod * uniform_from_word(words.v[0]),
                             kPeriod * uniform_from_word(words.v[1])};
  const double spacing_m = even_spacing_of(tile.scale);
  SurfaceLeaf leaf;
  leaf.area_m2 = spacing_m * spacing_m * plane.stretch();
  leaf.normal = plane.normal;
  for_even_points(plane, tile.scale, origin, part, part_in,
                  [&](const Vec3& place_m, std::uint64_t path) {
                    leaf.key = leaf_key(tile.root, path);
                    leaf.position_m = place_m;
                    visit(leaf);
                  });
}

template <class PartIn, class Visit>
void for_leaves(const SurfaceTile& tile, std::uint64_t places_key, FanPart part,
                const PartIn& part_in, const Visit& visit) {
  if (tile.axis >= 0) {
    const auto* rectangle = std::get_if<RectanglePatch>(&tile.patch);
    return for_even_leaves(tile,
                           rectangle != nullptr
                               ? even_plane(*rectangle)
                               : even_plane(std::get<TrianglePatch>(tile.patch), tile.axis),
                           places_key, part, part_in, visit);
  }
  std::visit(
      [&](const auto& whole) {
        const double area = std::ldexp(area_m2(whole), -static_cast<int>(tile.levels));
        descend(whole, tile.levels, tile.path, part, part_in,
                [&](const auto& patch, std::uint64_t path) {
                  visit(leaf_of(patch, tile, path, area, places_key));
                });
      },
      tile.patch);
}

// An object as the ping sees it.
struct View {
  Pose sonar_in_object;
  Quat object_rotation;
  std::uint32_t instance = 0;
};

// A scatterer inside the fan that is not yet known to be visible.
struct Candidate {
  std::uint64_t key = 0;
  Vec3 position_m;  // in the sonar's frame
  double range_m = 0, azimuth_rad = 0, elevation_rad = 0;
  double shown_m2 = 0;  // the leaf's area as the sonar sees it
  std::uint32_t beam = 0, instance = 0;
};

// A visible scatterer, in half the bytes of a Scatterer, which is made where it stays.
struct Heard {
  Vec3 position_m;
  std::uint64_t key = 0;
  Direction direction;
  float gain = 0, mean = 0, standard_deviation = 0, cos_incidence = 0;
  std::uint32_t beam = 0, instance = 0;
};

// Buffers for a block of tiles.
struct Bundle {
  std::vector<Candidate> candidates;
  std::vector<Vec3> directions;  // in the world
  std::vector<Hit> hits;
  std::vector<Heard> heard;
};

struct Listener {
  const Tracer& tracer;
  const Pose& sonar_in_world;
  const SurfaceScattering& scattering;
  std::uint64_t places_key = 0;

  void look(const SurfaceTile& tile, const View& view, Bundle& bundle) const {
    const Pose& eye = view.sonar_in_object;
    const auto part_in = [&](const Ball& ball) {
      const Vec3 centre = inverse_transform_point(eye, ball.centre_m);
      return part_in_fan(scattering.sonar, {centre, ball.radius_m});
    };
    const FanPart part = part_in(tile.ball);
    if (part == FanPart::none) return;
    for_leaves(tile, places_key, part, part_in,
               [&](const SurfaceLeaf& leaf) { add(leaf, view, bundle); });
  }

  void add(const SurfaceLeaf& leaf, const View& view, Bundle& bundle) const {
    const Sonar& sonar = scattering.sonar;
    const Vec3 way = leaf.position_m - view.sonar_in_object.position_m;
    Candidate c;
    c.range_m = length(way);
    if (!in_range(c.range_m, sonar)) return;
    c.position_m = rotate(conjugate(view.sonar_in_object.rotation), way);
    const Vec3& p = c.position_m;
    c.elevation_rad = std::asin(std::clamp(p.z / c.range_m, -1.0, 1.0));
    if (std::abs(c.elevation_rad) > sonar.elevation_fan_rad / 2) return;
    c.azimuth_rad = std::atan2(p.y, p.x);
    const std::optional<int> beam = sector_of(sonar, c.azimuth_rad);
    if (!beam) return;
    const Vec3 direction = (1.0 / c.range_m) * way;
    c.key = leaf.key;
    c.shown_m2 = leaf.area_m2 * std::abs(dot(direction, leaf.normal));
    c.beam = static_cast<std::uint32_t>(*beam);
    c.instance = view.instance;
    bundle.candidates.push_back(c);
    bundle.directions.push_back(rotate(view.object_rotation, direction));
    if (bundle.candidates.size() == kBundle) trace(bundle);
  }

  // Turns the visible candidates into scatterers and empties the bundle.
  void trace(Bundle& bundle) const {
    bundle.hits.resize(bundle.candidates.size());
    tracer.first_hits(sonar_in_world.position_m, bundle.directions, scattering.sonar.range_max_m,
                      bundle.hits);
    for (std::size_t i = 0; i < bundle.hits.size(); ++i) {
      const Candidate& c = bundle.candidates[i];
      const Hit& hit = bundle.hits[i];
      const double apart = std::abs(hit.range_m - c.range_m);
      const bool is_seen =
          hit.instance == c.instance && apart <= std::max(kSameRange * c.range_m, kSameRange_m);
      if (!is_seen) continue;
      // Replaces r^2 dOmega by the leaf's area: range 1 m, solid angle shown_m2.
      const ScattererMoments moments = scatterer_moments(
          material_at(scattering, hit), hit.reflectivity, hit.cos_incidence, 1, c.shown_m2);
      if (!is_an_echo(moments)) continue;
      bundle.heard.push_back(
          {c.position_m,
           c.key,
           {static_cast<float>(c.azimuth_rad), static_cast<float>(c.elevation_rad)},
           gain_of(c),
           static_cast<float>(moments.mean_m),
           static_cast<float>(std::sqrt(moments.variance_m2)),
           hit.cos_incidence,
           c.beam,
           c.instance});
    }
    bundle.candidates.clear();
    bundle.directions.clear();
  }

  // Scatterer::gain, as set_echo computes it. The sine of the elevation is known here.
  float gain_of(const Candidate& c) const {
    const Sonar& sonar = scattering.sonar;
    const ShadedLine& line = sonar.elevation_line;
    const double vertical = line.shading.kind == Shading::uniform
                                ? elevation_pattern(sonar, c.elevation_rad)
                                : shaded_line(line, line.aperture * c.position_m.z / c.range_m);
    return static_cast<float>(two_way_loss(c.range_m, scattering.water.absorption_db_m) * vertical *
                              transmit_pattern(c.azimuth_rad, sonar.transmit_width_rad));
  }
};

ScattererList sorted_list(std::span<const std::vector<Heard>> heard,
                          const SurfaceScattering& scattering, const Workers& workers) {
  std::vector<std::uint32_t> count(static_cast<std::size_t>(scattering.sonar.beam_count));
  for (const auto& block : heard) {
    for (const Heard& h : block) ++count[h.beam];
  }
  std::vector<std::vector<const Heard*>> of_beam(count.size());
  for (std::size_t beam = 0; beam < count.size(); ++beam) of_beam[beam].reserve(count[beam]);
  for (const auto& block : heard) {
    for (const Heard& h : block) of_beam[h.beam].push_back(&h);
  }
  const auto fill = [&](std::size_t beam, SectorWork& work, std::vector<Scatterer>& scatterers) {
    work.order.clear();
    for (const Heard* h : of_beam[beam]) {
      const double delay_s =
          two_way_delay_s(length(h->position_m), scattering.water.sound_speed_m_s);
      work.order.push_back({delay_s, h->key, static_cast<std::uint32_t>(work.order.size())});
    }
    if (!work.order.empty()) sort_keys(work.order);
    for (const SortKey& next : work.order) {
      const Heard& h = *of_beam[beam][next.index];
      Scatterer& s = scatterers.emplace_back();
      s.delay_s = next.delay_s;
      s.position_m = h.position_m;
      s.departure = s.arrival = h.direction;
      s.gain = h.gain;
      s.mean = h.mean;
      s.standard_deviation = h.standard_deviation;
      s.cos_incidence = h.cos_incidence;
      s.key = h.key;
      s.beam = h.beam;
      s.instance = h.instance;
      s.received_path_m = static_cast<float>(length(h.position_m));
    }
  };
  return list_of_sectors<SectorWork>(count, workers, fill);
}

std::vector<View> views_of(const SurfaceTiles& tiles, const SurfaceScattering& scattering,
                           std::span<const Pose> object_in_world, const Pose& sonar_in_world) {
  std::vector<View> views;
  for (std::size_t i = 0; i < object_in_world.size(); ++i) {
    views.push_back({pose_in(object_in_world[i], sonar_in_world), object_in_world[i].rotation,
                     tiles.instance[i]});
    ENSONIFY_ASSERT(tiles.instance[i] < scattering.material.size());
  }
  return views;
}

}  // namespace

void leaves_of(const SurfaceTile& tile, std::uint64_t places_key,
               const std::function<void(const SurfaceLeaf&)>& visit) {
  for_leaves(
      tile, places_key, FanPart::all, [](const Ball&) { return FanPart::all; }, visit);
}

ScattererList surface_point_list(const SurfaceTiles& tiles, const Tracer& tracer,
                                 std::span<const Pose> object_in_world, const Pose& sonar_in_world,
                                 const SurfaceScattering& scattering, std::uint64_t places_key,
                                 const Workers& workers) {
  const std::vector<View> views = views_of(tiles, scattering, object_in_world, sonar_in_world);
  const Listener listener{tracer, sonar_in_world, scattering, places_key};
  const std::size_t blocks = (tiles.tiles.size() + kBlock - 1) / kBlock;
  std::vector<std::vector<Heard>> heard(blocks);
  workers.for_each(blocks, [&](std::size_t block) {
    Bundle bundle;
    const std::size_t end = std::min((block + 1) * kBlock, tiles.tiles.size());
    for (std::size_t i = block * kBlock; i < end; ++i) {
      listener.look(tiles.tiles[i], views[tiles.tiles[i].object], bundle);
    }
    if (!bundle.candidates.empty()) listener.trace(bundle);
    heard[block] = std::move(bundle.heard);
  });
  return sorted_list(heard, scattering, workers);
}

}  // namespace ensonify
