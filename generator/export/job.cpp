#include "export/job.h"

#include <fmt/format.h>

#include "dataset/layout.h"

namespace ensonify {
Status for_each_sequence(const ExportJob& job,
                         const std::function<Status(const StoredSequence&)>& use) {
  for (const StoredSequenceRow& row : job.dataset.sequences) {
    const auto sequence = read_sequence(job.dataset, row);
    if (!sequence) return sequence.error();
    if (sequence->packed) {
      return Error{ErrorKind::usage,
                   job.dataset.dir.string() +
                       ": its pings are packed into arrays of each sequence; accepted are data "
                       "sets of output.one_file_per: ping"};
    }
    if (const Status used = use(*sequence); !used) return used;
  }
  return {};
}

Status for_each_exported_ping(const ExportJob& job, const StoredSequence& sequence,
                              const std::function<Status(const StoredPing&)>& use) {
  return for_each_ping(job.dataset, sequence, [&](const StoredPing& ping) -> Status {
    if (job.options.stop && job.options.stop()) {
      return Error{ErrorKind::interrupted, "interrupted; nothing was left behind"};
    }
    return use(ping);
  });
}

std::string item_name(const StoredSequence& sequence, const StoredPing& ping) {
  return fmt::format("{:06}_{:06}", sequence.row.sequence, ping.ping);
}

Status need(const ExportJob& job, const StoredSequence& sequence, const CatalogueRow& row) {
  if (is_rendered(job, row) || sequence.has(row)) return {};
  return Error{
      ErrorKind::usage,
      fmt::format(
          "{}: its pings have no {}, which this format needs; generate the data set with {}",
          (job.dataset.dir / layout::sequence_folder(sequence.row.sequence)).string(), row.file,
          row.maker)};
}

Result<std::filesystem::path> path_of(const ExportJob& job, const StoredSequence& sequence,
                                      const StoredPing& ping, const CatalogueRow& row) {
  if (!is_rendered(job, row)) {
    return ping_file(job.dataset, sequence.row.sequence, row.file, ping.ping);
  }
  const std::string relative = render_folder(job.render->name) + "/" +
                               render_file(*row.view, sequence.row.sequence, ping.ping);
  if (!listed_file_size(job.dataset.dir, relative)) {
    return damaged(job.dataset.dir / relative, "is missing, or is no file of this folder");
  }
  return job.dataset.dir / relative;
}

bool is_rendered(const ExportJob& job, const CatalogueRow& row) {
  return job.render && row.view && &row == &grey_row(*row.view);
}

const CatalogueRow& grey_of(const ExportJob& job) { return grey_row(job.view()); }
const CatalogueRow& mask_of_view(const ExportJob& job, std::string_view plane) {
  return plane_row(job.view(), plane);
}

Result<StoredPicture> picture_of_view(const ExportJob& job, const StoredSequence& sequence,
                                      const StoredPing& ping, PictureView view) {
  auto pictures = pictures_of(job.dataset, sequence, ping);
  if (!pictures) return pictures.error();
  for (StoredPicture& picture : *pictures) {
    if (picture.view == view_name(view)) return std::move(picture);
  }
  return damaged(job.dataset.dir / layout::in_sequence(sequence.row.sequence, layout::kAnnotations),
                 fmt::format("has no {} picture of ping {}", view_name(view), ping.ping));
}

}  // namespace ensonify
