// ensonify_gpu_bench: how fast a device synthesizes, beside the processor and the bounds of memory
// and bus in the same run. Needs neither a world nor a scenario.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "acoustics/propagation.h"
#include "core/random.h"
#include "core/units.h"
#include "synthesis/cuda/array_program.h"
#include "synthesis/cuda/beam_program.h"
#include "synthesis/cuda/cuda_queue.cuh"

namespace ensonify {
namespace {

struct Case {
  const char* name;
  int rays_per_beam, elements;  // 0: sectors
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

// Diffuse echoes all over the record.
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

double relative(const std::vector<std::complex<float>>& a,
                const std::vector<std::complex<float>>& b) {
  double error = 0, norm = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    error += std::norm(std::complex<double>(a[i]) - std::complex<double>(b[i]));
    norm += std::norm(std::complex<double>(b[i]));
  }
  return std::sqrt(error / norm);
}

template <class Program>
void run_case(const Case& c, const Workers& workers) {
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
  CudaQueue queue(0);
  Program program(queue, setup);
  PingBatch batch;
  fill_batch(setup, tasks, workers, batch);
  const std::size_t cells = std::size_t(sonar.beam_count) * setup.record.samples;
  std::vector<std::complex<float>> series(cells * c.pings);
  const auto with_copies = [&] {
    fill_batch(setup, tasks, workers, batch);
    program.run(batch, workers);
    queue.download(series.data(), program.series(), series.size() * sizeof(Complex32));
  };
  with_copies();  // plans and memory
  const double whole_s = seconds_of(with_copies, 5);
  const double device_s = seconds_of(
      [&] {
        program.compute(batch);
        queue.wait();
      },
      5);
  const auto cpu = make_cpu_backend(setup);
  PingSeries expected;
  cpu->synthesize({&tasks[0], 1}, {&expected, 1}, workers);
  const double cpu_s = seconds_of(
      [&] {
        cpu->synthesize({&tasks[0], 1}, {&expected, 1}, workers);
      },
      3);
  series.resize(cells);
  std::printf(
      "%-6s %9zu echoes %4d pings  %9.1f /s on the device  %9.1f /s with copies  %8.2f /s "
      "cpu, %d threads  error %.1e\n",
      c.name, lists[0].size(), c.pings, c.pings / device_s, c.pings / whole_s, 1 / cpu_s,
      workers.threads(), relative(series, expected.pressure_pa));
  const double series_gb = cells * sizeof(Complex32) / 1e9;
  std::printf("       down %.2f MB a ping, up %.2f MB\n", 1e3 * series_gb,
              batch.echoes.size() / double(c.pings) * (sizeof(EchoRecord) + 4) / 1e6);
}

void print_bounds() {
  constexpr std::size_t kBytes = std::size_t{1} << 30;
  CudaQueue queue(0);
  void* a = queue.allocate(kBytes);
  void* b = queue.allocate(kBytes);
  void* pinned = nullptr;
  check_cuda(cudaMallocHost(&pinned, kBytes), "allocating pinned memory");
  const auto rate = [&](void* to, const void* from, cudaMemcpyKind kind, double passes) {
    const double s = seconds_of(
        [&] {
          check_cuda(cudaMemcpy(to, from, kBytes, kind), "copying");
          check_cuda(cudaDeviceSynchronize(), "waiting");
        },
        5);
    return passes * kBytes / s / 1e9;
  };
  std::printf("bounds: memory %.0f GB/s (read and written), bus up %.1f GB/s, down %.1f GB/s\n",
              rate(a, b, cudaMemcpyDeviceToDevice, 2), rate(a, pinned, cudaMemcpyHostToDevice, 1),
              rate(pinned, a, cudaMemcpyDeviceToHost, 1));
  cudaFreeHost(pinned);
  queue.release(a);
  queue.release(b);
}

int run() {
  cudaDeviceProp device{};
  if (const cudaError_t error = cudaGetDeviceProperties(&device, 0); error != cudaSuccess) {
    std::fprintf(stderr, "skipped: CUDA: %s\n", cudaGetErrorString(error));
    return 5;
  }
  std::printf("device: %s, %.0f GB\n", device.name, device.totalGlobalMem / 1e9);
  print_bounds();
  const Workers workers;
  run_case<BeamProgram<CudaQueue>>({"full", 114, 0, 32}, workers);
  run_case<BeamProgram<CudaQueue>>({"dense", 7296, 0, 4}, workers);
  run_case<ArrayProgram<CudaQueue>>({"array", 114, 256, 8}, workers);
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
