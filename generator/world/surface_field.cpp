#include "world/surface_field.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <boost/math/distributions/gamma.hpp>

#include "core/units.h"
#include "scenario/scenario.h"

namespace ensonify {
namespace {

constexpr int kLattice = 64;
constexpr double kFieldEnd = 5;  // a normal value passes it once in two million
constexpr int kTableSteps = 1000;
// After this number of cells along an axis, the mean correlation of a normalized linear
// interpolation is 1/e, averaged over the position in the cell.
constexpr double kCorrelationCells = 0.9;

double normal_share_below(double g) { return std::erfc(-g / std::sqrt(2.0)) / 2; }

std::shared_ptr<SurfaceField> gaussian_field(double correlation_m, std::uint64_t key) {
  auto field = std::make_shared<SurfaceField>();
  field->per_m = kCorrelationCells / correlation_m;
  field->lattice.resize(std::size_t{kLattice} * kLattice * kLattice);
  for (std::size_t i = 0; i < field->lattice.size(); i += 2) {
    const ComplexDraw draw = complex_normal(key, 0, i, 0);
    field->lattice[i] = static_cast<float>(std::sqrt(2.0) * draw.re);
    field->lattice[i + 1] = static_cast<float>(std::sqrt(2.0) * draw.im);
  }
  return field;
}

template <class Value>
void fill_table(SurfaceField& field, const Value& value) {
  field.values.reserve(kTableSteps + 1);
  for (int i = 0; i <= kTableSteps; ++i) {
    field.values.push_back(static_cast<float>(value(kFieldEnd * (2.0 * i / kTableSteps - 1))));
  }
}

}  // namespace

float SurfaceField::at(Vec3 local_m) const {
  // The lattice is rotated, so that faces of boxes are not parallel to it.
  static const Quat kTurn = normalized(Quat{0.8, 0.31, 0.42, 0.29});
  const Vec3 p = per_m * rotate(kTurn, local_m);
  const std::array<double, 3> at{p.x, p.y, p.z};
  std::array<std::array<std::size_t, 2>, 3> node;
  std::array<std::array<double, 2>, 3> weight;
  double squares = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = std::floor(at[axis]), part = at[axis] - low;
    const auto index = static_cast<std::int64_t>(low);
    for (int side = 0; side < 2; ++side) {
      node[axis][side] = static_cast<std::uint64_t>(index + side) % kLattice;
      weight[axis][side] = side == 0 ? 1 - part : part;
    }
    squares *= part * part + (1 - part) * (1 - part);
  }
  double sum = 0;
  for (int z = 0; z < 2; ++z) {
    for (int y = 0; y < 2; ++y) {
      const std::size_t row = (node[2][z] * kLattice + node[1][y]) * kLattice;
      sum += weight[2][z] * weight[1][y] *
             (weight[0][0] * lattice[row + node[0][0]] + weight[0][1] * lattice[row + node[0][1]]);
    }
  }
  const double g = std::clamp(sum / std::sqrt(squares), -kFieldEnd, kFieldEnd);
  const double step = (g / kFieldEnd + 1) / 2 * kTableSteps;
  const auto low = std::min(static_cast<std::size_t>(step), std::size_t{kTableSteps - 1});
  const double part = step - static_cast<double>(low);
  return static_cast<float>(values[low] + part * (values[low + 1] - values[low]));
}

std::shared_ptr<const SurfaceField> make_texture(const SurfaceTexture& texture, std::uint64_t key) {
  const auto field = gaussian_field(texture.correlation_m, key);
  if (texture.model == TextureModel::gamma) {
    const boost::math::gamma_distribution<double> gamma(texture.shape, 1 / texture.shape);
    fill_table(*field, [&](double g) {
      // Computed from the nearer end, where the share keeps its digits.
      return g < 0 ? quantile(gamma, normal_share_below(g))
                   : quantile(complement(gamma, normal_share_below(-g)));
    });
  } else {
    const double sigma = texture.spread_db * std::log(10.0) / 10;
    fill_table(*field, [&](double g) { return std::exp(sigma * g - sigma * sigma / 2); });
  }
  return field;
}

std::shared_ptr<const SurfaceField> make_growth(double cover, double correlation_m,
                                                std::uint64_t key) {
  const auto field = gaussian_field(correlation_m, key);
  fill_table(*field, [&](double g) { return normal_share_below(g) < cover ? 1.0 : 0.0; });
  return field;
}

ObjectFields make_fields(const Scenario& scenario, const ObjectSpec& object, SequenceDraw draw,
                         const std::map<std::string, Material>& materials, PartMaterials& parts,
                         Instance& instance) {
  const std::uint64_t stream =
      mix64(stream_key(scenario.seed, Stream::terrain, draw) ^ name_key(object.name));
  const auto key_of = [&](const std::string& material) {
    return mix64(stream ^ name_key(material));
  };
  const auto spec_of = [&](const std::string& material) -> const MaterialSpec& {
    return *std::ranges::find(scenario.materials, material, &MaterialSpec::name);
  };
  std::vector<std::string> of_part = {object.material};
  for (const InstancePart& part : instance.parts) {
    if (std::ranges::find(of_part, part.material) == of_part.end()) {
      of_part.push_back(part.material);
    }
  }
  ObjectFields all(of_part.size());
  bool any = false;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const MaterialSpec& material = spec_of(of_part[k]);
    MaterialFields& fields = all[k];
    if (material.texture) fields.texture = make_texture(*material.texture, key_of(material.name));
    any |= material.texture || material.growth;
    if (!material.growth) continue;
    const auto& [grown, cover, correlation_m] = *material.growth;
    fields.growth = make_growth(cover, correlation_m, mix64(key_of(material.name)));
    if (const auto& texture = spec_of(grown).texture) {
      fields.growth_texture = make_texture(*texture, key_of(grown));
    }
    parts.materials.push_back(materials.at(grown));
    fields.growth_part = static_cast<std::uint16_t>(parts.materials.size());
    instance.growth.push_back({material.name, grown, materials.at(grown), cover, correlation_m});
  }
  return any ? all : ObjectFields{};
}

}  // namespace ensonify
