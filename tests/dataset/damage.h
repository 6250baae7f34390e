// Damage to a data set, and what verify says of it.
//
//   faults  mentions      of a folder
//   edit                  a text in a file
//   forge  reseal         changes whose hashes are put right again
#pragma once

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "catch.h"
#include "dataset/sample.h"
#include "dataset/verify.h"
#include "formats/sha256.h"
#include "results.h"

namespace ensonify::damage {

namespace fs = std::filesystem;

inline std::vector<std::string> faults(const fs::path& dir) {
  return value_of(verify_dataset(dir, Workers(2))).faults;
}

inline bool mentions(const std::vector<std::string>& faults, const std::string& text) {
  return std::any_of(faults.begin(), faults.end(), [&](const std::string& fault) {
    return fault.find(text) != std::string::npos;
  });
}

inline void edit(const fs::path& file, const std::string& from, const std::string& to) {
  std::string text = sample::read(file);
  const auto at = text.find(from);
  REQUIRE(at != std::string::npos);
  sample::write(file, text.replace(at, from.size(), to));
}

// Puts the hash of a changed file into its manifest, and so on up to the seal: what is left is the
// fault that only a look inside the file can find.
inline void forge(const fs::path& dir, const std::string& name, const std::string& bytes) {
  const fs::path sequence = dir / "sequences/000000/sequence.json";
  const fs::path file = dir / "sequences/000000" / name;
  const std::string old = sample::read(file);
  const auto line = [&](const std::string& content) {
    return "\"path\":\"" + name + "\",\"bytes\":" + std::to_string(content.size()) +
           ",\"sha256\":\"" + sha256_hex(content) + "\"";
  };
  const auto total = [](const std::string& text) {
    const auto at = text.find("\"bytes\": ") + 9;
    return text.substr(at, text.find(',', at) - at);
  };
  const std::string before = sample::read(sequence);
  sample::write(file, bytes);
  edit(sequence, line(old), line(bytes));
  edit(sequence, "\"bytes\": " + total(before),
       "\"bytes\": " + std::to_string(std::stoull(total(before)) + bytes.size() - old.size()));
  edit(dir / "dataset.json", sha256_hex(before), sha256_hex(sample::read(sequence)));
  sample::write(dir / "dataset.sha256",
                sha256_hex(sample::read(dir / "dataset.json")) + "  dataset.json\n");
}

inline void reseal(const fs::path& dir, const std::string& name, const std::string& from,
                   const std::string& to) {
  const std::string before = sample::read(dir / name);
  edit(dir / name, from, to);
  const std::string after = sample::read(dir / name);
  if (name != "dataset.json") edit(dir / "dataset.json", sha256_hex(before), sha256_hex(after));
  sample::write(dir / "dataset.sha256",
                sha256_hex(sample::read(dir / "dataset.json")) + "  dataset.json\n");
}

}  // namespace ensonify::damage
