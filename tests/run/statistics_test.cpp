// Ensembles: the moments of a scene's draws, from any threads, blocks and interruptions.
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstring>
#include <thread>

#include "dataset/statistics.h"
#include "ping/pipeline.h"
#include "ping/run_scene.h"
#include "ping/sequence_info.h"
#include "results.h"
#include "run/ensemble.h"
#include "small_data_set.h"

using namespace ensonify;
using namespace ensonify::test;
namespace fs = std::filesystem;

namespace {

// A wall seen askew, a ball and a point target; 21 draws: two blocks of eight and a short one.
constexpr const char* kStudy = R"(ensonify: 1
name: study
seed: 5
sonar:
  preset: paper_table1
  bandwidth_hz: 29900
  range_max_m: 3
  beams: {count: 36, fov_deg: 36}
  rays: {elevation: 16}
materials: {m: {reflectivity: 1e-3}}
objects:
  - {name: room, class: structure, material: m, shape: {box: {size_m: [5, 5, 2], inward_facing: true}}}
  - {name: ball, class: ball, material: m, shape: {sphere: {radius_m: 0.3}}, pose: {position_m: [1.5, 0, 0]}}
point_targets: [{name: p, target_strength_db: -40, position_m: [1, 0.3, 0]}]
trajectory: {ping_rate_hz: 5, pings: 21}
noise: {spectrum_level_db: 40}
output: {statistics: {lags: 3}, pings: false}
)";

struct StudyMaker : Maker {
  StudyMaker() { scenario = folder.write("study.yaml", kStudy); }
  GenerateOptions study(const std::string& output, std::vector<Override> overrides = {}) const {
    GenerateOptions o = options(output);
    o.input.overrides = std::move(overrides);
    return o;
  }
};

std::string name_of(const std::string& array) {
  return "sequences/000000/statistics/" + array + ".npy";
}

template <class T>
std::vector<T> values_of(const std::string& npy) {
  const std::size_t start = npy.find('\n') + 1;
  std::vector<T> values((npy.size() - start) / sizeof(T));
  std::memcpy(values.data(), npy.data() + start, values.size() * sizeof(T));
  return values;
}

std::vector<Series> series_of(const std::map<std::string, std::string>& files) {
  std::vector<Series> all;
  for (const auto& [name, bytes] : files) {
    if (name.find("/timeseries/") != std::string::npos) {
      const auto values = values_of<std::complex<float>>(bytes);
      all.emplace_back(values.begin(), values.end());
    }
  }
  return all;
}

// Stands for a backend that adds realizations.
struct SumsOfBackend final : MomentSums {
  SumsOfBackend(const SequenceInfo& info, const PooledPixels& its_pool)
      : moments(no_moments(info)), pool(its_pool) {}

  std::size_t add(std::span<const PingTask>, const Workers&) override { return 0; }
  void read(Moments& to) override { to = moments; }
  void add_series(SeriesBlock block) {
    add_block(block, moments.count, 0, moments.beams, moments);
    add_pooled(block, pool, 0, moments.beams, moments);
    moments.count += block.size();
  }

  Moments moments;
  const PooledPixels& pool;
};

}  // namespace

