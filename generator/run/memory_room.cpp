#include "run/memory_room.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/counted.h"
#include "core/scatterers.h"
#include "ping/prepare_session.h"
#include "run/cost.h"
#include "run/memory.h"
#include "run/memory_there.h"
#include "run/world_memory.h"
#include "trace/hits.h"

namespace ensonify {
namespace {

// The part of an estimate that a run surely takes, since not all buffers are full at the same time;
// and of the hits and scatterers of a ping, which are.
constexpr double kSurely = 0.6, kSurelyTraced = 0.95;
// As `kFinestFast` of the CPU backend.
constexpr double kDoublePrecisionBelow = 1e-6;
// Allows for what an estimate may be too low by.
constexpr double kReserve = 1.1;

// What the estimate of a run follows from. Keys are changed in `session`.
struct RunNeed {
  Session session;
  EchoCounts echoes = {};
  std::uint64_t pieces = 0;  // of adaptive refinement, in place of echoes.surface if more
  SynthesisMemory synthesis = {};
  bool is_built = false;  // session.world is that of the run
};

std::vector<HeightfieldSpec*> terrains(Scenario& scenario) {
  std::vector<HeightfieldSpec*> found;
  for (ObjectSpec& object : scenario.objects) {
    auto* field = std::get_if<HeightfieldSpec>(&object.shape);
    const auto is_equal = [&](const HeightfieldSpec* other) { return *other == *field; };
    // Equal terrain is made once.
    const bool shared =
        field != nullptr && !is_random(*field) && std::ranges::any_of(found, is_equal);
    if (field != nullptr && !shared) found.push_back(field);
  }
  return found;
}

double bytes_with(const RunNeed& need, int threads) {
  EchoCounts echoes = need.echoes;
  echoes.surface = std::max(echoes.surface, need.pieces);
  const RunMemory run = run_memory(need.session, threads, {}, echoes, need.synthesis);
  double bytes = static_cast<double>(added_bytes(run));
  if (need.is_built) return bytes + static_cast<double>(hierarchy_bytes(need.session.world));
  Scenario scenario = need.session.scenario;
  for (const HeightfieldSpec* field : terrains(scenario)) bytes += terrain_bytes(*field);
  return bytes;
}

// While the last scatterers of a ping are made.
double traced_bytes(const RunNeed& need) {
  const Session& session = need.session;
  const bool is_cut = session.sonar.rays_per_cell != 0 &&
                      session.scenario.scattering.speckle != SpeckleMode::surface;
  const double of_ray = sizeof(Hit) + (is_cut ? 2 * sizeof(std::uint16_t) : 0);
  const auto scatterers = static_cast<double>(std::max(need.echoes.surface, need.pieces));
  return of_ray * static_cast<double>(ping_size(session).rays) + scatterers * sizeof(Scatterer);
}

double least_bytes(const RunNeed& need) {
  return std::max(kSurely * bytes_with(need, 1), kSurelyTraced * traced_bytes(need));
}

using Scale = std::function<void(RunNeed&, double part)>;

// A key that a user can lower.
struct Lever {
  std::string key, unit;
  double value = 0;
  Scale scale;        // a need to that with a part of the value
  Scale weighs = {};  // what the key is made responsible for, if that is less
  bool is_whole = true;
  bool rises = false;  // a larger value takes less
};

// A step that takes less where it is longer.
Lever step_lever(std::string key, double step_m, Scale scale) {
  return {std::move(key), "m", step_m, std::move(scale), {}, false, true};
}

std::uint64_t part_of(std::uint64_t count, double part) {
  return static_cast<std::uint64_t>(part * static_cast<double>(count));
}

int whole_part(int count, double part) { return std::max(1, static_cast<int>(part * count)); }

void scale_echoes(RunNeed& need, double part) {
  for (std::uint64_t* count : {&need.echoes.surface, &need.echoes.coherent, &need.echoes.hidden}) {
    *count = part_of(*count, part);
  }
}

void scale_synthesis(RunNeed& need, double part) {
  need.synthesis.shared_bytes = part_of(need.synthesis.shared_bytes, part);
  need.synthesis.ping_bytes = part_of(need.synthesis.ping_bytes, part);
  need.synthesis.thread_bytes = part_of(need.synthesis.thread_bytes, part);
}

template <class T>
void shorten(std::vector<T>& values, int count) {
  if (!values.empty()) values.resize(static_cast<std::size_t>(count));
}

void scale_beams(RunNeed& need, double part) {
  Sonar& sonar = need.session.sonar;
  sonar.beam_count = whole_part(sonar.beam_count, part);
  shorten(sonar.azimuth_rad, sonar.beam_count);
  shorten(sonar.width_rad, sonar.beam_count);
  if (sonar.front_end) shorten(sonar.front_end->beam_response, sonar.beam_count);
  need.pieces = part_of(need.pieces, part);
  scale_echoes(need, part);
  scale_synthesis(need, part);
}

Lever beams_lever(const Sonar& sonar, Scale weighs) {
  return {"sonar.beams.count", "beams", double(sonar.beam_count), scale_beams, std::move(weighs)};
}

// The largest of the numbers whose product is that of rays. Refinement replaces missing rows, but
// no columns.
Lever rays_lever(const Sonar& sonar) {
  const bool azimuth = sonar.rays_azimuth > sonar.rays_elevation;
  int Sonar::*const rays = azimuth ? &Sonar::rays_azimuth : &Sonar::rays_elevation;
  const Scale scale = [rays, azimuth](RunNeed& need, double part) {
    need.session.sonar.*rays = whole_part(need.session.sonar.*rays, part);
    if (azimuth) need.pieces = part_of(need.pieces, part);
    scale_echoes(need, part);
  };
  if (sonar.beam_count > sonar.*rays) return beams_lever(sonar, scale);
  return {azimuth ? "sonar.rays.azimuth" : "sonar.rays.elevation", "rays", double(sonar.*rays),
          scale};
}

// Typical records have several times more samples than beams.
constexpr int kSamplesPerBeam = 2;

void scale_samples(RunNeed& need, double part) {
  Record& record = need.session.record;
  record.samples = whole_part(record.samples, part);
  record.transform = whole_part(record.transform, part);
  need.pieces = part_of(need.pieces, part);
  scale_synthesis(need, part);
}

Lever pixels_lever(const Session& session) {
  if (kSamplesPerBeam * session.sonar.beam_count > session.record.samples) {
    return beams_lever(session.sonar, scale_samples);
  }
  const Scale scale = [](RunNeed& need, double part) {
    scale_samples(need, part);
    need.session.sonar.range_max_m *= part;
  };
  return {"sonar.range_max_m", "m", session.sonar.range_max_m, scale, scale_samples, false};
}

Lever terrain_lever(const Scenario& scenario, std::size_t object) {
  const auto& field = std::get<HeightfieldSpec>(scenario.objects[object].shape);
  return step_lever(fmt::format("objects.{}.shape.heightfield.cell_m", object), field.cell_m,
                    [object](RunNeed& need, double part) {
                      auto& shape = need.session.scenario.objects[object].shape;
                      std::get<HeightfieldSpec>(shape).cell_m /= part;
                    });
}

// Meshes cannot be lowered by a number.
Lever mesh_lever(const World& world, std::size_t object, const ShapeSpec& spec) {
  const char* shape = std::holds_alternative<LevelSetSpec>(spec)      ? "level_set.file"
                      : std::holds_alternative<HeightfieldSpec>(spec) ? "heightfield.file"
                                                                      : "mesh.file";
  const Mesh& mesh = *std::get<MeshShape>(world.objects[object].shape).mesh;
  return {fmt::format("objects.{}.shape.{}", object, shape), "triangles",
          double(mesh.triangles.size()), [object](RunNeed& need, double part) {
            auto& mesh_shape = std::get<MeshShape>(need.session.world.objects[object].shape);
            Mesh less;
            less.triangles.resize(part_of(mesh_shape.mesh->triangles.size(), part));
            mesh_shape.mesh = std::make_shared<const Mesh>(std::move(less));
          }};
}

void add_scene_levers(const RunNeed& need, std::vector<Lever>& levers) {
  const Scenario& scenario = need.session.scenario;
  for (std::size_t i = 0; i < scenario.objects.size(); ++i) {
    const auto* field = std::get_if<HeightfieldSpec>(&scenario.objects[i].shape);
    const bool is_synthetic = field != nullptr && field->file.empty();
    if (!need.is_built && is_synthetic) levers.push_back(terrain_lever(scenario, i));
    if (need.is_built && std::holds_alternative<MeshShape>(need.session.world.objects[i].shape)) {
      levers.push_back(mesh_lever(need.session.world, i, scenario.objects[i].shape));
    }
  }
  if (scenario.output.sdf) {
    levers.push_back(step_lever(
        "output.sdf.voxel_m", scenario.output.sdf->voxel_m,
        [](RunNeed& less, double part) { less.session.scenario.output.sdf->voxel_m /= part; }));
  }
  if (scenario.output.height_map) {
    levers.push_back(step_lever("output.height_map.spacing_m",
                                scenario.output.height_map->spacing_m,
                                [](RunNeed& less, double part) {
                                  less.session.scenario.output.height_map->spacing_m /= part;
                                }));
  }
}

std::vector<Lever> levers_of(const RunNeed& need) {
  const Session& session = need.session;
  std::vector<Lever> levers = {rays_lever(session.sonar), pixels_lever(session)};
  if (session.scenario.output.selection.cartesian) {
    levers.push_back({"output.cartesian.height_px", "pixels",
                      double(session.scenario.output.cartesian_height_px),
                      [](RunNeed& less, double part) {
                        int& height_px = less.session.scenario.output.cartesian_height_px;
                        height_px = whole_part(height_px, part);
                      }});
  }
  add_scene_levers(need, levers);
  return levers;
}

double least_with(const RunNeed& need, const Scale& scale, double part) {
  RunNeed less = need;
  scale(less, part);
  return least_bytes(less);
}

// Less of a key than this does not help.
constexpr double kLeastPart = 1e-4;

// The largest part of a key that fits; 0 if none does.
double fitting_part(const RunNeed& need, const Lever& lever, double there) {
  if (least_with(need, lever.scale, kLeastPart) > there) return 0;
  double fits = kLeastPart, too_much = 1;
  while (too_much - fits > 0.05 * fits) {
    const double middle = std::sqrt(fits * too_much);
    (least_with(need, lever.scale, middle) <= there ? fits : too_much) = middle;
  }
  return fits;
}

// Two digits, toward the side that fits.
std::string fitting_value(const Lever& lever, double part) {
  const double value = lever.rises ? lever.value / part : lever.value * part;
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1);
  const double steps = value / unit;
  double rounded = (lever.rises ? std::ceil(steps) : std::floor(steps)) * unit;
  if (lever.is_whole) rounded = std::max(1.0, std::floor(rounded));
  return fmt::format("{:.6g} {}", rounded, lever.unit);
}

// Outputs that hold much for each pixel, and that a data set can do without.
constexpr std::pair<const char*, bool OutputSelection::*> kSpared[] = {
    {"output.statistics", &OutputSelection::statistics},
    {"output.layers", &OutputSelection::layers},
    {"output.channels", &OutputSelection::channels},
    {"output.elevation", &OutputSelection::elevation},
};

std::string without_outputs(const RunNeed& need, double there) {
  for (const auto& [key, wanted] : kSpared) {
    RunNeed less = need;
    if (!std::exchange(less.session.scenario.output.selection.*wanted, false)) continue;
    if (least_bytes(less) <= there) return fmt::format(", or no {}", key);
  }
  return "";
}

std::string text_of(double bytes) { return bytes_text(static_cast<std::uint64_t>(bytes)); }

Status room_for(const RunNeed& need, const MemoryThere& there) {
  const double least = least_bytes(need), available = static_cast<double>(there.bytes);
  if (least <= available) return {};
  const std::vector<Lever> levers = levers_of(need);
  const Lever* costly = nullptr;
  double left = HUGE_VAL;
  for (const Lever& lever : levers) {
    const Scale& weighs = lever.weighs ? lever.weighs : lever.scale;
    const double without = least_with(need, weighs, kLeastPart);
    if (without < left) costly = &lever, left = without;
  }
  const double part = fitting_part(need, *costly, available);
  const std::string expected =
      part > 0 ? fmt::format("{} {}", costly->rises ? "at least" : "at most",
                             fitting_value(*costly, part))
               : std::string("less, and less of other keys, because the rest does not fit either");
  return Error{
      ErrorKind::device,
      fmt::format("{}: {:.6g} {} take at least {} of memory with one thread, but {} is "
                  "available{}; expected {}{}",
                  costly->key, costly->value, costly->unit, text_of(least), text_of(available),
                  there.limit, expected, without_outputs(need, available))};
}

// Why the device cannot make these pings, with what would be right; empty: it can.
std::string what_prevents(const Session& session, const Tracer& tracer, const Numerics& numerics) {
  const double tolerance = session.scenario.synthesis_tolerance;
  if (tolerance < kDoublePrecisionBelow) {
    return fmt::format(
        "synthesis.tolerance: {:g} needs double precision, in which only the processor computes; "
        "expected at least {:g}",
        tolerance, kDoublePrecisionBelow);
  }
  const auto tables = pipeline_tables(session, numerics);
  const bool has_volumes = !session.world.volumes.empty();
  const auto missing = [&](const EchoCounts& echoes) {
    return tables->backend->missing_bytes(echoes.surface + echoes.coherent, has_volumes);
  };
  if (missing(most_echoes(session)) == 0) return "";
  EchoProbe probe = probe_echoes(session, tracer);
  probe.counts.surface = std::max(probe.counts.surface, probe.least_pieces);
  const std::uint64_t bytes = missing(probe.counts);
  if (bytes == 0) return "";
  return fmt::format(
      "one ping needs {} more memory than is free on the device; expected fewer beams or rays, or "
      "a shorter range",
      text_of(static_cast<double>(bytes)));
}

// The estimate for a number of threads, with the stacks of threads where they count.
double likely_bytes(const RunNeed& need, int threads, const MemoryThere& there) {
  return kReserve * bytes_with(need, threads) +
         static_cast<double>(threads * there.bytes_per_thread);
}

}  // namespace

