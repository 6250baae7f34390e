#include "export/job.h"

#include <fmt/format.h>

#include <utility>

#include "dataset/layout.h"

namespace ensonify {
namespace {

// What in a scenario (or on the command line) makes a kind of file.
const char* advice_for(std::string_view name_template) {
  const std::pair<const char*, const char*> makers[] = {
      {layout::kTimeseries, "`output.timeseries: npy`"},
      {layout::kPolarExr, "`output.polar: true`"},
      {layout::kPolarInstance, "`output.polar: true`"},
      {layout::kPolarSemantic, "`output.polar: true`"},
      {layout::kCartesianExr, "`output.cartesian`"},
      {layout::kCartesianInstance, "`output.cartesian`"},
      {layout::kCartesianSemantic, "`output.cartesian`"},
      {layout::kPolarGrey, "`output.png: true`"},
      {layout::kCartesianGrey, "`output.png: true` and `output.cartesian`, or give --view polar"},
      {layout::kScatterers, "--export-scatterers"}};
  for (const auto& [name, maker] : makers) {
    if (name == name_template) return maker;
  }
  return "another `output`";
}

}  // namespace

Status for_each_sequence(const ExportJob& job,
                         const std::function<Status(const StoredSequence&)>& use) {
  for (const StoredSequenceRow& row : job.dataset.sequences) {
    const auto sequence = read_sequence(job.dataset, row);
    if (!sequence) return sequence.error();
    if (sequence->packed) {
      return Error{ErrorKind::usage,
                   job.dataset.dir.string() +
                       ": its pings are packed into arrays of each sequence; accepted are data "
                       "sets of output.pack: ping"};
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

Status need(const ExportJob& job, const StoredSequence& sequence, const char* name_template) {
  if (sequence.has(name_template)) return {};
  return Error{
      ErrorKind::usage,
      fmt::format(
          "{}: its pings have no {}, which this format needs; generate the data set with {}",
          (job.dataset.dir / layout::sequence_folder(sequence.row.sequence)).string(),
          name_template, advice_for(name_template))};
}

const char* view_name(PictureView view) {
  return view == PictureView::polar ? "polar" : "cartesian";
}
const char* grey_template(PictureView view) {
  return view == PictureView::polar ? layout::kPolarGrey : layout::kCartesianGrey;
}
const char* instance_template(PictureView view) {
  return view == PictureView::polar ? layout::kPolarInstance : layout::kCartesianInstance;
}
const char* semantic_template(PictureView view) {
  return view == PictureView::polar ? layout::kPolarSemantic : layout::kCartesianSemantic;
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
