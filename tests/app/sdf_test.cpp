// The scene's distance field as a file of the data set.
#include "app/cost.h"
#include "app/session.h"
#include "small_data_set.h"

using namespace ensonify;
using namespace ensonify::test;

namespace {

constexpr const char* kSdf = "sequences/000000/sdf.vdb";

GenerateOptions with_sdf(const Maker& maker, const std::string& output) {
  GenerateOptions o = maker.options(output);
  o.input.overrides.push_back({"output.sdf.voxel_m", "0.1"});
  return o;
}

}  // namespace

// Protects the ground truth's place in the data set: listed, checked, the same bytes for any
// number of threads, counted.
TEST_CASE("the distance field is a file of its sequence") {
  const Maker maker;
  GenerateOptions one = with_sdf(maker, "one");
  one.threads = 1;
  const auto files = maker.make(with_sdf(maker, "two"));
  REQUIRE(files.contains(kSdf));
  CHECK(maker.make(one) == files);
  CHECK(files.at("sequences/000000/sequence.json").find("\"path\":\"sdf.vdb\"") !=
        std::string::npos);
  CHECK(files.at("README.md").find("sdf.vdb") != std::string::npos);
  auto scenario = load_scenario(maker.scenario, with_sdf(maker, "").input.overrides);
  REQUIRE(scenario.ok());
  const auto session = prepare_session(std::move(*scenario), 0);
  REQUIRE(session.ok());
  // provenance.json is not among the files read.
  CHECK(estimate_cost(*session, 2).files == files.size() + 1);

  const auto plain = maker.make(maker.options("plain"));
  CHECK_FALSE(plain.contains(kSdf));
  CHECK(plain.size() + 1 == files.size());
}

TEST_CASE("a damaged distance field is found") {
  const Maker maker;
  const GenerateOptions o = with_sdf(maker, "a");
  maker.make(o);
  std::ofstream(o.output / kSdf, std::ios::binary) << "no grid";
  CHECK_FALSE(verify(o.output, 2).ok());
}

TEST_CASE("a distance field too large is refused before anything is written") {
  const Maker maker;
  GenerateOptions o = maker.options("a");
  o.input.overrides.push_back({"output.sdf.voxel_m", "0.00001"});
  const Status made = generate(o);
  REQUIRE_FALSE(made.ok());
  CHECK(made.error().kind == ErrorKind::usage);
  CHECK(made.error().message.starts_with("output.sdf.voxel_m: "));
  CHECK_FALSE(std::filesystem::exists(o.output));
}
