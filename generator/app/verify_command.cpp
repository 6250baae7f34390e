#include <fmt/format.h>

#include <cstdio>

#include "app/commands.h"
#include "app/print.h"
#include "dataset/verify.h"

namespace ensonify {

Status verify(const std::filesystem::path& folder, int threads) {
  const Workers workers(threads);
  Result<VerifyReport> report = verify_dataset(folder, workers);
  if (!report) return report.error();
  if (report->faults.empty()) {
    tell("{}: whole: {} files, {} bytes\n", folder.string(), report->files, report->bytes);
    return {};
  }
  std::string text;
  for (const std::string& fault : report->faults) text += fault + "\n";
  return Error{ErrorKind::damage,
               fmt::format("{}{}: {} faults", text, folder.string(), report->faults.size())};
}

}  // namespace ensonify
