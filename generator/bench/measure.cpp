#include "bench/machine.h"
#include "bench/stages.h"
#include "core/random.h"

namespace ensonify {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kCopyBytes = std::size_t{256} << 20;
constexpr std::size_t kDiskBytes = std::size_t{256} << 20;
constexpr std::size_t kGentleBytes = std::size_t{1} << 20;
constexpr std::uint64_t kSeed = 1;

SynthesisSetup setup_of(const BenchCase& c) {
  SynthesisSetup setup;
  setup.sonar = c.sonar;
  setup.water = c.water;
  setup.record = make_record(c.sonar, c.water, 0);  // none of the pulses is long
  return setup;
}

struct FrontTimes {
  double trace_ms = 0, scatterers_ms = 0;
};

FrontTimes time_front(const Bench& bench, const Workers& workers) {
  std::vector<Hit> hits;
  ScattererList list;
  FrontTimes times;
  const double seconds = bench.options.seconds;
  times.trace_ms = median_ms(seconds, [&] { hits = trace_ping(bench, workers); });
  times.scatterers_ms = median_ms(seconds, [&] { list = scatterers_of(bench, hits, workers); });
  return times;
}

double one_ray_at_a_time_ms(const Bench& bench) {
  const Fan& fan = bench.fan;
  return median_ms(bench.options.seconds, [&] {
    std::vector<Hit> hits(fan.size());
    std::size_t ray = 0;
    for (const double azimuth : fan.azimuth_rad) {
      for (const double elevation : fan.elevation_rad) {
        const Vec3 direction = rotate(bench.pose.rotation, unit_vector(azimuth, elevation));
        hits[ray++] = bench.tracer.first_hit({bench.pose.position_m, normalized(direction)},
                                             bench.setup.sonar.range_max_m);
      }
    }
  });
}

// From tracing to time series in memory, whole pings in parallel, one per thread, as `generate`
// makes them.
double pings_per_s(const Bench& bench, const Backend& backend, int threads, bool wants_clean) {
  constexpr int kPingsEach = 4;
  std::vector<PingSeries> series(threads);
  const Workers side_by_side(threads);
  const double ms = median_ms(bench.options.seconds, [&] {
    side_by_side.for_each(threads, [&](std::size_t lane) {
      const Workers one(1);
      for (int i = 0; i < kPingsEach; ++i) {
        const ScattererList list = scatterers_of(bench, trace_ping(bench, one), one);
        const PingTask task{&list, bench.keys, 0, {}, wants_clean};
        backend.synthesize({&task, 1}, {&series[lane], 1}, one);
      }
    });
  });
  return 1000 * threads * kPingsEach / ms;
}

MachineReport measure_machine(const BenchOptions& options, const Workers& workers) {
  MachineReport machine;
  machine.threads = workers.threads();
  machine.simd = best_kernels().level;
  machine.fma_gflops = fma_gflops(best_kernels(), options.seconds);
  machine.copy_gb_s = copy_gb_s(options.gentle_peaks ? kGentleBytes : kCopyBytes, options.seconds);
  return machine;
}

// Rates on all threads, and those of the plain methods.
void compare_whole_pings(const Bench& bench, const Backend& backend, const ScattererList& list,
                         const std::vector<std::complex<float>>& amplitude, const Workers& all,
                         CaseReport& report) {
  report.pings_per_s_1_thread = pings_per_s(bench, backend, 1, false);
  report.pings_per_s = pings_per_s(bench, backend, all.threads(), false);
  report.clean_pings_per_s = pings_per_s(bench, backend, all.threads(), true);
  const FrontTimes front = time_front(bench, all);
  const double speckle_ms =
      median_ms(bench.options.seconds, [&] { drawn_amplitudes(list, bench.keys); });
  const bool is_array = bench.setup.sonar.array.has_value();
  const PlainTimes plain = is_array ? time_plain_array(bench, list, amplitude, all, nullptr)
                                    : time_plain_methods(bench, list, amplitude, all, nullptr);
  // Assumes that the scalar draws scale perfectly with threads.
  const double before_ms = front.trace_ms + front.scatterers_ms + speckle_ms / all.threads();
  report.direct_pings_per_s = 1000 / (before_ms + plain.direct_ms);
  report.recurrence_pings_per_s = 1000 / (before_ms + plain.recurrence_ms);
}

Result<CaseReport> measure_case(const BenchCase& c, const BenchOptions& options,
                                const MachineReport& machine, const Workers& all,
                                const fs::path& folder) {
  const Bench bench(c, options, machine);
  const std::unique_ptr<Backend> backend = make_cpu_backend(bench.setup);
  const Workers one(1);
  CaseReport report;
  report.name = c.name;
  report.beams = c.sonar.beam_count;
  report.rays_per_beam = static_cast<int>(bench.fan.rays_per_beam());
  report.samples = bench.setup.record.samples;
  report.transform = bench.setup.record.transform;

  const ScattererList list = scatterers_of(bench, trace_ping(bench, all), all);
  const std::vector<std::complex<float>> amplitude = drawn_amplitudes(list, bench.keys);
  report.scatterers = list.size();
  const PingTask task{&list, bench.keys, 0, {}};
  PingSeries series;
  backend->synthesize({&task, 1}, {&series, 1}, all);
  const bool is_array = bench.setup.sonar.array.has_value();
  if (is_array) {
    constexpr int kCheckedBeams = 16;
    const SeriesError error = check_array(bench, list, amplitude, series, kCheckedBeams, all);
    report.error = error.relative;
    report.worst_tenth_error = error.worst_tenth;
  } else {
    auto spectra = exact_spectra(bench.setup, list, amplitude, best_kernels(), all);
    check_plain_methods(bench, list, amplitude, spectra, all, report);
    const auto exact = exact_series(bench.setup, std::move(spectra), all);
    const SeriesError error = series_error(series.pressure_pa, exact, report.beams);
    report.error = error.relative;
    report.worst_tenth_error = error.worst_tenth;
  }

  const FrontTimes front = time_front(bench, one);
  const std::vector<Hit> hits = trace_ping(bench, all);
  const double continue_ms = median_ms(options.seconds, [&] { trace_behind(bench, hits, one); });
  report.stages = {
      {"trace", front.trace_ms}, {"continue", continue_ms}, {"scatterers", front.scatterers_ms}};
  report.references = {{"trace_one_ray", one_ray_at_a_time_ms(bench)}};
  if (is_array) {
    time_array_stages(bench, list, report);
  } else {
    time_backend_stages(bench, list, report);
  }
  report.references.push_back(
      {"speckle_scalar", median_ms(options.seconds, [&] { drawn_amplitudes(list, bench.keys); })});
  report.stages.push_back({"synthesis", median_ms(options.seconds, [&] {
                             backend->synthesize({&task, 1}, {&series, 1}, one);
                           })});
  if (is_array) {
    time_plain_array(bench, list, amplitude, one, &report);
  } else {
    time_plain_methods(bench, list, amplitude, one, &report.references);
  }
  compare_whole_pings(bench, *backend, list, amplitude, all, report);
  if (Status s = time_file_stages(bench, list, hits, series, folder, report); !s) return s.error();
  return report;
}

}  // namespace

