#include "trace/volume.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <variant>

namespace ensonify {
namespace {

constexpr int kMostParts = 64;
constexpr double kPointsPerPatch = 8;  // in a correlation length
constexpr double kForever = std::numeric_limits<double>::infinity();

struct Span {
  double from = 0, to = 0;
};

std::array<double, 3> as_array(Vec3 v) { return {v.x, v.y, v.z}; }

// The part of a ray, up to `end`, that lies in the box from `low` to `high`; empty if from >= to.
Span span_within(Vec3 origin, Vec3 direction, Vec3 low, Vec3 high, double end) {
  const auto o = as_array(origin), d = as_array(direction), l = as_array(low), h = as_array(high);
  Span span{0, end};
  for (int i = 0; i < 3; ++i) {
    if (d[i] == 0) {
      if (!(o[i] >= l[i] && o[i] <= h[i])) return {0, 0};
      continue;
    }
    const double a = (l[i] - o[i]) / d[i], b = (h[i] - o[i]) / d[i];
    span = {std::max(span.from, std::min(a, b)), std::min(span.to, std::max(a, b))};
  }
  return span;
}

void add_uniform(Span span, double step_m, DensityColumn& column) {
  if (!(span.from < span.to)) return;
  const int last = static_cast<int>(span.to / step_m);
  for (int k = static_cast<int>(span.from / step_m); k <= last; ++k) {
    const double from = std::max(span.from, k * step_m), to = std::min(span.to, (k + 1) * step_m);
    if (from < to) column.add(k, to - from);
  }
}

// Patches along a ray, in the volume's frame: the factor at points an eighth of the correlation
// length apart, linear between them. Distances must not fall.
class PatchesAlong {
 public:
  PatchesAlong(const Volume& volume, const Ray& local)
      : patches_(*volume.patches), local_(local), apart_m_(volume.patch_m / kPointsPerPatch) {}

  double apart_m() const { return apart_m_; }

  double at(double t_m) {
    if (!(t_m < end_m_)) move_to(t_m);
    return high_ + (t_m - end_m_) * slope_;
  }

 private:
  void move_to(double t_m) {
    const double point = std::floor(t_m / apart_m_) + 1;
    const double low = point == point_ + 1 ? high_ : value_at(point - 1);
    point_ = point;
    end_m_ = point * apart_m_;
    high_ = value_at(point);
    slope_ = (high_ - low) / apart_m_;
  }
  double value_at(double point) const {
    return double{patches_.at(local_.origin_m + (point * apart_m_) * local_.direction)};
  }

  const SurfaceField& patches_;
  const Ray& local_;
  double apart_m_ = 0;
  double point_ = -1;                        // the next point; none yet
  double end_m_ = 0, high_ = 0, slope_ = 0;  // its distance and factor; the slope up to it
};

// The integral from `from` to `to`, with the factor in the middle of equal parts no longer than the
// distance of points.
double integral_of(PatchesAlong& patches, double from, double to) {
  const double length_m = to - from;
  if (length_m <= patches.apart_m()) return length_m * patches.at((from + to) / 2);
  const double parts = std::min(std::ceil(length_m / patches.apart_m()), double{kMostParts});
  double sum = 0;
  for (double p = 0.5; p < parts; ++p) sum += patches.at(from + p / parts * length_m);
  return sum * length_m / parts;
}

void add_patches(const Volume& volume, const Ray& local, Span span, double step_m,
                 DensityColumn& column) {
  if (!(span.from < span.to)) return;
  PatchesAlong patches(volume, local);
  const int last = static_cast<int>(span.to / step_m);
  for (int k = static_cast<int>(span.from / step_m); k <= last; ++k) {
    const double from = std::max(span.from, k * step_m), to = std::min(span.to, (k + 1) * step_m);
    if (from < to) column.add(k, integral_of(patches, from, to));
  }
}

// Walks along a ray from brick to brick of a grid. Positions are sample indices from the grid's
// origin.
class BrickWalk {
 public:
  BrickWalk(const DensityGrid& grid, Vec3 origin, Vec3 direction, double end)
      : grid_(grid), origin_(as_array(origin)), direction_(as_array(direction)) {
    constexpr double kCells = DensityGrid::kCells;
    const Vec3 high{kCells * grid.bricks[0], kCells * grid.bricks[1], kCells * grid.bricks[2]};
    const Span span = span_within(origin, direction, {0, 0, 0}, high, end);
    at_ = span.from;
    end_ = span.to;
    for (int i = 0; i < 3; ++i) {
      const double u = (origin_[i] + at_ * direction_[i]) / kCells;
      brick_[i] = static_cast<int>(std::clamp(std::floor(u), 0.0, grid.bricks[i] - 1.0));
    }
    find_exit();
  }

  bool done() const { return !(at_ < end_); }
  double enter() const { return at_; }
  double exit() const { return exit_; }

