#include <algorithm>
#include <utility>

#include "dataset/json_members.h"
#include "dataset/manifest_json.h"
#include "dataset/manifest_members.h"
#include "dataset/member_schema.h"

namespace ensonify {
namespace {

template <class Io, class Value>
void identity_members(Io& io, Value& identity, bool with_pings) {
  if (with_pings) {
    io("seed", identity.seed);
    io.pings(identity.first_ping, identity.last_ping);
  }
  io.group("program", [&](Io& program) {
    program("version", identity.program_version);
    program("commit", identity.program_commit);
  });
  io.group("numerics", [&](Io& numerics) {
    numerics("backend", identity.backend);
    numerics("simd", identity.simd);
    numerics("embree_isa", identity.embree_isa);
  });
}

std::vector<std::uint32_t> sequences_of_split(const std::vector<SequenceEntry>& entries,
                                              const char* split) {
  std::vector<std::uint32_t> sequences;
  for (const SequenceEntry& entry : entries) {
    if (entry.split == split) sequences.push_back(entry.sequence);
  }
  return sequences;
}

template <class Io, class Value>
void dataset_members(Io& io, Value& manifest) {
  io("ensonify_dataset", manifest.version);
  io("name", manifest.identity.name);
  identity_members(io, manifest.identity, false);
  io("seed", manifest.identity.seed);
  io("scenario_sha256", manifest.identity.scenario_sha256);
  io("classes", manifest.classes);
  io("class_kinds", manifest.class_kinds);
  if constexpr (!Io::kReads) {
    io.group("splits", [&](Io& splits) {
      for (const char* name : {"train", "val", "test"}) {
        splits(name, sequences_of_split(manifest.sequences, name));
      }
    });
  }
  io.optional("png", manifest.png,
              [&](Io& png, auto& display) { display_members(png, display, manifest.png_counts); });
  io("bytes", manifest.bytes);
  io.list("sequences", manifest.sequences, [](Io& item, auto& entry) {
    item("sequence", entry.sequence);
    item.pings(entry.first_ping, entry.last_ping);
    item("seed", entry.seed);
    item("split", entry.split);
    item("bytes", entry.bytes);
    item("sha256", entry.sha256);
  });
  io.maybe("placement", manifest.placement, [](Io& group, auto& totals) {
    group("sequences", totals.sequences);
    group("redrawn", totals.redrawn);
    group("redraws", totals.redraws);
    group("left_out", totals.left_out);
    group.list("classes", totals.classes,
               [](Io& item, auto& placed) { placed_class_members(item, placed); });
  });
  io.list_if_any("failed", manifest.failed, [](Io& item, auto& failure) {
    item("sequence", failure.sequence);
    item("error", failure.error);
  });
}

}  // namespace

void add(const Placement& placement, PlacementTotals& totals) {
  ++totals.sequences;
  totals.redrawn += placement.redraws > 0;
  totals.redraws += placement.redraws;
  totals.left_out += placement.left_out.size();
  for (const PlacedClass& placed : placement.classes) {
    auto& classes = totals.classes;
    auto at = std::lower_bound(classes.begin(), classes.end(), placed.class_name,
                               [](const PlacedClass& of, const std::string& name) {
                                 return of.class_name < name;
                               });
    if (at == classes.end() || at->class_name != placed.class_name) {
      at = classes.insert(at, {placed.class_name, 0, 0});
    }
    at->first += placed.first;
    at->kept += placed.kept;
  }
}

Json dataset_json(const DatasetManifest& manifest, const std::vector<FileEntry>& files) {
  Json json = Json::object();
  MemberWriter io(json);
  dataset_members(io, manifest);
  files_member(io, files);
  return json;
}

Json dataset_schema() {
  return MemberSchema::object_of([](MemberSchema& io) {
    DatasetManifest manifest;
    dataset_members(io, manifest);
    files_member(io, {});
  });
}

std::optional<DatasetManifest> read_dataset_head(const Json& head) {
  if (!count_at(head, "ensonify_dataset")) return std::nullopt;
  DatasetManifest manifest;
  MemberReader io(head, manifest.fault);
  dataset_members(io, manifest);
  return manifest;
}

Json work_json(const WorkIdentity& identity) {
  Json json = {{"ensonify_work", 1}};
  MemberWriter io(json);
  io("name", identity.name);
  io("scenario_sha256", identity.scenario_sha256);
  identity_members(io, identity, true);
  return json;
}

static const char* name_of(Resampling value) { return resampling_name(value); }

template <class Io, class Shown, class Counts>
void display_members(Io& io, Shown& display, Counts& counts, std::optional<double> absorption_db_m) {
  io.word("scale", display.scale, GreyScale::amplitude);
  io("db", display.limits_db);
  io.word("resampling", display.resampling, Resampling::nearest);
  io.group("pixels", [&](Io& pixels) {
    pixels("all", counts.all);
    pixels("white", counts.white);
    pixels("echo", counts.echo);
    pixels("black", counts.black);
  });
  io.together_if(!is_plain(display), [&](Io& gains) {
    gains("gamma", display.gamma);
    gains("gain_db", display.gain_db);
    gains.group("tvg", [&](Io& tvg) {
      tvg("spreading", display.spreading);
      if (!absorption_db_m) return tvg("absorption", display.absorption);
      double alpha_db_m = display.absorption ? *absorption_db_m : 0;
      tvg("absorption_db_m", alpha_db_m);
      if constexpr (Io::kReads) display.absorption = alpha_db_m != 0;
    });
    gains("automatic_gain", display.automatic_gain);
  });
}

template void display_members(MemberWriter&, const Display&, const DisplayCounts&,
                              std::optional<double>);
template void display_members(MemberReader&, Display&, DisplayCounts&, std::optional<double>);
template void display_members(MemberSchema&, Display&, DisplayCounts&, std::optional<double>);

bool is_plain(const Display& display) {
  Display plain;
  plain.limits_db = display.limits_db;
  plain.color_map = display.color_map;
  plain.flip = display.flip;
  plain.resampling = display.resampling;
  return display == plain;
}

}  // namespace ensonify
