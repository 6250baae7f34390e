// A data set from a stranger: its JSON and CSV files, cut from the input at zero bytes, read as the
// reader of finished data sets reads them. Hashes are put right first: 64 stars in dataset.json
// stand for that of sequence.json.
#include <array>
#include <string>

#include "dataset/read_dataset.h"
#include "formats/sha256.h"
#include "fuzz_file.h"

using namespace ensonify;

namespace {

constexpr std::array kFiles = {
    "sequences/000000/sequence.json",
    "sequences/000000/annotations.jsonl",
    "sequences/000000/poses.csv",
    "sequences/000000/objects.csv",
};

std::string_view next_part(std::string_view& rest) {
  const std::string_view part = rest.substr(0, rest.find('\0'));
  rest.remove_prefix(std::min(rest.size(), part.size() + 1));
  return part;
}

void write_sealed(std::string manifest, std::string_view sequence_json) {
  const std::string stars(64, '*');
  if (const std::size_t at = manifest.find(stars); at != std::string::npos) {
    manifest.replace(at, stars.size(), sha256_hex(sequence_json));
  }
  test::fuzz_file("dataset.json", manifest);
  test::fuzz_file("dataset.sha256", sha256_hex(manifest) + "  dataset.json\n");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::string_view rest = test::text_of(data, size);
  const std::string manifest(next_part(rest));
  write_sealed(manifest, rest.substr(0, rest.find('\0')));
  for (const char* name : kFiles) test::fuzz_file(name, next_part(rest));
  const auto dataset = open_dataset(test::fuzz_folder());
  if (!dataset) return 0;
  for (const StoredSequenceRow& row : dataset->sequences) {
    const auto sequence = read_sequence(*dataset, row);
    if (!sequence) return 0;
    const Status read = for_each_ping(*dataset, *sequence, [&](const StoredPing& ping) -> Status {
      const auto pictures = pictures_of(*dataset, *sequence, ping);
      if (!pictures) return pictures.error();
      return {};
    });
    if (!read) return 0;
  }
  test::accepted();
  return 0;
}