  void step() {
    at_ = exit_;
    if (done()) return;
    brick_[axis_] += direction_[axis_] > 0 ? 1 : -1;
    if (brick_[axis_] < 0 || brick_[axis_] >= grid_.bricks[axis_]) {
      at_ = end_;
    } else {
      find_exit();
    }
  }

  const float* samples() const {
    const std::size_t cell =
        (std::size_t(brick_[2]) * grid_.bricks[1] + brick_[1]) * grid_.bricks[0] + brick_[0];
    const std::int32_t number = grid_.top[cell];
    if (number < 0) return nullptr;
    return grid_.samples.data() + std::size_t(number) * DensityGrid::kBrickSamples;
  }
  Vec3 from_corner(double t) const {
    std::array<double, 3> p{};
    for (int i = 0; i < 3; ++i) {
      p[i] = origin_[i] + t * direction_[i] - brick_[i] * double{DensityGrid::kCells};
    }
    return {p[0], p[1], p[2]};
  }

 private:
  void find_exit() {
    double nearest = kForever;
    for (int i = 0; i < 3; ++i) {
      if (direction_[i] == 0) continue;
      const int edge = (brick_[i] + (direction_[i] > 0 ? 1 : 0)) * DensityGrid::kCells;
      const double t = (edge - origin_[i]) / direction_[i];
      if (t < nearest) {
        nearest = t;
        axis_ = i;
      }
    }
    exit_ = std::clamp(nearest, at_, std::max(at_, end_));
  }

  const DensityGrid& grid_;
  std::array<double, 3> origin_, direction_;
  std::array<int, 3> brick_{};
  double at_ = 0, exit_ = 0, end_ = 0;
  int axis_ = 0;
};

void add_grid(const DensityGrid& grid, const Ray& local, double step_m, double end_m,
              DensityColumn& column) {
  const Vec3 corner{double(grid.origin[0]), double(grid.origin[1]), double(grid.origin[2])};
  BrickWalk walk(grid, mapped(grid.index_from_local, local.origin_m) - corner,
                 turned(grid.index_from_local, local.direction), end_m);
  const int parts =
      static_cast<int>(std::clamp(std::ceil(step_m / grid.spacing_m), 1.0, double{kMostParts}));
  const double part_m = step_m / parts;
  const auto middle = [&](std::int64_t p) {
    return (double(p) * part_m + std::min(double(p + 1) * part_m, end_m)) / 2;
  };
  // Each part belongs to the brick that contains its middle.
  std::int64_t part = 0;
  for (; !walk.done(); walk.step()) {
    const float* brick = walk.samples();
    if (brick == nullptr) continue;
    part = std::max(part, static_cast<std::int64_t>(std::ceil(walk.enter() / part_m - 0.5)) - 1);
    while (middle(part) < walk.enter()) ++part;
    for (; double(part) * part_m < end_m && middle(part) < walk.exit(); ++part) {
      const float density = density_in_brick(brick, walk.from_corner(middle(part)));
      if (!(density > 0)) continue;
      const double length = std::min(part_m, end_m - double(part) * part_m);
      column.add(static_cast<int>(part / parts), density * length);
    }
  }
}

}  // namespace

void DensityColumn::clear() {
  std::fill(length_m.begin() + first, length_m.begin() + last, 0.0);
  first = last = 0;
}

void DensityColumn::add(int step, double more_m) {
  if (first == last) first = step;
  last = std::max(last, step + 1);
  if (length_m.size() < std::size_t(last)) length_m.resize(last, 0.0);
  length_m[step] += more_m;
}

void march(const Volume& volume, const Ray& ray, double step_m, double end_m,
           DensityColumn& column, bool has_patches) {
  column.clear();
  if (!(end_m > 0)) return;
  const Ray local{inverse_transform_point(volume.pose, ray.origin_m),
                  rotate(conjugate(volume.pose.rotation), ray.direction)};
  if (const auto* grid = std::get_if<std::shared_ptr<const DensityGrid>>(&volume.density)) {
    add_grid(**grid, local, step_m, end_m, column);
    return;
  }
  Span span{0, end_m};
  if (const auto* box = std::get_if<DensityBox>(&volume.density)) {
    const Vec3 half = box->half_extents_m;
    span = span_within(local.origin_m, local.direction, -half, half, end_m);
  }
  if (volume.patches && has_patches) {
    add_patches(volume, local, span, step_m, column);
  } else {
    add_uniform(span, step_m, column);
  }
}

double extinction_db(const std::vector<Volume>& volumes, const Ray& ray, double step_m,
                     double end_m, DensityColumn& column) {
  double sum_db = 0;
  for (const Volume& volume : volumes) {
    if (!(volume.extinction_db_m > 0)) continue;
    march(volume, ray, step_m, end_m, column, false);
    double length_m = 0;
    for (int k = column.first; k < column.last; ++k) length_m += column.length_m[k];
    sum_db += volume.extinction_db_m * length_m;
  }
  return sum_db;
}

}  // namespace ensonify
