// Checks of one file at a time for verify.cpp. Private to dataset/. Each gives the faults it finds
// as text without the file's name; an empty text is no fault.
//
//   SequenceShape
//   content_fault                   there, size and hash
//   format_fault                    a sequence's file against the sequence's shape
//   index_fault  split_fault        top-level tables against the pings
//   line_masks_fault  coco_fault    masks against their run lengths
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/error.h"
#include "dataset/catalogue.h"
#include "formats/files.h"
#include "formats/json.h"

namespace ensonify {

// What sequence.json and dataset.json say of a sequence, as far as files depend on it.
struct SequenceShape {
  std::uint32_t sequence = 0;
  std::string split;
  std::uint64_t first_ping = 0, last_ping = 0;
  std::uint64_t instances = 0, boxes = 0;
  GridSizes sizes;

  std::uint64_t pings() const { return sizes.pings; }
};

std::string content_fault(const std::filesystem::path& dir, const std::string& relative,
                          std::uint64_t bytes, const std::string& sha256);

// `name` inside the sequence's folder, `name_template` the same with {ping} (layout.h). A file that
// ensonify does not know is no fault here.
std::string format_fault(const std::filesystem::path& dir, const SequenceShape& shape,
                         const std::string& name, const std::string& name_template);

std::string index_fault(const std::filesystem::path& path,
                        const std::vector<SequenceShape>& shapes);

std::string split_fault(const std::filesystem::path& path, const std::string& split,
                        const std::vector<SequenceShape>& shapes);

// Area and box of every mask against its run lengths; no amodal mask smaller than the visible one.
std::string line_masks_fault(const Json& line);

// The same of coco.json, and its lists against each other. `known`: the files that manifests list.
std::string coco_fault(const std::filesystem::path& path, const std::set<std::string>& known,
                       std::uint64_t classes);

}  // namespace ensonify
