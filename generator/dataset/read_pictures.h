// Reads images and time series of a finished data set, from files of a ping or from packed arrays.
// Float planes of Cartesian images that are not stored follow from the polar image through the
// sequence's map, bit for bit.
//
//   read_cartesian_map            the polar pixel of each Cartesian pixel
//   can_read                      whether a sequence has the cells of a row of the catalogue
//   CellReader                    the cells of such a row
//   PlaneNames  stored_planes     which planes a sequence has
//   read_picture                  the requested planes of one ping's image
//   has_series  read_series       one ping's series
#pragma once

#include <complex>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "dataset/image_exr.h"
#include "dataset/read_dataset.h"

namespace ensonify {

using StoredView = ImageView;

// [rows x columns]: sample * beams + beam, or -1. Needs a Cartesian grid. Error (io): it is missing
// or damaged, or names a pixel that the polar image does not have.
Result<std::vector<std::int32_t>> read_cartesian_map(const StoredDataset& dataset,
                                                     const StoredSequence& sequence);

// Whether the cells are stored or follow from a polar image.
bool can_read(const StoredSequence& sequence, const CatalogueRow& row);

// Reads one ping of the sequence. It caches images and the map for other planes.
class CellReader {
 public:
  // The data set and the sequence must outlive it.
  CellReader(const StoredDataset& dataset, const StoredSequence& sequence, std::uint32_t ping);

  // The bytes of grid_shape(row, sequence.sizes()) cells of row.type. Needs can_read().
  // Error (io): a file is missing, damaged or of another size than the manifest says.
  Result<std::string> read(const CatalogueRow& row);

 private:
  template <class Planes, class Read>
  Result<std::string> read_exr_plane(const CatalogueRow& row, const std::filesystem::path& path,
                                     Read read_planes, std::map<std::string, Planes>& images);
  Result<std::string> read_through_map(const CatalogueRow& row);
  const StoredDataset& dataset_;
  const StoredSequence& sequence_;
  std::uint32_t ping_;
  std::map<std::string, ExrHalves> images_;  // by file
  std::map<std::string, ExrFloats> floats_;  // of groups and front views
  std::vector<std::int32_t> map_;  // empty: not read yet
};

// Of kImagePlanes.
using PlaneNames = std::set<std::string_view>;
PlaneNames stored_planes(const StoredSequence& sequence, ImageView view);

// Row 0 on top. Planes that were not requested or that the data set lacks are empty.
struct StoredPixels : ImagePlanes {
  std::uint64_t rows = 0, columns = 0;
};

// Needs a ping of the sequence. Error (io): as above.
Result<StoredPixels> read_picture(const StoredDataset& dataset, const StoredSequence& sequence,
                                  ImageView view, std::uint32_t ping, const PlaneNames& planes);

bool has_series(const StoredSequence& sequence);
// [beams x samples], Pa; empty where the data set has no series. Error (io): as above.
Result<std::vector<std::complex<float>>> read_series(const StoredDataset& dataset,
                                                     const StoredSequence& sequence,
                                                     std::uint32_t ping);

}  // namespace ensonify
