// Checks of boxes and masks for verify.cpp. Private to dataset/. Faults are told as in
// verify_files.h.
//
//   line_masks_fault   a line of annotations.jsonl
//   coco_fault         coco.json
#pragma once

#include <cstdint>
#include <filesystem>
#include <set>
#include <string>

#include "dataset/json.h"

namespace ensonify {

// Area and box of every mask against its run lengths; no amodal mask smaller than the visible one.
std::string line_masks_fault(const Json& line);

// The same of coco.json, and its lists against each other. `known`: the files that manifests list.
std::string coco_fault(const std::filesystem::path& path, const std::set<std::string>& known,
                       std::uint64_t classes);

}  // namespace ensonify
