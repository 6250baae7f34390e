// What `ensonify verify` says of one data set, without the commands.
#pragma once

#include <filesystem>
#include <string>

#include "dataset/verify.h"

namespace ensonify::test {

// Error kind damage with all faults, one a line.
inline Status verified(const std::filesystem::path& folder) {
  const Workers workers(2);
  const Result<VerifyReport> report = verify_dataset(folder, workers);
  if (!report) return report.error();
  std::string text;
  for (const std::string& fault : report->faults) text += fault + "\n";
  if (text.empty()) return {};
  return Error{ErrorKind::damage, text};
}

}  // namespace ensonify::test