// Protects the arrays: they are the moments of the very series that the data set would hold,
// by plain sums in double here. Without files, pings are made in batches and have no records, but
// the tables have the same rows.
TEST_CASE("statistics are those of the pings", "[serial]") {
  const StudyMaker maker;
  std::vector<Override> more;
  SECTION("plain") {}
  SECTION("with a volume and the steps of an ADC") {
    more = {{"volumes", "[{name: murk, class: water, uniform: {strength_db: -60}}]"},
            {"sonar.receiver", "{adc: {bits: 12, full_scale_db: 170}}"}};
  }
  SECTION("with noise that beams share, and electronics") {
    more = {{"noise", "{spectrum_level_db: 40, correlated: true}"},
            {"sonar.electronics", "{crosstalk_db: -40}"}};
  }
  const bool is_plain = more.empty();
  const auto alone = maker.make(maker.study("alone", more));
  more.push_back({"output", "{statistics: {lags: 3}, polar: false, cartesian: false, png: false}"});
  const auto both = maker.make(maker.study("both", more));
  std::size_t tables = 0;
  for (const auto& [name, bytes] : alone) {
    CHECK_FALSE(contains(name, "/timeseries/"));
    const bool is_table =
        name.ends_with(".csv") || name.ends_with(".tum") || name.ends_with("first_return_m.npy");
    tables += is_table;
    INFO(name);
    if (is_table || contains(name, "/statistics/")) CHECK(both.at(name) == bytes);
  }
  CHECK(tables == 6);
  if (!is_plain) return;
  const std::vector<Series> pings = series_of(both);
  REQUIRE(pings.size() == 21);
  const auto azimuths = values_of<double>(both.at("sequences/000000/azimuth_rad.npy"));
  const std::size_t beams = azimuths.size(), samples = pings[0].size() / beams;
  const auto intensity = values_of<double>(both.at(name_of("mean_intensity")));
  const auto variance = values_of<double>(both.at(name_of("intensity_variance")));
  const auto contrast = values_of<double>(both.at(name_of("contrast")));
  const auto fourth = values_of<double>(both.at(name_of("fourth_moment")));
  const auto mean = values_of<std::complex<double>>(both.at(name_of("mean_pressure")));
  const auto bins = values_of<std::complex<double>>(both.at(name_of("bin_covariance")));
  const auto beam_coherence = values_of<std::complex<double>>(both.at(name_of("beam_coherence")));
  REQUIRE(contrast.size() == beams * samples);
  REQUIRE(bins.size() == beams * (samples - 1));
  REQUIRE(beam_coherence.size() == (beams - 1) * samples);
  for (std::size_t j = 0; j + 1 < beams; j += 5) {
    for (std::size_t n = 0; n + 1 < samples; n += 7) {
      std::complex<double> m, next_bin, next_beam, c_bin, c_beam;
      double power = 0, power2 = 0, here2 = 0, beam2 = 0;
      for (const Series& p : pings) {
        const std::complex<double> a = p[j * samples + n], b = p[j * samples + n + 1],
                                   c = p[(j + 1) * samples + n];
        m += a / 21.0;
        next_bin += b / 21.0;
        next_beam += c / 21.0;
        c_bin += b * std::conj(a);
        c_beam += c * std::conj(a);
        power += std::norm(a) / 21;
        power2 += std::norm(a) * std::norm(a) / 21;
        here2 += std::norm(a);
        beam2 += std::norm(c);
      }
      INFO("beam " << j << " sample " << n);
      const std::size_t at = n * beams + j;
      const double spread = (power2 - power * power) * 21 / 20;
      CHECK(std::abs(mean[at] - m) < 1e-9 * std::sqrt(power));
      CHECK(intensity[at] == Approx(power).epsilon(1e-9));
      CHECK(variance[at] == Approx(spread).epsilon(1e-7));
      CHECK(contrast[at] == Approx(std::sqrt(spread) / power).epsilon(1e-7));
      CHECK(fourth[at] == Approx(power2 / (power * power)).epsilon(1e-9));
      const auto cov = (c_bin - 21.0 * next_bin * std::conj(m)) / 20.0;
      CHECK(std::abs(bins[at] - cov) < 1e-6 * here2 / 20);
      const double spreads =
          std::sqrt((here2 - 21 * std::norm(m)) * (beam2 - 21 * std::norm(next_beam)));
      const auto coherence = (c_beam - 21.0 * next_beam * std::conj(m)) / spreads;
      CHECK(std::abs(beam_coherence[n * (beams - 1) + j] - coherence) < 1e-6);
    }
  }
}

