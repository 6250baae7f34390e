// What exporters share. Private to export/.
//
//   ExportJob            the data set and the wishes of the user
//   for_each_sequence    for_each_exported_ping   every ping, in order, until the user stops it
//   item_name            000000_000003, for flat folders
//   need                 the Error for a kind of file that the data set has not
//   grey_of  mask_of_view   rows of the catalogue of the view that the user wants
//   path_of  is_rendered  the file of a row and a ping
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "dataset/read_dataset.h"
#include "dataset/render.h"
#include "export/export.h"

namespace ensonify {

struct ExportJob {
  const StoredDataset& dataset;
  const ExportOptions& options;
  const std::optional<RenderManifest>& render;

  PictureView view() const { return options.view.value_or(PictureView::cartesian); }
};

Status for_each_sequence(const ExportJob& job,
                         const std::function<Status(const StoredSequence&)>& use);

Status for_each_exported_ping(const ExportJob& job, const StoredSequence& sequence,
                              const std::function<Status(const StoredPing&)>& use);

std::string item_name(const StoredSequence& sequence, const StoredPing& ping);

// No error where every ping of the sequence has this file; else usage, with the key of the scenario
// that makes it.
Status need(const ExportJob& job, const StoredSequence& sequence, const CatalogueRow& row);

Result<std::filesystem::path> path_of(const ExportJob& job, const StoredSequence& sequence,
                                      const StoredPing& ping, const CatalogueRow& row);

const CatalogueRow& grey_of(const ExportJob& job);
const CatalogueRow& mask_of_view(const ExportJob& job, std::string_view plane);

// Whether the row is that of 8-bit images which come from the render.
bool is_rendered(const ExportJob& job, const CatalogueRow& row);

// The annotations of this ping's picture of the view.
Result<StoredPicture> picture_of_view(const ExportJob& job, const StoredSequence& sequence,
                                      const StoredPing& ping, PictureView view);

// The exporters, one a file.
Status write_yolo(const ExportJob& job, const std::filesystem::path& target);
Status write_voc(const ExportJob& job, const std::filesystem::path& target);
Status write_index_mask(const ExportJob& job, const std::filesystem::path& target);
Status write_tum(const ExportJob& job, const std::filesystem::path& target);
Status write_hdf5(const ExportJob& job, const std::filesystem::path& target);
Status write_webdataset(const ExportJob& job, const std::filesystem::path& target);
Status write_ply(const ExportJob& job, const std::filesystem::path& target);
Status write_mcap(const ExportJob& job, const std::filesystem::path& target);

}  // namespace ensonify
