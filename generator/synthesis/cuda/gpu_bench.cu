// ensonify_gpu_bench measures how fast a device synthesizes, and compares it with the processor and
// with the limits of memory and bus in the same run. Needs neither a world nor a scenario.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "acoustics/propagation.h"
#include "core/random.h"
#include "core/units.h"
#include "synthesis/cuda/cuda_queue.cuh"
#include "synthesis/cuda/device_backend.h"

namespace ensonify {
namespace {

struct Case {
  const char* name;
  int rays_per_beam, elements;  // 0 elements: beam cells
  int pings;
};

double seconds_of(const std::function<void()>& body, int repeats) {
  std::vector<double> times;
  for (int i = 0; i < repeats; ++i) {
    const auto start = std::chrono::steady_clock::now();
    body();
    times.push_back(
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  std::sort(times.begin(), times.end());
  return times[times.size() / 2];
}

// The sonar of the program's `full` case: 512 beams over 90 degrees, 60 m, 29.9 kHz.
Sonar sonar_of(const Case& c) {
  Sonar sonar;
  sonar.frequency_hz = 900e3;
  sonar.bandwidth_hz = 29.9e3;
  sonar.source_level_db = 220;
  sonar.range_max_m = 60;
  sonar.beam_count = 512;
  sonar.beam_spacing_rad = radians(90) / 512;
  sonar.beam_width_rad = radians(1);
  sonar.elevation_width_rad = sonar.elevation_fan_rad = radians(20);
  sonar.rays_elevation = c.rays_per_beam;
  if (c.elements > 0) {
    ArrayReceiver& array = sonar.array.emplace();
    array.elements = c.elements;
    array.spacing_m = 1500 / 900e3 / 2;
    array.response.assign(c.elements, 1.0);
  }
  return sonar;
}

// Diffuse echoes over the whole record.
ScattererList echoes_of(const Sonar& sonar, std::uint64_t seed) {
  std::vector<Scatterer> echoes(std::size_t(sonar.beam_count) * sonar.rays_elevation);
  for (std::size_t i = 0; i < echoes.size(); ++i) {
    Scatterer& s = echoes[i];
    const double range_m = 5 + 54 * uniform(seed, 0, i, 0);
    s.delay_s = two_way_delay_s(range_m, 1500);
    s.gain = static_cast<float>(two_way_loss(range_m, 0.3));
    s.beam = static_cast<std::uint32_t>(i % sonar.beam_count);
    s.arrival.azimuth_rad = static_cast<float>(beam_azimuth_rad(sonar, static_cast<int>(s.beam)));
    s.received_path_m = static_cast<float>(range_m);
    s.standard_deviation = 1;
    s.key = i;
  }
  return sorted_by_beam_and_delay(std::move(echoes), sonar.beam_count);
}

double relative(const Series& a, const Series& b) {
  double error = 0, norm = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    error += std::norm(std::complex<double>(a[i]) - std::complex<double>(b[i]));
    norm += std::norm(std::complex<double>(b[i]));
  }
  return std::sqrt(error / norm);
}

// The least device memory traffic of a ping's sums, with every array read or written once per pass,
// and the multiply-adds of its last sums.
struct Work {
  double bytes, fma;
};

Work work_of(const SynthesisSetup& setup, const ArrayTables& tables) {
  const double beams = setup.sonar.beam_count, out = beams * setup.record.samples;
  const double bins = setup.record.transform, elements = setup.sonar.array->elements;
  const DeviceGroups& groups = tables.groups;
  const ArrayNodeTables& nodes = tables.nodes;
  const double points = elements * groups.points, powers = 2 * groups.terms;
  const double steered = nodes.count * bins, near = nodes.near_samples > 0 ? 2 * bins : 0;
  // Each array is written, transformed where it is a grid or a record, and read: moments, grids,
  // spectra, rows along the array, records of nodes, records for near samples, beams.
  Work work{sizeof(Complex32) *
                (2 * points * powers + 4 * points + 2 * elements * bins + 4 * nodes.grid * bins +
                 4 * nodes.orders * steered + 4 * elements * near + out),
            2 * points * powers * groups.width + 10.0 * kSteerTaps * steered +
                20 * beams * nodes.near_samples * elements};
  for (const NodePiece& p : nodes.pieces) {
    work.fma += beams * p.count * p.orders * p.taps * (2.0 * p.degree + 4);
  }
  return work;
}

Work work_of_sectors(const SynthesisSetup& setup, int points) {
  const double beams = setup.sonar.beam_count, samples = setup.record.samples;
  const double bins = setup.record.transform, out = beams * samples;
  return {sizeof(Complex32) * (beams * (4.0 * points + 4 * bins) + out), 2 * out * beams};
}

struct Rates {
  double memory, up, down, fma;  // B/s, 1/s
};

struct Times {
  double device_s, series_s, levels_s, cpu_s;  // per ping
  double error;
};

// Runs all tasks by the backend from two threads, so that copies of one batch and sums of the other
// run at the same time. Returns seconds per ping.
double backend_s(const Backend& backend, std::vector<PingTask> tasks, bool only_level,
                 std::vector<PingSeries>& series, const Workers& workers) {
  for (PingTask& task : tasks) task.only_level = only_level;
  const std::size_t half = (tasks.size() + 1) / 2;
  const auto all = [&] {
    Workers(2).for_each(2, [&](std::size_t i) {
      const std::size_t first = i * half, count = i == 0 ? half : tasks.size() - half;
      backend.synthesize(std::span(tasks).subspan(first, count),
                         std::span(series).subspan(first, count), workers);
    });
  };
  all();  // makes plans and allocates memory
  return seconds_of(all, 5) / static_cast<double>(tasks.size());
}

template <class Program>
Times times_of(const SynthesisSetup& setup, const std::vector<PingTask>& tasks,
               const Workers& workers) {
  Times times{};
  {
    CudaQueue queue(0);
    Program program(queue, setup);
    PingBatch batch;
    fill_batch(setup, tasks, workers, batch);
    program.upload(batch, workers);
    program.compute(batch);
    queue.wait();
    const auto compute = [&] {
      program.compute(batch);
      queue.wait();
    };
    times.device_s = seconds_of(compute, 5) / static_cast<double>(tasks.size());
  }
  const auto device =
      make_device_backend<CudaQueue>([] { return std::make_unique<CudaQueue>(0); }, setup);
  std::vector<PingSeries> series(tasks.size());
  times.levels_s = backend_s(*device, tasks, true, series, workers);
  times.series_s = backend_s(*device, tasks, false, series, workers);
  const auto cpu = make_cpu_backend(setup);
  PingSeries expected;
  const auto one = [&] { cpu->synthesize({&tasks[0], 1}, {&expected, 1}, workers); };
  one();
  times.cpu_s = seconds_of(one, 5);
  times.error = relative(series[0].pressure_pa, expected.pressure_pa);
  return times;
}

template <class Program>
void run_case(const Case& c, const Rates& rates, const Workers& workers) {
  const Sonar sonar = sonar_of(c);
  const Water water{1500, 0.3};
  const SynthesisSetup setup{sonar, water, make_record(sonar, water, 0)};
  std::vector<ScattererList> lists;
  for (int p = 0; p < std::min(c.pings, 4); ++p) lists.push_back(echoes_of(sonar, p));
  std::vector<PingTask> tasks;
  for (int p = 0; p < c.pings; ++p) {
    const RandomKeys keys{stream_key(1, Stream::speckle, 0), static_cast<std::uint32_t>(p), 2,
                          static_cast<std::uint32_t>(p), 3};
    tasks.push_back({&lists[p % lists.size()], keys, 0, {}, false});
  }
  const Times times = times_of<Program>(setup, tasks, workers);
  const Work work = sonar.array ? work_of(setup, make_array_tables(setup))
                                : work_of_sectors(setup, make_beam_tables(setup).series.points);
  const double cells = double(sonar.beam_count) * setup.record.samples;
  const double up = lists[0].size() * double(sizeof(EchoRecord) + sizeof(std::uint32_t));
  std::printf("%-6s %8zu %10.1f %10.1f %10.1f %10.2f %8.1e | %10.0f %10.0f %10.0f %10.0f\n", c.name,
              lists[0].size(), 1 / times.device_s, 1 / times.series_s, 1 / times.levels_s,
              1 / times.cpu_s, times.error, rates.memory / work.bytes, rates.fma / work.fma,
              rates.up / up, rates.down / (cells * sizeof(Complex32)));
}

Rates measured_rates() {
  constexpr std::size_t kBytes = std::size_t{1} << 30;
  CudaQueue queue(0);
  void* a = queue.allocate(kBytes);
  void* b = queue.allocate(kBytes);
  void* pinned = queue.host_memory()->allocate(kBytes);
  const auto rate = [&](void* to, const void* from, cudaMemcpyKind kind, double passes) {
    const double s = seconds_of(
        [&] {
          check_cuda(cudaMemcpy(to, from, kBytes, kind), "copying");
          check_cuda(cudaDeviceSynchronize(), "waiting");
        },
        5);
    return passes * kBytes / s;
  };
  // Two streams, as the backend uses: one alone carries three quarters of that.
  CudaQueue other(0);
  const auto down = [&] {
    queue.download(pinned, a, kBytes / 2);
    other.download(static_cast<char*>(pinned) + kBytes / 2, b, kBytes / 2);
    queue.wait();
    other.wait();
  };
  Rates rates{rate(a, b, cudaMemcpyDeviceToDevice, 2), rate(a, pinned, cudaMemcpyHostToDevice, 1),
              kBytes / seconds_of(down, 5), 0};
  queue.host_memory()->deallocate(pinned, kBytes);
  queue.release(a);
  queue.release(b);
  int khz = 0, processors = 0;
  check_cuda(cudaDeviceGetAttribute(&khz, cudaDevAttrClockRate, 0), "querying the clock rate");
  check_cuda(cudaDeviceGetAttribute(&processors, cudaDevAttrMultiProcessorCount, 0), "asking");
  rates.fma = 1e3 * khz * processors * 128;  // 128 lanes from compute capability 8.6 on
  return rates;
}

int run() {
  cudaDeviceProp device{};
  if (const cudaError_t error = cudaGetDeviceProperties(&device, 0); error != cudaSuccess) {
    std::printf("skipped: CUDA: %s\n", cudaGetErrorString(error));
    return 5;
  }
  const Workers workers;
  const Rates rates = measured_rates();
  std::printf(
      "device: %s, %.0f GB; memory %.0f GB/s (read and written), bus up %.1f GB/s, "
      "down %.1f GB/s, %.1f T multiply-adds/s\n",
      device.name, device.totalGlobalMem / 1e9, rates.memory / 1e9, rates.up / 1e9,
      rates.down / 1e9, rates.fma / 1e12);
  std::printf(
      "pings/s: on the device, series copied down, levels copied down, cpu backend with %d "
      "threads; bounds of memory, multiply-adds, bus up, bus down\n",
      workers.threads());
  std::printf("%-6s %8s %10s %10s %10s %10s %8s | %10s %10s %10s %10s\n", "case", "echoes",
              "device", "series", "levels", "cpu", "error", "memory", "fma", "up", "down");
  run_case<BeamProgram<CudaQueue>>({"full", 114, 0, 32}, rates, workers);
  run_case<BeamProgram<CudaQueue>>({"dense", 7296, 0, 4}, rates, workers);
  run_case<ArrayProgram<CudaQueue>>({"array", 114, 256, 8}, rates, workers);
  return 0;
}

}  // namespace
}  // namespace ensonify

int main() {
  try {
    return ensonify::run();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 5;
  }
}
