#include <algorithm>
#include <array>

#include "bench/cases.h"
#include "catch.h"
#include "core/units.h"
#include "trace/tracer.h"

using namespace ensonify;

// Protects what the figures stand for: the numbers of the cases as they are published.
TEST_CASE("the cases are the paper's") {
  const std::vector<BenchCase> cases = bench_cases();
  REQUIRE(cases.size() == 5);
  const auto record = [](const BenchCase& c) { return make_record(c.sonar, c.water, 0); };
  CHECK(record(cases[0]).samples == 2392);
  CHECK(record(cases[0]).transform == 2500);
  CHECK(record(cases[1]).samples == 236);
  CHECK(record(cases[2]).samples == 399);
  CHECK(make_fan(cases[0].sonar).size() == 58368);
  CHECK(make_fan(cases[1].sonar).size() == 58368);
  CHECK(make_fan(cases[2].sonar).size() == 5632);
  CHECK(make_fan(cases[3].sonar).size() == 3735552);
  CHECK(record(cases[4]).samples == 2392);
  CHECK(make_fan(cases[4].sonar).size() == 58368);
  REQUIRE(cases[4].sonar.array);
  CHECK(cases[4].sonar.array->elements == 256);
  CHECK(cases[4].sonar.array->focus == Focus::dynamic);
}

// Protects the figures from an easy world: nearly all rays meet something, in all of the record.
TEST_CASE("echoes come from all of the record at any range") {
  for (const int c : {0, 2}) {
    Sonar sonar = bench_cases()[c].sonar;
    const World world = make_bench_world(sonar.range_max_m);
    CHECK(std::get<MeshShape>(world.objects.front().shape).mesh->triangles.size() > 100'000);
    const Tracer tracer(world);
    sonar.beam_count = 64;
    sonar.beam_spacing_rad = radians(90) / 64;
    sonar.rays_elevation = 114;
    const auto hits =
        tracer.trace_fan(make_fan(sonar), bench_pose(), sonar.range_max_m, Workers(2));
    std::array<int, 10> in_tenth{};
    std::vector<bool> met(world.instances.size() + 1);
    int found = 0;
    for (const Hit& hit : hits) {
      met[hit.instance] = true;
      if (hit.instance == 0) continue;
      ++found;
      ++in_tenth[std::min(9, static_cast<int>(10 * hit.range_m / sonar.range_max_m))];
    }
    CHECK(found > 0.9 * static_cast<double>(hits.size()));
    // None can lie closer than the floor under the sonar.
    for (int tenth = 1; tenth < 10; ++tenth)
      CHECK(in_tenth[tenth] > static_cast<int>(hits.size()) / 20);
    for (std::size_t id = 1; id < met.size(); ++id) CHECK(met[id]);
  }
}