// Protects "the same bytes whatever the threads", and ranges that do not begin at 0 with whole data
// sets of their own.
TEST_CASE("statistics are the same for any threads") {
  const StudyMaker maker;
  GenerateOptions range = maker.study("range");
  range.pings = {3, 20};
  const auto expected = maker.make(maker.study("two"));
  const auto expected_range = maker.make(range);
  CHECK(contains(expected_range.at("sequences/000000/sequence.json"), "\"realisations\": 17"));
  CHECK(expected.at(name_of("contrast")) != expected_range.at(name_of("contrast")));
  for (const int threads : {1, 5}) {
    GenerateOptions options = maker.study("threads" + std::to_string(threads));
    options.threads = threads;
    CHECK(maker.make(options) == expected);
    range.output = maker.folder.path() / ("range" + std::to_string(threads));
    range.threads = threads;
    CHECK(maker.make(range) == expected_range);
  }
}

// Protects several ensembles at once: as many as there are sequences, each with draws of its own.
TEST_CASE("every sequence is an ensemble") {
  const StudyMaker maker;
  const auto three =
      maker.make(maker.study("three", {{"sequences", "3"}, {"trajectory.pings", "9"}}));
  GenerateOptions last = maker.study("last", {{"sequences", "3"}, {"trajectory.pings", "9"}});
  last.sequences = {2, 3};
  last.threads = 1;
  const std::string name = "sequences/000002/statistics/contrast.npy";
  CHECK(maker.make(last).at(name) == three.at(name));
  CHECK(three.at(name) != three.at(name_of("contrast")));
}

