// What happens around a device's sums: what comes down, several lanes, too little memory, a device
// that is lost. The device is the host.
#include <atomic>
#include <functional>
#include <memory_resource>
#include <new>
#include <optional>
#include <string>
#include <utility>

#include "core/units.h"
#include "synthesis/adc.h"
#include "synthesis/cuda_backend.h"
#include "synthesis/device_fixture.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

using Device = DeviceBackend<HostQueue>;
constexpr int kLanes = 8;

Sonar sonar_of_few() { return p900(kLanes, kLanes, 2); }

std::vector<ScattererList> lists_of(const Sonar& sonar, int pings) {
  std::vector<ScattererList> lists;
  for (int p = 0; p < pings; ++p) {
    lists.push_back(sorted_by_beam_and_delay(random_scatterers(sonar, 60, 0.2, p), kLanes));
  }
  return lists;
}

// Every ping asked for by a thread of its own. How many calls failed.
int ask_all_at_once(const Backend& backend, const std::vector<ScattererList>& lists,
                    std::vector<PingSeries>& series) {
  std::atomic<int> failed = 0;
  Workers(static_cast<int>(lists.size())).for_each(lists.size(), [&](std::size_t p) {
    const PingTask task{&lists[p], keys_of_ping(static_cast<std::uint32_t>(p)), 1e-3, {}};
    try {
      backend.synthesize({&task, 1}, {&series[p], 1}, Workers(1));
    } catch (const DeviceFailure&) {
      ++failed;
    }
  });
  return failed;
}

}  // namespace

// Protects pictures without series: half as much comes down, and it is the series' own level.
TEST_CASE("device: levels in place of series are the levels of the series") {
  const Sonar sonar = sonar_of_few();
  const SynthesisSetup setup = setup_of(sonar);
  const auto lists = lists_of(sonar, 1);
  PingTask task{&lists[0], keys_of_ping(1), 1e-3, {}};
  const PingSeries whole = one(Device(queues_from(new HostQueue()), setup), task);
  task.only_level = true;
  auto* queue = new HostQueue();
  const Device device(queues_from(queue), setup);
  const PingSeries picture = one(device, task);
  CHECK(picture.pressure_pa.empty());
  CHECK(picture.clean_power_pa2 == whole.clean_power_pa2);
  const int samples = setup.record.samples;
  CHECK(queue->downloaded_bytes == 2 * sizeof(float) * kLanes * samples);
  REQUIRE(picture.level_db.size() == whole.pressure_pa.size());
  for (int n = 0; n < samples; ++n) {
    for (int j = 0; j < kLanes; ++j) {
      const std::complex<float> p = whole.pressure_pa[j * samples + n];
      const float level = image_level_db(p.real() * p.real() + p.imag() * p.imag());
      REQUIRE(picture.level_db[n * kLanes + j] == Approx(level).margin(1e-4));
    }
  }
}

TEST_CASE("device: the converter is quantise, before levels are made") {
  Sonar sonar = sonar_of_few();
  sonar.adc = Adc{6, 150};
  const SynthesisSetup setup = setup_of(sonar);
  const auto lists = lists_of(sonar, 1);
  PingTask task{&lists[0], keys_of_ping(1), 1e-3, {}};
  const Device device(queues_from(new HostQueue()), setup);
  PingSeries expected = one(device, task);
  const auto unconverted = expected.pressure_pa;
  quantise(*sonar.adc, expected.pressure_pa);
  CHECK(expected.pressure_pa != unconverted);
  task.converts = true;
  CHECK(one(device, task).pressure_pa == expected.pressure_pa);
  task.only_level = true;
  const PingSeries picture = one(device, task);
  const std::complex<float> first = expected.pressure_pa[0];
  CHECK(picture.level_db[0] ==
        Approx(image_level_db(first.real() * first.real() + first.imag() * first.imag())));
}

// Protects mixed batches: each ping gets what it asked for, and nothing else.
TEST_CASE("device: pings of one batch may ask for different things") {
  const Sonar sonar = sonar_of_few();
  const SynthesisSetup setup = setup_of(sonar);
  const auto lists = lists_of(sonar, 4);
  std::vector<PingTask> tasks;
  for (int p = 0; p < 4; ++p) {
    tasks.push_back({&lists[p], keys_of_ping(p), 1e-3, {}, p % 2 == 0});
    tasks[p].only_level = p >= 2;
  }
  const Device device(queues_from(new HostQueue()), setup);
  std::vector<PingSeries> together(4);
  device.synthesize(tasks, together, Workers(2));
  for (int p = 0; p < 4; ++p) {
    CAPTURE(p);
    const PingSeries alone = one(device, tasks[p]);
    CHECK(together[p].pressure_pa == alone.pressure_pa);
    CHECK(together[p].level_db == alone.level_db);
    CHECK(together[p].clean_power_pa2 == alone.clean_power_pa2);
    CHECK(together[p].pressure_pa.empty() == (p >= 2));
    CHECK(together[p].level_db.empty() == (p < 2));
    CHECK(together[p].clean_power_pa2.empty() == (p % 2 == 1));
  }
}