Bench::Bench(const BenchCase& bench_case, const BenchOptions& bench_options,
             const MachineReport& machine_report)
    : options(bench_options),
      machine(machine_report),
      setup(setup_of(bench_case)),
      world(make_bench_world(bench_case.sonar.range_max_m)),
      tracer(world),
      fan(make_fan(bench_case.sonar)),
      scattering(make_surface_scattering(setup.sonar, setup.water, world)) {
  keys.speckle = stream_key(kSeed, Stream::speckle, 0);
}

HitsBehind trace_behind(const Bench& bench, const std::vector<Hit>& hits, const Workers& workers) {
  return bench.tracer.trace_behind(bench.fan, hits, bench.pose, bench.setup.sonar.range_max_m,
                                   workers);
}

std::vector<Hit> trace_ping(const Bench& bench, const Workers& workers) {
  return bench.tracer.trace_fan(bench.fan, bench.pose, bench.setup.sonar.range_max_m, workers);
}

ScattererList scatterers_of(const Bench& bench, const std::vector<Hit>& hits,
                            const Workers& workers) {
  return surface_scatterer_list(bench.fan, hits, bench.scattering, workers);
}

Result<BenchReport> run_bench(const BenchOptions& options) {
  const fs::path disk = options.disk.empty() ? fs::temp_directory_path() : options.disk;
  Result<ScratchFolder> folder = ScratchFolder::make(disk);
  if (!folder) return folder.error();
  const auto say = [&](const std::string& text) {
    if (options.on_progress) options.on_progress(text);
  };
  const Workers all(options.threads);
  BenchReport report;
  say("machine");
  report.machine = measure_machine(options, all);
  const std::size_t disk_bytes = options.gentle_peaks ? kGentleBytes : kDiskBytes;
  if (Status s = measure_disk(folder->path(), disk_bytes, report.machine); !s) return s.error();
  for (const BenchCase& c : options.cases) {
    say(c.name);
    Result<CaseReport> measured = measure_case(c, options, report.machine, all, folder->path());
    if (!measured) return measured.error();
    report.cases.push_back(std::move(*measured));
  }
  return report;
}

}  // namespace ensonify
