// SPLIT/images, SPLIT/masks (class ids, 8 bits) and SPLIT/instances (16 bits) with the same names,
// and classes.txt, whose line k + 1 is class id k.
#include "dataset/layout.h"
#include "dataset/output.h"
#include "export/job.h"

namespace ensonify {
namespace fs = std::filesystem;
namespace {

Status copy_ping(const ExportJob& job, const fs::path& target, const StoredSequence& sequence,
                 const StoredPing& ping) {
  const std::pair<const char*, const char*> copies[] = {
      {"images", grey_template(job.view())},
      {"masks", semantic_template(job.view())},
      {"instances", instance_template(job.view())}};
  for (const auto& [folder, name_template] : copies) {
    const auto from = ping_file(job.dataset, sequence.row.sequence, name_template, ping.ping);
    if (!from) return from.error();
    const fs::path to = target / sequence.row.split / folder / (item_name(sequence, ping) + ".png");
    if (const Status copied = copy_whole(*from, to); !copied) return copied;
  }
  return {};
}

}  // namespace

Status write_index_mask(const ExportJob& job, const fs::path& target) {
  std::string names = "none\n";
  for (const std::string& name : job.dataset.classes) names += name + "\n";
  if (const Status written = write_whole(target / "classes.txt", names); !written) return written;
  return for_each_sequence(job, [&](const StoredSequence& sequence) -> Status {
    for (const char* file : {grey_template(job.view()), semantic_template(job.view()),
                             instance_template(job.view())}) {
      if (const Status there = need(job, sequence, file); !there) return there;
    }
    return for_each_exported_ping(job, sequence, [&](const StoredPing& ping) {
      return copy_ping(job, target, sequence, ping);
    });
  });
}

}  // namespace ensonify
