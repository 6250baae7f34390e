// Checks of one file at a time for verify.cpp. Private to dataset/. Each returns the faults as text
// without the file's name; an empty text means none.
//
//   SequenceShape
//   content_fault                   presence, size and hash
//   format_fault                    a sequence's file against the sequence's shape
//   index_fault  split_fault        top-level tables against the pings
//   line_masks_fault  coco_fault    masks against their run lengths
//   RenderFindings  check_renders   renders/
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/parallel.h"
#include "dataset/catalogue.h"
#include "dataset/manifest.h"
#include "formats/files.h"
#include "formats/json.h"

namespace ensonify {

// Properties of a sequence, from sequence.json and dataset.json, on which its files depend.
struct SequenceShape {
  std::uint32_t sequence = 0;
  std::string split;
  std::uint64_t first_ping = 0, last_ping = 0;
  std::uint64_t instances = 0, boxes = 0;
  GridSizes sizes;
  bool labels = true;  // whether its images have label planes

  std::uint64_t pings() const { return sizes.pings; }
};

std::string content_fault(const std::filesystem::path& dir, const std::string& relative,
                          std::uint64_t bytes, const std::string& sha256);

// `name` inside the sequence's folder, `name_template` the same with {ping} (layout.h). An unknown
// file is not a fault here.
std::string format_fault(const std::filesystem::path& dir, const SequenceShape& shape,
                         const std::string& name, const std::string& name_template);

std::string index_fault(const std::filesystem::path& path,
                        const std::vector<SequenceShape>& shapes);

std::string split_fault(const std::filesystem::path& path, const std::string& split,
                        const std::vector<SequenceShape>& shapes);

// Checks area and box of every mask against its run lengths, and that no amodal mask is smaller
// than the visible one.
std::string line_masks_fault(const Json& line);

// The same for coco.json, with its lists against each other. `known`: the files that manifests
// list.
std::string coco_fault(const std::filesystem::path& path, const std::set<std::string>& known,
                       std::uint64_t classes);

// Paths are relative to the data set.
struct RenderFindings {
  std::vector<std::pair<std::string, std::string>> faults;  // file and what is wrong with it
  std::vector<std::string> files;                           // that a render lists, or is listed by
  std::uint64_t bytes = 0;

  // Does nothing if `fault` is empty.
  void add(const std::string& path, const std::string& fault);
};

// Checks every folder in renders/: the form of its manifest, that its sequences belong to the data
// set, and every image. Files of a render whose manifest is wrong are not in `files`. `entries`: of
// dataset.json.
RenderFindings check_renders(const std::filesystem::path& dir,
                             std::span<const SequenceShape> shapes,
                             std::span<const SequenceEntry> entries, const Workers& workers);

}  // namespace ensonify