// Protects a run on a device that others use too: what the second lane cannot have, the first does.
TEST_CASE("device: a lane without memory leaves its pings to the other") {
  const Sonar sonar = sonar_of_few();
  const SynthesisSetup setup = setup_of(sonar);
  const auto lists = lists_of(sonar, 24);
  const Device whole(queues_from(new HostQueue()), setup);
  // Less than the tables, and less than a ping beside them.
  for (const std::size_t limit : {std::size_t(100), std::size_t(1) << 17}) {
    CAPTURE(limit);
    std::atomic<int> made = 0;
    const Device device(
        [&] { return std::make_unique<HostQueue>(made++ == 0 ? std::size_t{1} << 40 : limit); },
        setup);
    std::vector<PingSeries> series(lists.size());
    CHECK(ask_all_at_once(device, lists, series) == 0);
    for (std::size_t p = 0; p < lists.size(); ++p) {
      const PingTask task{&lists[p], keys_of_ping(static_cast<std::uint32_t>(p)), 1e-3, {}};
      CHECK(one(whole, task).pressure_pa == series[p].pressure_pa);
    }
  }
}

// Protects series that outlive what made them, and that pings own their memory: no ping reads what
// another one writes.
TEST_CASE("device: results outlive the backend, and their memory serves the next pings") {
  const Sonar sonar = sonar_of_few();
  const SynthesisSetup setup = setup_of(sonar);
  const auto lists = lists_of(sonar, 3);
  const auto task_of = [&](std::uint32_t p) {
    return PingTask{&lists[p], keys_of_ping(p), 1e-3, {}};
  };
  auto device = std::make_unique<Device>(queues_from(new HostQueue()), setup);
  const PingSeries first = one(*device, task_of(0));
  PingSeries second = one(*device, task_of(1));
  const Series copy = second.pressure_pa;
  CHECK(copy.get_allocator().source() == nullptr);
  const auto* memory = second.pressure_pa.data();
  const auto pool = second.pressure_pa.get_allocator().source();
  REQUIRE(pool != nullptr);
  // Moved without a copy, as into a PingResult, and given back when that goes.
  {
    const Series owner = std::move(second.pressure_pa);
    CHECK(owner.data() == memory);
    CHECK(owner == copy);
  }
  PingSeries third = one(*device, task_of(2));
  CHECK(third.pressure_pa.data() == memory);
  one(*device, task_of(1));
  const PingSeries again = one(*make_cpu_backend(setup), task_of(0));
  device.reset();
  CHECK(relative(first.pressure_pa, again.pressure_pa) < 1e-4);
  // Memory of a device may come to a backend of the processor, as after a device was lost.
  const auto cpu = make_cpu_backend(setup);
  const PingTask task = task_of(1);
  cpu->synthesize({&task, 1}, {&third, 1}, Workers(2));
  CHECK(same_bytes(third, one(*cpu, task)));
}

// Protects devices that report more memory than they give: batches shrink, once for all.
TEST_CASE("device: a size of batches that did not fit is not tried again") {
  const Sonar sonar = sonar_of_few();
  const SynthesisSetup setup = setup_of(sonar);
  const auto lists = lists_of(sonar, 7);
  std::vector<PingTask> tasks;
  for (std::uint32_t p = 0; p < 7; ++p) tasks.push_back({&lists[p], keys_of_ping(p), 1e-3, {}});
  auto* measured = new HostQueue();
  const Device alone(queues_from(measured), setup);
  const PingSeries last = one(alone, tasks[6]);
  auto* queue = new HostQueue(2 * measured->peak);
  const Device device(queues_from(queue), setup);
  std::vector<PingSeries> series(7);
  device.synthesize(tasks, series, Workers(2));
  const int refused = queue->refused;
  CHECK(refused > 0);
  device.synthesize(tasks, series, Workers(2));
  CHECK(queue->refused == refused);
  CHECK(same_bytes(series[6], last));
}

// Protects users who collect many pings and drop them: what a batch needs stays, the rest goes.
TEST_CASE("device: the pool keeps what a batch needs") {
  struct Counted final : std::pmr::memory_resource {
    std::size_t bytes = 0;
    void* do_allocate(std::size_t count, std::size_t alignment) override {
      bytes += count;
      return std::pmr::new_delete_resource()->allocate(count, alignment);
    }
    void do_deallocate(void* memory, std::size_t count, std::size_t alignment) override {
      bytes -= count;
      std::pmr::new_delete_resource()->deallocate(memory, count, alignment);
    }
    bool do_is_equal(const memory_resource& other) const noexcept override {
      return this == &other;
    }
  } source;
  auto pool = std::make_shared<ResultPool>(&source);
  pool->keep(2 * sizeof(float) * 1000);
  {
    std::vector<SampleArray<float>> held;
    for (int i = 0; i < 5; ++i) held.emplace_back(1000, SampleAllocator<float>(pool));
    CHECK(source.bytes == 5 * sizeof(float) * 1000);
  }
  CHECK(source.bytes == 2 * sizeof(float) * 1000);
  std::optional<SampleArray<float>> last(std::in_place, 1000, SampleAllocator<float>(pool));
  CHECK(source.bytes == 2 * sizeof(float) * 1000);
  pool.reset();
  CHECK(source.bytes == 2 * sizeof(float) * 1000);
  last.reset();
  CHECK(source.bytes == 0);
}

