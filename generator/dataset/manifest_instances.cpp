#include <cmath>

#include "core/units.h"
#include "dataset/manifest_members.h"

namespace ensonify {

static const char* name_of(InstanceKind value) {
  constexpr const char* kNames[] = {"surface", "point_target", "volume"};
  return kNames[static_cast<int>(value)];
}

namespace {

template <class Io, class Value>
void table_rows(Io& io, Value& table) {
  std::vector<std::array<double, 2>> rows;
  for (std::size_t i = 0; i < table.grazing_rad.size(); ++i) {
    rows.push_back({degrees(table.grazing_rad[i]), table.strength_db[i]});
  }
  io("rows", rows);
  if constexpr (!Io::kWrites) {
    for (const auto& [grazing_deg, strength_db] : rows) {
      table.grazing_rad.push_back(radians(grazing_deg));
      table.strength_db.push_back(strength_db);
    }
  }
}

template <class Io, class Value>
void law_members(Io& io, Value& material) {
  std::string model(name_of(material.law));
  io("model", model);
  if constexpr (!Io::kWrites) material.law = law_named(model).value_or(material.law);
  if (!states_strength(material.law)) io("reflectivity", material.reflectivity);
  std::visit(
      [&](auto& law) {
        for (const auto& p : law.parameters()) io(p.key, law.*p.value);
        if constexpr (requires { law.table; }) table_rows(io, law.table);
      },
      material.law);
}

// The material of a surface or of a part of it.
template <class Io, class Value>
void coherent_members(Io& io, Value& material) {
  io.group_if("coherent", material.coherent != CoherentModel::none, [&](Io& coherent) {
    coherent.word("model", material.coherent, CoherentModel::kirchhoff);
    if (material.coherent == CoherentModel::rician) return coherent("k", material.rician_k);
    coherent("reflection", material.reflection);
    coherent("roughness_rms_m", material.roughness_rms_m);
    if (!Io::kWrites || material.roughness_correlation_m > 0) {
      coherent("roughness_correlation_m", material.roughness_correlation_m);
    }
    if (!Io::kWrites || material.edges) coherent("edges", material.edges);
  });
}

template <class Io, class Value>
void wall_members(Io& io, Value& material) {
  if (Io::kWrites && !material.wall) return;
  io.group_if("wall", material.wall.has_value(), [&](Io& wall) {
    if constexpr (!Io::kWrites) material.wall.emplace();
    auto& values = *material.wall;
    wall("thickness_m", values.thickness_m);
    wall("density_kg_m3", values.density_kg_m3);
    wall("speed_m_s", values.speed_m_s);
    wall("shear_speed_m_s", values.shear_speed_m_s);
    wall("loss", values.loss);
    wall("water_inside", values.water_inside);
  });
}

// These members are left out if the surface or the volume is even.
template <class Io, class Value>
void factor_members(Io& io, const char* name, Value& factor) {
  if (Io::kWrites && factor.model == TextureModel::none) return;
  io.group_if(name, factor.model != TextureModel::none, [&](Io& members) {
    members.word("model", factor.model, TextureModel::lognormal);
    if (factor.model == TextureModel::gamma) members("shape", factor.shape);
    if (factor.model == TextureModel::lognormal) members("spread_db", factor.spread_db);
    members("correlation_m", factor.correlation_m);
  });
}

template <class Io, class Value>
void texture_members(Io& io, Value& material) {
  factor_members(io, "texture", material.texture);
}

template <class Io, class Value>
void growth_members(Io& io, Value& instance) {
  if (Io::kWrites && instance.growth.empty()) return;
  io.list("growth", instance.growth, [](Io& item, auto& growth) {
    item("on", growth.on);
    item("material", growth.material);
    item("cover", growth.cover);
    item("correlation_m", growth.correlation_m);
    item.group("law", [&](Io& law) { law_members(law, growth.scattering); });
    coherent_members(item, growth.scattering);
    wall_members(item, growth.scattering);
    texture_members(item, growth.scattering);
  });
}

// Left out of meshes without an image.
template <class Io, class Value>
void image_member(Io& io, Value& instance) {
  if (Io::kWrites && !instance.image_reflectivity) return;
  io("image_reflectivity", instance.image_reflectivity);
}

template <class Io, class Value>
void surface_members(Io& io, Value& instance) {
  io("material", instance.material);
  io.group("law", [&](Io& law) { law_members(law, instance.scattering); });
  io("vertex_reflectivity", instance.vertex_reflectivity);
  image_member(io, instance);
  coherent_members(io, instance.scattering);
  wall_members(io, instance.scattering);
  texture_members(io, instance.scattering);
  growth_members(io, instance);
  if (Io::kWrites && instance.parts.empty()) return;
  io.list("parts", instance.parts, [](Io& item, auto& part) {
    item("name", part.name);
    item("material", part.material);
    item.group("law", [&](Io& law) { law_members(law, part.scattering); });
    coherent_members(item, part.scattering);
    wall_members(item, part.scattering);
    texture_members(item, part.scattering);
  });
}

// Left out of instances without resonances.
template <class Io, class Value>
void elastic_members(Io& io, const char* key, Value& instance) {
  if (Io::kWrites && !instance.elastic) return;
  io.maybe(key, instance.elastic, [](Io& item, auto& body) {
    item("radius_m", body.radius_m);
    item("density_kg_m3", body.material.density_kg_m3);
    item("speed_m_s", body.material.speed_m_s);
    item("shear_speed_m_s", body.material.shear_speed_m_s);
    item("wall_m", body.wall_m);
    item("filling_density_kg_m3", body.filling.density_kg_m3);
    item("filling_speed_m_s", body.filling.speed_m_s);
  });
}

template <class Io, class Value>
void one_instance(Io& io, Value& instance) {
  io("id", instance.id);
  io("name", instance.name);
  io("class_id", instance.class_id);
  io("class", instance.class_name);
  io.optional("box", instance.box, [](Io& corners, auto& box) {
    corners("size_m", box.size_m);
    corners("centre_m", box.pose.position_m);
    corners("quaternion_wxyz", box.pose.rotation);
  });
  io.word("kind", instance.kind, InstanceKind::volume);
  switch (instance.kind) {
    case InstanceKind::surface:
      surface_members(io, instance);
      elastic_members(io, "elastic", instance);
      break;
    case InstanceKind::point_target:
      if (Io::kWrites && !std::isfinite(instance.target_strength_db)) {
        io.said("target_strength_db", nullptr);
      } else {
        io("target_strength_db", instance.target_strength_db);
      }
      elastic_members(io, "sphere", instance);
      break;
    case InstanceKind::volume:
      io("strength_db", instance.volume_strength_db);
      factor_members(io, "patches", instance.volume_patches);
      break;
  }
}

template <class Io, class Info>
void instance_list(Io& io, Info& info) {
  io("classes", info.classes);
  io.list("instances", info.instances,
          [](Io& item, auto& instance) { one_instance(item, instance); });
}

}  // namespace

void instance_members(MemberWriter& io, const SequenceInfo& info) { instance_list(io, info); }
void instance_members(MemberReader& io, SequenceInfo& info) { instance_list(io, info); }

}  // namespace ensonify