Status room_for_scenario(const Scenario& scenario) {
  Result<Session> session = prepare_without_world(scenario, 0);
  if (!session) return {};
  return room_for({std::move(*session)}, memory_there());
}

Status room_for_world(const Session& session) {
  return room_for({.session = session, .is_built = true}, memory_there());
}

Result<int> threads_that_fit(const Session& session, const Tracer& tracer, const Numerics& numerics,
                             int threads, const std::function<void(std::string_view)>& warn) {
  const MemoryThere there = memory_there();
  const double available = static_cast<double>(there.bytes);
  RunNeed need{.session = session, .is_built = true};
  // The reference has no tables to speak of.
  if (numerics.backend != BackendChoice::reference) {
    need.synthesis =
        pipeline_tables(session, numerics)->backend->memory(!session.world.volumes.empty());
  }
  need.echoes = most_echoes(session);
  if (likely_bytes(need, threads, there) <= available) return threads;
  const EchoProbe probe = probe_echoes(session, tracer);
  need.echoes = probe.counts;
  need.pieces = probe.least_pieces;
  if (Status room = room_for(need, there); !room) return room.error();
  need.pieces = probe.likely_pieces;
  int fit = threads;
  while (fit > 1 && likely_bytes(need, fit, there) > available) --fit;
  const double one = likely_bytes(need, fit, there);
  if (one > available) {
    warn(fmt::format("memory may not suffice: one thread needs about {}, and {} is available{}",
                     text_of(one), text_of(available), there.limit));
  } else if (fit < threads) {
    warn(fmt::format("{} in place of {}, which need about {} of memory, and {} is available{}",
                     counted(static_cast<std::uint64_t>(fit), "thread"), threads,
                     text_of(likely_bytes(need, threads, there)), text_of(available), there.limit));
  }
  return fit;
}

Result<Numerics> numerics_that_fit(const Session& session, const Tracer& tracer,
                                   const Numerics& numerics,
                                   const std::function<void(std::string_view)>& warn) {
  if (numerics.backend != BackendChoice::cuda) return numerics;
  std::string reason;
  try {
    reason = what_prevents(session, tracer, numerics);
  } catch (const DeviceFailure& failure) {
    reason = failure.what();
  }
  if (reason.empty()) return numerics;
  if (!numerics.may_fall_back) {
    const bool is_told = reason.ends_with("--backend cpu");
    return Error{ErrorKind::device, is_told ? reason : reason + ", or --backend cpu"};
  }
  warn(fmt::format("cpu in place of {}: {}", numerics.backend_name, reason));
  return Numerics{BackendChoice::cpu, numerics.simd, "cpu", false, {}, numerics.tables};
}

}  // namespace ensonify
