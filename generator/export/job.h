// Common parts of the exporters. Private to export/.
//
//   ObjectFilter  object_filter   which annotations are written
//   SweepRuns  ExportJob   the runs of a sweep; the data set and the user's options
//   for_each_sequence    for_each_exported_ping   every ping, in order, until the user stops it
//   ping_ns              time of a ping in nanoseconds
//   item_name            000000_000003, for flat folders; of a sweep after the id of the run
//   run_members          of a record: the run and the values of its axes; empty for a data set
//   plain_name           part of a file's name
//   splits_of            one, or all
//   need                 the Error for a kind of file that the data set lacks
//   grey_of  mask_of_view   rows of the catalog for the requested view
//   path_of  is_rendered  the file of a row and a ping
//   grey_pixels   of an 8-bit image
//   voc_palette   PASCAL VOC's colors, by index
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dataset/read_dataset.h"
#include "dataset/render_manifest.h"
#include "export/options.h"
#include "formats/json.h"
#include "formats/png.h"
#include "sweep/folder.h"

namespace ensonify {

struct ObjectFilter {
  std::vector<bool> classes;  // by class id - 1: whether it is written
  std::uint64_t min_pixels = 1;
  double min_visible = 0;
};

// Errors (usage): a name that is not a class of the data set.
Result<ObjectFilter> object_filter(const StoredDataset& dataset, const ExportOptions& options);

struct SweepRuns {
  Plan runs;                                      // to export
  std::function<Status(const PlannedRun&)> open;  // makes ExportJob::dataset and render its own
  const PlannedRun* current = nullptr;            // of these
};

struct ExportJob {
  const StoredDataset& dataset;
  const ExportOptions& options;
  const ObjectFilter& objects;
  const std::optional<RenderManifest>& render;
  // The exporter writes all runs at once: for_each_sequence goes through the sequences of each.
  const SweepRuns* sweep = nullptr;

  PictureView view() const { return options.view.value_or(PictureView::cartesian); }
};

Status for_each_sequence(const ExportJob& job,
                         const std::function<Status(const StoredSequence&)>& use);

Status for_each_exported_ping(const ExportJob& job, const StoredSequence& sequence,
                              const std::function<Status(const StoredPing&)>& use);

// Rounded. Error (usage): outside of 0 to 2^31 s, which formats with whole numbers for times need.
Result<std::uint64_t> ping_ns(const StoredSequence& sequence, const StoredPing& ping);

std::string item_name(const ExportJob& job, const StoredSequence& sequence, const StoredPing& ping);

// {"run": id, "axes": {name: value}}
Json run_members(const ExportJob& job);

// The characters that fit into `most` bytes, with _ in place of those other than letters of any
// script, digits, -, _ and .
std::string plain_name(std::string_view text, std::size_t most);

// The exported splits, in the order train, val, test.
std::vector<std::string> splits_of(const ExportJob& job);

// No error if every ping of the sequence has this file; otherwise usage, with the key of the
// scenario that enables it.
Status need(const ExportJob& job, const StoredSequence& sequence, const CatalogueRow& row);

Result<std::filesystem::path> path_of(const ExportJob& job, const StoredSequence& sequence,
                                      const StoredPing& ping, const CatalogueRow& row);

// Row-major, of a file of path_of: PNG, or JPEG of a render. Error (io): damaged, or another size.
Result<std::vector<std::uint8_t>> grey_pixels(const ExportJob& job,
                                              const std::filesystem::path& path, std::uint64_t rows,
                                              std::uint64_t columns);

Palette voc_palette();

const CatalogueRow& grey_of(const ExportJob& job);
const CatalogueRow& mask_of_view(const ExportJob& job, std::string_view plane);

// Whether the row is that of 8-bit images which come from the render.
bool is_rendered(const ExportJob& job, const CatalogueRow& row);

// The image of this ping and view, with the annotations that the filter keeps; their masks are not
// empty. Error (usage): a least visible share without amodal masks.
Result<StoredPicture> picture_of_view(const ExportJob& job, const StoredSequence& sequence,
                                      const StoredPing& ping, PictureView view);

}  // namespace ensonify
