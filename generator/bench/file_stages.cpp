#include <cstring>

#include "bench/machine.h"
#include "bench/stages.h"
#include "dataset/image_exr.h"
#include "formats/files.h"
#include "formats/npy.h"
#include "formats/png.h"
#include "formats/sha256.h"
#include "labels/annotations.h"
#include "labels/cartesian.h"
#include "labels/display.h"
#include "labels/polar.h"
#include "labels/shadow.h"
#include "trace/scatter.h"

namespace ensonify {
namespace {

constexpr int kCartesianHeight_px = 1000;

struct Stages {
  const Bench& bench;
  CaseReport& report;

  template <class Body, class After>
  double add(const char* name, Body&& body, After&& after) const {
    const double ms = median_ms(bench.options.seconds, body, after);
    report.stages.push_back({name, ms});
    return ms;
  }
  template <class Body>
  double add(const char* name, Body&& body) const {
    return add(name, body, [] {});
  }
  void set_share(double rate, double peak, const char* of) const {
    report.stages.back().share = rate / peak;
    report.stages.back().share_of = of;
  }
};

PolarInput polar_input(const Bench& bench, const ScattererList& list, const PingSeries& series,
                       const std::vector<std::uint8_t>& class_of_instance) {
  PolarInput input;
  input.scatterers = &list;
  input.pressure_pa = series.pressure_pa;
  input.clean_power_pa2 = series.clean_power_pa2;
  input.bandwidth_hz = bench.setup.sonar.bandwidth_hz;
  input.beams = bench.setup.sonar.beam_count;
  input.samples = bench.setup.record.samples;
  input.class_of_instance = class_of_instance;
  return input;
}

// Shadows and amodal masks of both views; hidden echoes are made with them.
void time_shadow(const Stages& stages, const PolarInput& input, const std::vector<Hit>& hits,
                 const CartesianGrid& grid, const std::vector<std::int32_t>& map,
                 LabelledImage& polar) {
  const Bench& bench = stages.bench;
  const Workers one(1);
  const FanHitsBehind behind{trace_behind(bench, hits, one), {}};
  std::vector<Annotation> boxes = annotations(polar);
  stages.add("shadow", [&] {
    const HiddenEchoes hidden = hidden_echoes(bench.fan, hits, behind, {}, bench.scattering,
                                              bench.world.instances.size(), one);
    HiddenLabels labels = hidden_labels({input, hidden, {}, {}}, polar, one);
    add_amodal(labels.amodal, hidden.occlusion, boxes);
    add_amodal(resample(labels.amodal, grid, map), hidden.occlusion, boxes);
    polar.shadow = std::move(labels.shadow);
  });
}

LabelledImage time_images(const Stages& stages, const ScattererList& list,
                          const std::vector<Hit>& hits, const PingSeries& series) {
  const Bench& bench = stages.bench;
  const Workers one(1);
  std::vector<std::uint8_t> class_of_instance = {0};
  for (const Instance& i : bench.world.instances) class_of_instance.push_back(i.class_id);
  const PolarInput input = polar_input(bench, list, series, class_of_instance);
  LabelledImage polar, cartesian;
  stages.add("labels", [&] { polar = polar_image(input, one); });
  std::vector<Annotation> boxes;
  stages.add("annotations", [&] { boxes = annotations(polar); });
  const CartesianGrid grid = cartesian_grid(bench.setup.sonar, kCartesianHeight_px);
  const std::vector<std::int32_t> map =
      cartesian_map(grid, bench.setup.sonar, bench.setup.water, bench.setup.record);
  time_shadow(stages, input, hits, grid, map, polar);
  stages.add("cartesian", [&] { cartesian = resample(polar, grid, map); });
  return polar;
}

// Writes the buffered file as in data sets: hashed, under a temporary name, then renamed.
Status time_writing(const Stages& stages, const std::string& bytes,
                    const std::filesystem::path& folder) {
  const MachineReport& machine = stages.bench.machine;
  Status status;
  const std::string name = "ping.npy";
  // Every run writes a new file.
  const auto remove = [&] {
    std::error_code ignored;
    std::filesystem::remove(folder / name, ignored);
  };
  const auto write_data_set = [&] {
    const auto entry = write_file_atomically(folder, name, bytes);
    if (!entry) status = entry.error();
  };
  stages.add("write_data_set", write_data_set, remove);
  const PageBuffer pages(bytes.size());
  std::memcpy(pages.data(), bytes.data(), bytes.size());
  bool direct = true;
  const auto write_through = [&] {
    const Status written = write_to_disk(folder / name, pages.data(), bytes.size(), direct);
    if (!written) status = written;
  };
  const double ms = stages.add("write_to_disk", write_through, remove);
  stages.set_share(static_cast<double>(bytes.size()) / ms * 1e-3, machine.disk_mb_s, "disk");
  return status;
}

}  // namespace

Status time_file_stages(const Bench& bench, const ScattererList& list, const std::vector<Hit>& hits,
                        const PingSeries& series, const std::filesystem::path& folder,
                        CaseReport& report) {
  const Stages stages{bench, report};
  const LabelledImage polar = time_images(stages, list, hits, series);
  Display display;
  display.limits_db = db_limits_from_clean(polar.clean_db, polar.elevation_rad);
  const DisplayTable table = display_table(display, 0, 1, polar.rows);
  GreyImage grey;
  stages.add("grey", [&] {
    grey = displayed(table, polar.rows, polar.columns, polar.level_db, polar.elevation_rad).grey;
  });

  const auto beams = static_cast<std::uint64_t>(bench.setup.sonar.beam_count);
  const auto samples = static_cast<std::uint64_t>(bench.setup.record.samples);
  std::string npy;
  stages.add("encode_npy", [&] { npy = encode_npy(series.pressure_pa, {beams, samples}); });
  Status status;
  const auto keep_error = [&](const Result<std::string>& encoded) {
    if (!encoded) status = encoded.error();
  };
  stages.add("encode_exr", [&] { keep_error(encode_exr(polar, {})); });
  stages.add("encode_png", [&] { keep_error(encode_png(grey.pixels, grey.rows, grey.columns)); });
  stages.add("encode_masks", [&] {
    keep_error(encode_png(polar.instance, polar.rows, polar.columns));
    keep_error(encode_png(polar.semantic, polar.rows, polar.columns));
  });
  std::string hash;
  stages.add("sha256", [&] { hash = sha256_hex(npy); });
  if (!status) return status;
  return time_writing(stages, npy, folder);
}

}  // namespace ensonify
