#include <cmath>

#include "core/part_keys.h"
#include "core/units.h"
#include "dataset/manifest_members.h"
#include "dataset/member_schema.h"

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
  if constexpr (Io::kReads) {
    for (const auto& [grazing_deg, strength_db] : rows) {
      table.grazing_rad.push_back(radians(grazing_deg));
      table.strength_db.push_back(strength_db);
    }
  }
}

template <class Io, class Value>
void law_members(Io& io, Value& material) {
  std::size_t model = material.law.index();
  io.word_of("model", kLawWords, model);
  if constexpr (!Io::kWrites) material.law = law_at(model);
  if (!states_strength(material.law)) io("reflectivity", material.reflectivity);
  std::visit(
      [&](auto& law) {
        for (const auto& p : law.parameters()) {
          if constexpr (!Io::kWrites) (law.*p.value).emplace();
          io.number({p.key, p.title, p.meaning}, *(law.*p.value), from_to(p.least, p.most));
        }
        if constexpr (requires { law.table; }) table_rows(io, law.table);
      },
      material.law);
}

// The material of a surface or of a part of it.
template <class Io, class Value>
void coherent_members(Io& io, Value& material) {
  io.group_if("coherent", material.coherent != CoherentModel::none, [&](Io& coherent) {
    coherent.word("model", material.coherent, CoherentModel::kirchhoff, CoherentModel::rician);
    if (material.coherent == CoherentModel::rician) return coherent("k", material.rician_k);
    coherent("reflection", material.reflection);
    coherent("roughness_rms_m", material.roughness_rms_m);
    coherent.sometimes(material.roughness_correlation_m > 0, "roughness_correlation_m",
                       material.roughness_correlation_m);
    coherent.sometimes(material.edges, "edges", material.edges);
  });
}

template <class Io, class Value>
void wall_members(Io& io, Value& material) {
  io.maybe("wall", material.wall, [](Io& wall, auto& values) {
    wall_keys(wall, values);
    wall("water_inside", values.water_inside);
  });
}

// These members are left out if the surface or the volume is even.
template <class Io, class Value>
void factor_members(Io& io, const char* name, Value& factor) {
  bool is_uneven = factor.model != TextureModel::none;
  io.flag(name, is_uneven, [&](Io& members) {
    members.word("model", factor.model, TextureModel::lognormal, TextureModel::gamma);
    if (factor.model == TextureModel::gamma) members("shape", factor.shape);
    if (factor.model == TextureModel::lognormal) members("spread_db", factor.spread_db);
    members("correlation_m", factor.correlation_m);
  });
}

// `between(io)` lists what stands behind the law.
template <class Io, class Value, class Between>
void material_members(Io& io, Value& material, Between between) {
  io.group("law", [&](Io& law) { law_members(law, material); });
  between(io);
  coherent_members(io, material);
  wall_members(io, material);
  factor_members(io, "texture", material.texture);
}

template <class Io, class Value>
void surface_members(Io& io, Value& instance) {
  io("material", instance.material);
  material_members(io, instance.scattering, [&](Io& behind) {
    behind("vertex_reflectivity", instance.vertex_reflectivity);
    behind.sometimes(instance.image_reflectivity, "image_reflectivity",
                     instance.image_reflectivity);
  });
  io.list_if_any("growth", instance.growth, [](Io& item, auto& growth) {
    item("on", growth.on);
    item("material", growth.material);
    item("cover", growth.cover);
    item("correlation_m", growth.correlation_m);
    material_members(item, growth.scattering, [](Io&) {});
  });
  io.list_if_any("parts", instance.parts, [](Io& item, auto& part) {
    item("name", part.name);
    item("material", part.material);
    material_members(item, part.scattering, [](Io&) {});
  });
}

// Left out of instances without resonances.
template <class Io, class Value>
void elastic_members(Io& io, const char* key, Value& instance) {
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
      io.null_if(!std::isfinite(instance.target_strength_db), "target_strength_db",
                 instance.target_strength_db);
      elastic_members(io, "sphere", instance);
      break;
    case InstanceKind::volume:
      io("strength_db", instance.volume_strength_db);
      factor_members(io, "patches", instance.volume_patches);
      break;
  }
}

}  // namespace

template <class Io, class Info>
void instance_members(Io& io, Info& info) {
  io("classes", info.classes);
  io.list("instances", info.instances,
          [](Io& item, auto& instance) { one_instance(item, instance); });
}

template void instance_members(MemberWriter&, const SequenceInfo&);
template void instance_members(MemberReader&, SequenceInfo&);
template void instance_members(MemberSchema&, SequenceInfo&);

}  // namespace ensonify