// Protects continued runs: a checkpoint of one block, by hand, then the program; and a checkpoint
// with a flipped bit, of other work or cut short, which must be done again and not be believed.
TEST_CASE("statistics go on from a checkpoint, and from none that is damaged", "[serial]") {
  const StudyMaker maker;
  const auto expected = maker.make(maker.study("whole"));
  const SceneRun scene = SceneRun::of_text(kStudy);
  const SequenceInfo info = sequence_info(scene.session(), 0, 0, 21);
  const PooledPixels pool = pool_of(scene.expected_pa2(), 20);
  const GenerateOptions options = maker.study("continued");
  const fs::path checkpoint = options.output / ".work/sequences/000000/moments.bin";
  const auto begin = [&] {
    fs::remove_all(options.output);
    Ensemble ensemble(options.output, info, pool);
    REQUIRE(ensemble.blocks_done() == 0);
    std::vector<Series> block;
    for (std::uint32_t ping = 0; ping < kMomentBlock; ++ping) {
      block.push_back(scene.ping(ping).series);
    }
    REQUIRE(ensemble.add(0, block).ok());
    REQUIRE(ensemble.save().ok());
    const auto loaded = value_of(load_moments(options.output, info));
    CHECK(loaded.count == kMomentBlock);
    CHECK(loaded.values == ensemble.moments().values);
  };
  begin();
  // The work's own mark, without which the folder would be a stranger's.
  std::ofstream(options.output / "work.json", std::ios::binary) << expected.at("work.json");
  CHECK(maker.make(options) == expected);

  const auto damage = [&](std::uint64_t at, char with) {
    std::fstream file(checkpoint, std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(static_cast<std::streamoff>(at));
    file.put(with);
  };
  begin();
  const std::uint64_t size = fs::file_size(checkpoint);
  SequenceInfo other = info;
  other.first_ping = 8;
  CHECK_FALSE(load_moments(options.output, other));
  damage(5000, '\x55');  // a value
  CHECK_FALSE(load_moments(options.output, info));
  begin();
  damage(size < 200 ? 0 : 70, '9');  // the count
  CHECK_FALSE(load_moments(options.output, info));
  begin();
  fs::resize_file(checkpoint, size - 8);
  CHECK_FALSE(load_moments(options.output, info));
}

// Protects what a kill leaves: checkpoints are written on the way too, by whoever's block it is,
// and hold whole blocks, however many threads add and in whatever order they come.
TEST_CASE("checkpoints on the way hold whole blocks in their order") {
  const SceneRun scene = SceneRun::of_text(kStudy);
  const SequenceInfo info = sequence_info(scene.session(), 0, 0, 21);
  std::vector<std::vector<Series>> blocks(3);
  for (std::uint32_t ping = 0; ping < 21; ++ping) {
    blocks[ping / kMomentBlock].push_back(scene.ping(ping).series);
  }
  const TemporaryFolder folder;
  const PooledPixels pool = pool_of(scene.expected_pa2(), 20);
  Ensemble one(folder.path() / "one", info, pool), many(folder.path() / "many", info, pool, {});
  REQUIRE(one.block_count() == 3);
  for (std::uint32_t b = 0; b < 3; ++b) REQUIRE(one.add(b, blocks[b]).ok());
  CHECK_FALSE(load_moments(folder.path() / "one", info));
  {
    std::vector<std::jthread> lanes;
    for (const std::uint32_t b : {2u, 1u, 0u}) {
      lanes.emplace_back([&, b] { static_cast<void>(many.add(b, blocks[b])); });
    }
  }
  CHECK(many.moments().count == 21);
  CHECK(many.moments().values == one.moments().values);
  // That of one block or of another, whichever got its name last.
  const auto loaded = value_of(load_moments(folder.path() / "many", info));
  CHECK((loaded.count == 8 || loaded.count == 16 || loaded.count == 21));

  Ensemble stopped(folder.path() / "stopped", info, pool);
  REQUIRE(stopped.add(0, blocks[0]).ok());
  std::jthread waiting([&] { static_cast<void>(stopped.add(2, blocks[2])); });
  stopped.give_up();
  waiting.join();
  CHECK(stopped.moments().count == kMomentBlock);
  REQUIRE(stopped.save().ok());
  CHECK(Ensemble(folder.path() / "stopped", info, pool).blocks_done() == 1);
}

// Protects ensembles whose series stay with a backend: checkpoints on the way, interrupts, and a
// backend that runs out of memory end in the moments of blocks that come one by one.
TEST_CASE("an ensemble follows a backend that adds realizations") {
  const SceneRun scene = SceneRun::of_text(kStudy);
  SequenceInfo info = sequence_info(scene.session(), 0, 0, 21);
  info.last_ping = 77;
  const std::vector<Series> series = {scene.ping(0).series, scene.ping(1).series,
                                      scene.ping(2).series};
  const auto block_at = [&](std::uint32_t first, std::uint32_t last) {
    std::vector<Series> block;
    for (; first < last; ++first) block.push_back(series[first % 3]);
    return block;
  };
  const TemporaryFolder folder;
  const PooledPixels pool = pool_of(scene.expected_pa2(), 20);
  Ensemble expected(folder.path() / "expected", info, pool);
  const auto add_from = [&](std::uint32_t block, Ensemble& ensemble) {
    for (; block < ensemble.block_count(); ++block) {
      const PingRange pings = ensemble.block_pings(block);
      REQUIRE(ensemble.add(block, block_at(pings.first, pings.second)).ok());
    }
  };
  add_from(0, expected);
  SumsOfBackend sums(info, pool);
  const auto make = [&](PingRange pings, std::uint32_t most) {
    const std::uint32_t last = std::min(pings.second, pings.first + most);
    for (std::uint32_t first = pings.first; first < last; first += kMomentBlock) {
      sums.add_series(block_at(first, std::min(first + kMomentBlock, last)));
    }
    return last - pings.first;
  };
  Ensemble ensemble(folder.path() / "followed", info, pool, {});
  SECTION("to its end") {
    REQUIRE(ensemble
                .follow(sums,
                        [&](PingRange pings) -> Result<std::uint32_t> {
                          const auto kept = load_moments(folder.path() / "followed", info);
                          CHECK((kept ? kept->count : 0) == pings.first);
                          return make(pings, 64);
                        })
                .ok());
    CHECK(ensemble.blocks_done() == ensemble.block_count());
  }
  SECTION("to an interrupt") {
    const Status status = ensemble.follow(sums, [&](PingRange pings) -> Result<std::uint32_t> {
      if (pings.first > 0) return Error{ErrorKind::interrupted, "stop"};
      return make(pings, 64);
    });
    CHECK(status.error().kind == ErrorKind::interrupted);
    REQUIRE(ensemble.save().ok());
    REQUIRE(Ensemble(folder.path() / "followed", info, pool).blocks_done() == 8);
    add_from(8, ensemble);
  }
  SECTION("to the end of its memory") {
    REQUIRE(
        ensemble
            .follow(sums, [&](PingRange pings) -> Result<std::uint32_t> { return make(pings, 40); })
            .ok());
    REQUIRE(ensemble.blocks_done() == 5);
    add_from(5, ensemble);
  }
  CHECK(ensemble.moments().count == 77);
  CHECK(ensemble.moments().values == expected.moments().values);
}

// Protects the speed of studies, and their bytes: what is traced once is what each ping would
// trace.
TEST_CASE("shared echoes give the pings that are made without", "[serial]") {
  const SceneRun study = SceneRun::of_text(kStudy);
  std::string text = kStudy;
  const std::string output = "output: {statistics: {lags: 3}, pings: false}";
  text.replace(text.find(output), output.size(), "output: {points: true}");
  const SceneRun plain = SceneRun::of_text(text);
  for (const std::uint32_t ping : {0u, 7u}) {
    const PingResult a = study.ping(ping), b = plain.ping(ping);
    CHECK(a.series == b.series);
    CHECK_FALSE(a.polar);
    CHECK(a.scatterers.size() == 0);
    CHECK(b.scatterers.size() > 0);
    REQUIRE(a.first_return_m.size() == b.first_return_m.size());
    CHECK(std::memcmp(a.first_return_m.data(), b.first_return_m.data(),
                      a.first_return_m.size() * sizeof(float)) == 0);
  }
}

// Protects the meaning of realisations: draws of one scene, or a word about why not.
TEST_CASE("pings that are no draws of one scene are refused", "[serial]") {
  const StudyMaker maker;
  const auto refusal = [&](std::vector<Override> overrides) {
    const GenerateOptions options = maker.study("none", std::move(overrides));
    const Status status = generate(options);
    REQUIRE_FALSE(status.ok());
    CHECK(status.error().kind == ErrorKind::usage);
    CHECK_FALSE(fs::exists(options.output));
    return status.error().message;
  };
  const std::string path =
      "{poses: [{time_s: 0}, {time_s: 9, position_m: [0.1, 0, 0]}], "
      "ping_rate_hz: 5, pings: 3}";
  CHECK(contains(refusal({{"trajectory", path}}), "at ping 1 the sonar has moved"));
  CHECK(contains(refusal({{"scattering.speckle", "per_ray"}}), "speckle per_ping"));
  CHECK(contains(refusal({{"scattering.speckle", "surface"}}), "speckle per_ping"));
  const std::string still =
      "{poses: [{time_s: 0, position_m: [0.1, 0.2, 0.1]}, {time_s: 9, "
      "position_m: [0.1, 0.2, 0.1]}], ping_rate_hz: 5, pings: 3}";
  CHECK_FALSE(maker.make(maker.study("still", {{"trajectory", still}})).empty());
}

// Protects readers from arrays that changed: each is hashed and has the shape that is said of it.
TEST_CASE("verify notices damaged statistics", "[serial]") {
  const StudyMaker maker;
  const GenerateOptions options = maker.study("out", {{"trajectory.pings", "2"}});
  maker.make(options);
  const fs::path array = options.output / name_of("contrast");
  const fs::path copy = options.output.parent_path() / "copy.npy";
  fs::rename(array, copy);
  CHECK_FALSE(verified(options.output).ok());  // missing
  fs::copy_file(options.output / name_of("fourth_moment"), array);
  CHECK_FALSE(verified(options.output).ok());  // another
  fs::copy_file(copy, array, fs::copy_options::overwrite_existing);
  REQUIRE(verified(options.output).ok());
  fs::copy_file(copy, options.output / name_of("more"));
  CHECK_FALSE(verified(options.output).ok());  // unlisted
}
