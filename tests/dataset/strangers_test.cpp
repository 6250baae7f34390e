// Protects whoever reads a stranger's data set: what its manifests claim is held against its files
// before memory or time goes into it. All hashes are right.
#include <filesystem>
#include <nlohmann/json.hpp>

#include "catch.h"
#include "dataset/damage.h"
#include "dataset/read_dataset.h"
#include "dataset/sample.h"
#include "formats/sha256.h"

using namespace ensonify;
using OrderedJson = nlohmann::ordered_json;
namespace fs = std::filesystem;

namespace {

struct Stranger {
  sample::TemporaryFolder folder;
  fs::path dir = folder.path();

  Stranger() { sample::make_dataset(dir, 1); }

  void seal(const std::string& manifest) const {
    sample::write(dir / "dataset.json", manifest);
    sample::write(dir / "dataset.sha256", sha256_hex(manifest) + "  dataset.json\n");
  }
  template <class Change>
  void change_dataset(Change change) const {
    OrderedJson json = OrderedJson::parse(sample::read(dir / "dataset.json"));
    change(json);
    seal(json.dump());
  }
  template <class Change>
  void change_sequence(Change change) const {
    const fs::path file = dir / "sequences/000000/sequence.json";
    OrderedJson json = OrderedJson::parse(sample::read(file));
    change(json);
    sample::write(file, json.dump());
    change_dataset([&](OrderedJson& dataset) {
      dataset["sequences"][0]["sha256"] = sha256_hex(sample::read(file));
    });
  }
  // What the reader says of it; empty: it reads.
  std::string refusal() const {
    const auto dataset = open_dataset(dir);
    if (!dataset) return dataset.error().message;
    for (const StoredSequenceRow& row : dataset->sequences) {
      const auto sequence = read_sequence(*dataset, row);
      if (!sequence) return sequence.error().message;
    }
    return "";
  }
  bool refuses(const std::string& part) const {
    const std::string said = refusal();
    INFO(said);
    return said.find(part) != std::string::npos;
  }
};

std::string brackets() { return std::string(100'000, '[') + std::string(100'000, ']'); }

}  // namespace

TEST_CASE("a stranger's data set that is in order reads") {
  const Stranger stranger;
  stranger.change_sequence([](OrderedJson&) {});
  CHECK(stranger.refusal().empty());
}

TEST_CASE("nested manifests are refused and told by verify") {
  const Stranger stranger;
  std::string text = sample::read(stranger.dir / "dataset.json");
  text.replace(text.rfind('}'), 1, ",\"more\":" + brackets() + "}");
  stranger.seal(text);
  CHECK(stranger.refuses("dataset.json: is not JSON"));
  CHECK(damage::mentions(damage::faults(stranger.dir), "dataset.json: is not JSON"));
}

TEST_CASE("a nested sequence.json is refused and told by verify") {
  const Stranger stranger;
  const fs::path file = stranger.dir / "sequences/000000/sequence.json";
  std::string text = sample::read(file);
  text.replace(text.rfind('}'), 1, ",\"more\":" + brackets() + "}");
  sample::write(file, text);
  stranger.change_dataset(
      [&](OrderedJson& dataset) { dataset["sequences"][0]["sha256"] = sha256_hex(text); });
  CHECK(stranger.refuses("sequence.json: is not JSON"));
  CHECK(damage::mentions(damage::faults(stranger.dir), "sequence.json: is not JSON"));
}

TEST_CASE("a sequence is listed once") {
  const Stranger stranger;
  stranger.change_dataset([](OrderedJson& dataset) {
    for (int i = 0; i < 1000; ++i) dataset["sequences"].push_back(dataset["sequences"][0]);
  });
  CHECK(stranger.refuses("lists a sequence twice"));
  CHECK(damage::mentions(damage::faults(stranger.dir), "listed twice"));
}

TEST_CASE("pictures are no larger than their files can hold") {
  const Stranger stranger;
  SECTION("polar") {
    stranger.change_sequence([](OrderedJson& json) {
      json["sonar"]["beams"]["count"] = 20'000;
      json["record"]["samples"] = 35'000;
    });
  }
  SECTION("cartesian") {
    stranger.change_sequence([](OrderedJson& json) {
      json["cartesian"]["height_px"] = 16'000;
      json["cartesian"]["width_px"] = 30'000;
    });
  }
  CHECK(stranger.refuses("gives more pixels than its images have"));
}

TEST_CASE("names of files are not multiplied by the pings", "[figure]") {
  const Stranger stranger;
  std::string name(100'000, 'x');
  name += "{ping}";
  stranger.change_sequence([&](OrderedJson& json) {
    json["each_ping"] = OrderedJson::array({name});
    json["pings"] = {0, 40'000};
    json["files"] = OrderedJson::array();
    for (int i = 0; i < 40'000; ++i)
      json["files"].push_back({{"path", "a"}, {"bytes", 0}, {"sha256", ""}});
  });
  stranger.change_dataset([](OrderedJson& dataset) {
    dataset["sequences"][0]["pings"] = {0, 40'000};
  });
  // 4 GB of names, had they been made.
  CHECK_FALSE(damage::faults(stranger.dir).empty());
}