// Protects runs on several devices: the next request goes to a device that is not at work, each is
// made when it is needed, and one that fails is left out. The sums of an ensemble keep their device
// at work.
TEST_CASE("device: several devices share the requests") {
  struct FakeSums final : MomentSums {
    std::size_t add(std::span<const PingTask> tasks, const Workers&) override {
      return tasks.size();
    }
    void read(Moments& moments) override { ++moments.count; }
  };
  struct Fake final : Backend {
    std::function<void()> on_request;
    SynthesisMemory memory(bool) const override { return {}; }
    void synthesize(std::span<const PingTask>, std::span<PingSeries>,
                    const Workers&) const override {
      on_request();
    }
    std::unique_ptr<MomentSums> moment_sums(const Moments&, const PooledPixels&) const override {
      return std::make_unique<FakeSums>();
    }
  };
  std::unique_ptr<Backend> shared;
  std::string log;
  int nested = 0;
  std::string lost, lacking;  // devices that fail, and that cannot be made
  std::vector<MakeBackend> makers;
  for (const char name : {'0', '1', '2'}) {
    makers.emplace_back([&, name]() -> std::unique_ptr<Backend> {
      log += name == '0' ? "A" : name == '1' ? "B" : "C";
      if (lacking.find(name) != std::string::npos) throw std::bad_alloc();
      auto device = std::make_unique<Fake>();
      device->on_request = [&, name] {
        log += name;
        if (lost.find(name) != std::string::npos) throw DeviceFailure("lost");
        if (nested-- > 0) shared->synthesize({}, {}, Workers(1));
      };
      return device;
    });
  }
  const auto after = [&](int requests) {
    log.clear();
    nested = requests - 1;
    shared->synthesize({}, {}, Workers(1));
    return log;
  };
  shared = make_shared_backend(makers);
  CHECK(log == "A");
  CHECK(after(1) == "0");
  CHECK(after(4) == "0B1C20");
  CHECK(after(2) == "01");
  Moments moments;
  auto sums = shared->moment_sums(moments, {});
  CHECK(sums->add(std::vector<PingTask>(3), Workers(1)) == 3);
  sums->read(moments);
  CHECK(moments.count == 1);
  CHECK(after(2) == "12");
  sums.reset();
  CHECK(after(1) == "0");
  lost = "1";
  CHECK(after(3) == "0120");
  CHECK(after(2) == "02");
  lost = "012";
  CHECK_THROWS_AS(after(1), DeviceFailure);
  lost.clear();
  CHECK(after(1) == "2");
  lacking = "1";
  shared = make_shared_backend(makers);
  CHECK(after(3) == "0BC20");
}

// Protects what decides before a run whether the device has room for it.
TEST_CASE("device: the memory that a ping misses is what it takes") {
  const Sonar sonar = sonar_of_few();
  const SynthesisSetup setup = setup_of(sonar);
  const auto lists = lists_of(sonar, 1);
  const PingTask task{&lists[0], keys_of_ping(0), 1e-3, {}};
  auto* queue = new HostQueue();
  const Device device(queues_from(queue), setup);
  const std::size_t tables = queue->held_bytes();
  one(device, task);
  const std::size_t taken = queue->peak - tables;
  const Device full(queues_from(new HostQueue(std::size_t{1} << 40, 0)), setup);
  const std::uint64_t missing = full.missing_bytes(lists[0].size(), false);
  CHECK(double(missing) == Approx(double(taken)).epsilon(0.3));
  CHECK(full.missing_bytes(1000 * lists[0].size(), false) > 10 * missing);
  CHECK(device.missing_bytes(1000 * lists[0].size(), false) == 0);
}

// Protects from waiting for ever: whoever waits for a lost device is told, whatever it asked for.
TEST_CASE("device: a lost device is told to all who wait") {
  const Sonar sonar = sonar_of_few();
  const SynthesisSetup setup = setup_of(sonar);
  const auto lists = lists_of(sonar, 12);
  const Device device(
      [] {
        auto queue = std::make_unique<HostQueue>();
        queue->lost_after = 3;
        return queue;
      },
      setup);
  std::vector<PingSeries> series(lists.size());
  CHECK(ask_all_at_once(device, lists, series) == 12);
}
